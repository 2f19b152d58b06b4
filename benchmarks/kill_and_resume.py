"""A run of all pairs is killed at random moments and started again: same bytes, nothing finished twice."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tables import progress, table, write_json

from epibar import synthetic

CAMERAS = 4


def write_masks(folder: Path) -> list[str]:
    """Draw the masks of every camera."""
    scene = synthetic.cubes(3, cameras=CAMERAS, objects=12, frames=200, size=(160, 120), size_m=(0.25, 0.45))
    paths = [folder / f"cam{index + 1}.npz" for index in range(CAMERAS)]
    for index, path in enumerate(paths):
        np.savez_compressed(path, masks=scene.masks(index), fps=scene.fps)
    return list(map(str, paths))


def results(out: Path) -> dict[str, bytes]:
    """Every file that holds no times: calibration.json, points, pictures."""
    found = (path for path in out.rglob("*") if path.suffix in (".json", ".csv", ".png"))
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in sorted(found)}


def kept(out: Path) -> dict[Path, int]:
    """When each recording and each pair that is there was written."""
    return {path: path.stat().st_mtime_ns for path in out.glob("*/*.npz")}


def main() -> int:
    """Run it."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    parser.add_argument("--scheduler", help="of Dask, or 'local', as for epibar calibrate")
    parser.add_argument("--json", type=Path, help="file for all of it")
    args = parser.parse_args()
    moments = random.Random(args.seed)
    same = killed = repeated = left = 0
    with TemporaryDirectory() as name:
        folder = Path(name)
        videos = write_masks(folder)
        words = [sys.executable, "-m", "epibar", "calibrate", *videos, "--masks", "--lines", "4000"]
        words += ["--method", "lines", "--no-report", "--quiet"]
        words += [] if args.scheduler is None else ["--scheduler", args.scheduler]
        started = time.monotonic()
        subprocess.run([*words, "--out", str(folder / "whole")], check=True)
        took = time.monotonic() - started
        expected = results(folder / "whole")
        out = folder / "out"
        for number in range(args.kills):
            shutil.rmtree(out, ignore_errors=True)
            process = subprocess.Popen([*words, "--out", str(out)], start_new_session=True)
            time.sleep(moments.uniform(0.0, took))
            os.killpg(process.pid, signal.SIGKILL)
            killed += process.wait() == -signal.SIGKILL
            before = kept(out)
            subprocess.run([*words, "--out", str(out)], check=True)
            after = kept(out)
            repeated += sum(after[path] != when for path, when in before.items())
            left += len(list(out.rglob("*.epibar-part")))
            same += results(out) == expected
            progress(f"{number + 1} of {args.kills}: {same} with the same bytes")
    numbers = {"runs": args.kills, "killed": killed, "same bytes": same}
    numbers |= {"finished work repeated": repeated, "left-over files": left}
    print(table(list(numbers), [list(map(str, numbers.values()))]))
    write_json(args.json, args, [], numbers)
    return 0 if same == args.kills and not repeated and not left else 1


if __name__ == "__main__":
    sys.exit(main())
