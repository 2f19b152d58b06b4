"""Fingerprints of results, to show that a change of the code's shape changed none of them.

Prints one line a case, a name and a hash of every number that came out: of the demo, of twenty made-up pairs
and of the real recordings where they are at hand. Run it with the package as it was and as it is, and compare
the two outputs. Only public names are used, so that it runs on both.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
import tempfile
from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

import epibar
from epibar import synthetic
from epibar.cli import main as command_line

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
LINES = 6000
REAL = {
    "four_people": ("cam{}.avi", range(1, 4), True),
    "hand_over_desk": ("cam{}.mp4", range(2), False),
    "man_at_desk": ("cam_{}.mp4", range(2), False),
    "room_of_people": ("walking_cam{}.npz", range(1, 3), True),
    "pets_cameras": ("cam{}.npz", range(1, 4), True),
    "wildtrack": ("cam{}.npz", range(1, 4), True),
}
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


def calibration_digest(calibration: epibar.Calibration) -> str:
    """Hash of everything a calibration holds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pair.npz"
        calibration.save(path)
        with np.load(path) as arrays:
            return digest(dict(arrays))


def made_up(count: int) -> Iterator[tuple[str, str]]:
    """Pairs that differ in kind, dirt, method, clocks and what is known of the cameras."""
    for seed in range(count):
        options: dict[str, Any] = {
            "cameras": 2,
            "frames": 250,
            "size": (240, 180),
            "asymmetric": seed % 2 == 0,
        }
        scene = (
            synthetic.cubes(seed, objects=8, dirty=seed % 3 == 0, **options)
            if seed % 4 == 0
            else synthetic.people(seed, walkers=3 + seed % 4, dirty=seed % 3 == 0, **options)
        )
        known = seed % 5 == 1
        recordings = [
            epibar.Recording.from_masks(
                scene.masks(index),
                fps=scene.fps,
                lines=3000,
                seed=index,
                name=f"cam{index}",
                matrix=camera.K if known else None,
            )
            for index, camera in enumerate(scene.cameras)
        ]
        calibration = epibar.calibrate(
            *recordings,
            method="lines" if seed % 7 == 3 else "frontier",
            seed=seed,
            time_offset="search" if seed % 6 == 5 else 0.0,
            upright=seed % 8 != 6,
        )
        yield f"made {seed}: recordings", digest([digest(one.to_arrays()) for one in recordings])
        yield f"made {seed}: {calibration.kind}", calibration_digest(calibration)
        diagnoses = [epibar.inspect(one).as_dict() for one in recordings]
        yield f"made {seed}: inspected", digest(diagnoses)


def real(data: Path) -> Iterator[tuple[str, str]]:
    """Pairs of every real recording that is at hand."""
    for folder, (pattern, numbers, masks) in REAL.items():
        if not (data / folder).exists():
            print(f"{folder}: not at {data}", file=sys.stderr)
            continue
        recordings = [
            epibar.record(
                data / folder / pattern.format(number),
                lines=LINES,
                seed=number,
                name=Path(pattern.format(number)).stem.removeprefix("walking_"),
                masks=masks,
                intrinsics=data / folder / "cameras.toml",
                progress=False,
            )
            for number in numbers
        ]
        for one in recordings:
            yield f"{folder}: {one.name}", digest(one.to_arrays())
        for a, b in combinations(recordings, 2):
            calibration = epibar.calibrate(a, b)
            yield f"{folder}: {a.name} - {b.name}: {calibration.kind}", calibration_digest(calibration)


def demo() -> Iterator[tuple[str, str]]:
    """Every file that the demo writes, but for paths, times and versions."""
    with tempfile.TemporaryDirectory() as folder:
        printed = StringIO()
        with redirect_stdout(printed), redirect_stderr(StringIO()):
            code = command_line(["demo", "--out", folder, "--seed", "3"])
        yield "demo: exit code", str(code)
        table = [line for line in printed.getvalue().splitlines() if "  accepted  " in line]
        yield "demo: against the known answer", digest(table)
        for path in sorted(Path(folder).rglob("*")):
            if path.is_file():
                yield f"demo: {path.relative_to(folder)}", content(path)


def content(path: Path) -> str:
    """Hash of a file of the demo."""
    if path.name == "calibration.json":
        found = json.loads(path.read_text())
        for camera in found["cameras"]:
            del camera["file"]
        return digest([found["cameras"], found["pairs"], found["errors"]])
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return digest({name: arrays[name] for name in arrays if name not in MADE_ON_THE_WAY})
    if path.suffix == ".html":
        return digest(re.sub(r'"seconds":[\d.]+', "", path.read_text(encoding="utf-8")))
    return digest(path.read_bytes().hex())


def main() -> None:
    """Print all fingerprints."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=20, help="made-up pairs; default: %(default)s")
    parser.add_argument("--parts", default="made,real,demo", help="default: %(default)s")
    parser.add_argument("--data", type=Path, default=DATA, help="real recordings; default: %(default)s")
    given = parser.parse_args()
    parts = {"made": lambda: made_up(given.pairs), "real": lambda: real(given.data), "demo": demo}
    for part in given.parts.split(","):
        for case, fingerprint in parts[part]():
            print(f"{fingerprint}  {case}", flush=True)


if __name__ == "__main__":
    main()
