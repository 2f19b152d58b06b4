"""The whole job beside playing, decoding, and OpenCV's background model: from the command to the report.

Videos of a made-up crowd that were started by hand are rendered into ``--cache``, once. ``epibar calibrate``
runs on them in a process of its own, into an empty folder. Seconds are wall seconds with all cores, measured
one after the other, so on a machine with other work only ratios count.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
from options import natural
from tables import progress, table

from epibar.synthetic.staging import stage


@dataclass(frozen=True)
class Job:
    """What the command did."""

    wall: float
    cpu: float
    memory: float
    """MB at the peak."""
    accepted: list[bool]
    pairs: int


def videos(args: Namespace) -> list[Path]:
    """Render what is not there yet."""
    width, height = args.size
    folder = args.cache / f"{args.cameras}x{args.seconds}s_{width}x{height}_{args.seed}"
    paths = [folder / f"cam{index + 1}.mp4" for index in range(args.cameras)]
    missing = [index for index, path in enumerate(paths) if not path.exists()]
    if missing:
        folder.mkdir(parents=True, exist_ok=True)
        staging = stage(
            args.seed,
            cameras=args.cameras,
            walkers=args.walkers,
            seconds=float(args.seconds),
            size=args.size,
            unsynchronised=True,
        )
        for index in missing:
            progress(f"rendering {paths[index]}")
            staging.render(index, paths[index].with_name(f"unfinished_{index}.mp4")).rename(paths[index])
    return paths


def decode(paths: list[Path], model: bool) -> None:
    """Decode every video, and give its frames to MOG2 as OpenCV has it."""
    for path in paths:
        capture = cv2.VideoCapture(str(path))
        subtractor = cv2.createBackgroundSubtractorMOG2(500, 25.0, True)
        while True:
            ok, frame = capture.read()
            if not ok:
                break
            if model:
                subtractor.apply(frame)
        capture.release()


def seconds_of(work: Callable[[], object]) -> float:
    """Wall seconds that it takes."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def job(paths: list[Path], out: Path) -> Job:
    """Run ``epibar calibrate`` with its defaults."""
    command = [sys.executable, "-m", "epibar", "calibrate", *map(str, paths), "--out", str(out)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    started = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True)
    wall = time.perf_counter() - started
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if not (out / "calibration.json").exists():
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
    found = json.loads((out / "calibration.json").read_text())
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    cameras = found["network"]["cameras"]
    return Job(
        wall, cpu, after.ru_maxrss / 1024, [bool(one["accepted"]) for one in cameras], len(found["pairs"])
    )


def main() -> None:
    """Run it, and print one table."""
    parser = ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cameras", type=natural, default=4)
    parser.add_argument("--walkers", type=natural, default=8)
    parser.add_argument("--seconds", type=natural, default=60, help="of each video (default %(default)s)")
    parser.add_argument("--size", type=natural, nargs=2, default=(1920, 1080), metavar=("W", "H"))
    parser.add_argument("--seed", type=natural, default=1, help="of the crowd (default %(default)s)")
    parser.add_argument("--cache", type=Path, default=Path("build/whole_job"), help="default %(default)s")
    args = parser.parse_args()
    args.size = tuple(args.size)
    paths = videos(args)
    captures = [cv2.VideoCapture(str(path)) for path in paths]
    lengths = [one.get(cv2.CAP_PROP_FRAME_COUNT) / one.get(cv2.CAP_PROP_FPS) for one in captures]
    frames = sum(int(one.get(cv2.CAP_PROP_FRAME_COUNT)) for one in captures)
    with TemporaryDirectory() as folder:
        whole = job(paths, Path(folder) / "out")
    decoding = seconds_of(lambda: decode(paths, model=False))
    model = seconds_of(lambda: decode(paths, model=True))
    playing = max(lengths)
    rows = [
        ["playing one video", f"{playing:.0f}", "1.00"],
        ["decoding all", f"{decoding:.0f}", f"{decoding / playing:.2f}"],
        ["decoding all, and OpenCV's MOG2", f"{model:.0f}", f"{model / playing:.2f}"],
        ["`epibar calibrate`, the report included", f"{whole.wall:.0f}", f"{whole.wall / playing:.2f}"],
    ]
    print(table(["what", "wall seconds", "times playing"], rows))
    size, load = "{}x{}".format(*args.size), os.getloadavg()[0]
    print(f"\n{len(paths)} videos, {frames} frames of {size}; {os.cpu_count()} cores, load {load:.1f} then.")
    print(f"The command computed for {whole.cpu:.0f} s and held {whole.memory:.0f} MB at the peak.")
    print(f"{whole.pairs} pairs; {sum(whole.accepted)} of {len(whole.accepted)} cameras accepted.")


if __name__ == "__main__":
    main()
