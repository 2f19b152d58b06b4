"""Fingerprints of the files that the demo writes, to show that a change of the code's shape changed none.

Prints a hash and a name for each: videos, recordings, calibrations, calibration.json, frontier points,
pictures, the report, and the table of errors against the known answer; without paths, times and versions,
which differ from run to run. Run it with the package as it was and as it is, and compare the two outputs.
"""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from epibar.cli import main as command_line

MADE_ON_THE_WAY = ("epibar_key", "epibar_seconds")
"""Entries of kept files that hold paths and times."""


def digest(value: Any) -> str:
    """Hash of arrays, texts or JSON values."""
    found = hashlib.sha256()
    if isinstance(value, dict) and all(isinstance(item, np.ndarray) for item in value.values()):
        for name in sorted(value):
            array = np.ascontiguousarray(value[name])
            found.update(f"{name} {array.dtype} {array.shape}".encode() + array.tobytes())
    else:
        found.update(json.dumps(value, sort_keys=True).encode())
    return found.hexdigest()[:16]


def demo(seed: int) -> Iterator[tuple[str, str]]:
    """Every file that the demo writes, but for paths, times and versions."""
    with tempfile.TemporaryDirectory() as folder:
        printed = StringIO()
        with redirect_stdout(printed), redirect_stderr(StringIO()):
            code = command_line(["demo", "--out", folder, "--seed", str(seed)])
        yield "demo: exit code", str(code)
        table = [line for line in printed.getvalue().splitlines() if "  accepted  " in line]
        yield "demo: against the known answer", digest(table)
        for path in sorted(Path(folder).rglob("*")):
            if path.is_file():
                yield f"demo: {path.relative_to(folder)}", content(path, folder)


def content(path: Path, folder: str) -> str:
    """Hash of a file of the demo in a folder."""
    if path.name == "calibration.json":
        found = json.loads(path.read_text())
        for camera in found["cameras"]:
            del camera["file"]
        return digest([found["cameras"], found["pairs"], found["errors"]])
    if path.suffix == ".json":
        found = json.loads(path.read_text())
        return digest({name: value for name, value in found.items() if name not in MADE_ON_THE_WAY})
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return digest({name: arrays[name] for name in arrays if name not in MADE_ON_THE_WAY})
    if path.suffix == ".html":
        return digest(re.sub(r'"seconds":[\d.]+', "", path.read_text(encoding="utf-8")))
    return digest(path.read_bytes().replace(folder.encode(), b"").hex())


def main() -> None:
    """Print all fingerprints."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=3, help="of the demo; default: %(default)s")
    for name, fingerprint in demo(parser.parse_args().seed):
        print(f"{fingerprint}  {name}", flush=True)


if __name__ == "__main__":
    main()
