"""Coverage-guided fuzzing of one reader by Atheris: ``python tests/fuzz_readers.py network -runs=1000 DIR``.

Behind the name of a function of ``fuzzed.py`` come libFuzzer's options and folders of inputs, the first of
which takes what is new. ``make fuzz`` runs all of them.
"""

import sys
import warnings

import atheris

with atheris.instrument_imports(include=["epibar", "zipfile", "tomllib", "json", "csv", "numpy.lib"]):
    import fuzzed

if __name__ == "__main__":
    warnings.simplefilter("error")
    run = {function.__name__: function for function in fuzzed.ALL}[sys.argv.pop(1)]

    def tried(data):
        run(data)

    atheris.Setup(sys.argv, tried)
    atheris.Fuzz()
