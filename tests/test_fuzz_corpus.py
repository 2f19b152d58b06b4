"""What coverage-guided fuzzing of the readers has come upon, replayed without a fuzzer."""

from pathlib import Path

import fuzzed
import pytest

CORPUS = Path(__file__).parent / "corpus"


@pytest.mark.parametrize("function", fuzzed.ALL, ids=lambda function: function.__name__)
def test_every_file_of_the_corpus(function):
    files = sorted((CORPUS / function.__name__).glob("*"))
    assert files
    for path in files:
        try:
            function(path.read_bytes())
        except Exception as error:
            error.add_note(str(path))
            raise
