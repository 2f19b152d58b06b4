"""How long a user waits before anything happens: ``import epibar``, and ``epibar --help``.

Each way is started again and again in turn with the others, and a bare ``python -c pass`` too, so that ratios
within one run mean something on a busy machine. ``--beside`` names a folder that holds another version of the
package, such as the ``python`` of an older checkout.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from argparse import ArgumentParser
from pathlib import Path
from statistics import median

from tables import table

WAYS = {
    "python -c pass": ["-c", "pass"],
    "import epibar": ["-c", "import epibar"],
    "epibar --help": ["-m", "epibar", "--help"],
    "epibar calibrate --help": ["-m", "epibar", "calibrate", "--help"],
    "epibar --version": ["-m", "epibar", "--version"],
}


def seconds(words: list[str], package: Path | None) -> float:
    """Start Python once, with the installed package or that of a folder."""
    # Nothing of the folder that this is started in is imported.
    given = {"PYTHONSAFEPATH": "1"} | ({} if package is None else {"PYTHONPATH": str(package)})
    started = time.perf_counter()
    subprocess.run([sys.executable, *words], env=os.environ | given, check=True, capture_output=True)
    return time.perf_counter() - started


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=20, help="default %(default)s")
    parser.add_argument("--beside", type=Path, metavar="FOLDER", help="another version, in this folder")
    args = parser.parse_args()
    if args.beside and not (args.beside / "epibar" / "__init__.py").exists():
        raise SystemExit(f"--beside {args.beside}: holds no package epibar")
    versions: dict[str, Path | None] = {"ms": None}
    if args.beside:
        versions["ms, beside"] = args.beside.resolve()
    found: dict[tuple[str, str], list[float]] = {}
    for _ in range(args.rounds):
        for way, words in WAYS.items():
            for name, package in versions.items():
                found.setdefault((way, name), []).append(1000 * seconds(words, package))
    columns = [f"{name}: {of}" for name in versions for of in ("least", "median")]
    rows = [
        [way, *(f"{of(found[way, name]):.0f}" for name in versions for of in (min, median))] for way in WAYS
    ]
    print(table(["what", *columns], rows))


if __name__ == "__main__":
    main()
