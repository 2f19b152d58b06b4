"""A day of footage at low resolution: do memory, open files and threads stay flat?

Made-up footage, a clip over and over, 160x120 at 5 frames a second. First one video of all the hours is
recorded. Then, hour by hour, a piece of each of three cameras is recorded, one pair calibrated, and the
network checked, all in one process. What a recording holds grows with its frames, and stands below the table.
"""

from __future__ import annotations

import gc
import os
import sys
import time
from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from tables import progress, table, write_json

import epibar
from epibar import Recording, synthetic

FPS = 5.0
SIZE = (160, 120)
CLIP = 1500
"""Frames before the clip begins again."""
PIECE = 150
"""Frames of each camera that an hour's check is made of."""


class Gauge:
    """Memory, open files and threads of this process, as the system counts them."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, float, int, int]] = []

    def look(self) -> None:
        """Measure now."""
        status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
        files = len(os.listdir("/proc/self/fd"))
        memory = int(status["VmRSS"].split()[0]) / 1024
        self.seen.append((time.monotonic(), memory, files, int(status["Threads"])))

    def rows(self, what: str) -> list[list[str]]:
        """Rows of the table: after the first tenth, when all is loaded, in the middle, and in the end."""
        last = len(self.seen) - 1
        places = {"start": last // 10, "middle": last // 2, "end": last}
        return [
            [f"{what}, {when}", f"{memory:.0f}", str(files), str(threads)]
            for when, (_, memory, files, threads) in ((w, self.seen[at]) for w, at in places.items())
        ]


def write_video(path: Path, masks: np.ndarray, frames: int) -> None:
    """Film the clip over and over, bright things before a grey scene with some noise."""
    random = np.random.default_rng(0)
    scene = random.integers(60, 120, (*masks.shape[1:], 3)).astype(np.uint8)
    clip = [np.where(mask[..., None] != 0, np.uint8(230), scene) for mask in masks]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), FPS, SIZE)
    if not writer.isOpened():
        raise SystemExit("OpenCV cannot write mp4v here")
    for frame in range(frames):
        writer.write(clip[frame % len(clip)])
    writer.release()


def whole_day(folder: Path, hours: float, masks: np.ndarray, gauge: Gauge) -> tuple[int, float]:
    """Record one video of all the hours; returns its frames and the megabytes that the recording holds."""
    frames = int(hours * 3600 * FPS)
    path = folder / "day.mp4"
    write_video(path, masks, frames)
    progress(f"{frames} frames in {path.stat().st_size >> 20} MB of video")
    parts = 0

    def look(_: str, share: float) -> None:
        nonlocal parts
        if share * 100 >= parts:
            parts += 1
            gauge.look()

    recording = epibar.record(path, lines=2000, progress=look)
    gauge.look()
    return recording.frames, sum(array.nbytes for array in recording.to_arrays().values()) / 2**20


def hour_by_hour(hours: int, masks: list[np.ndarray], gauge: Gauge) -> int:
    """Record, calibrate and check a piece of each hour; returns how often the network was found in place."""
    names = [f"cam{index + 1}" for index in range(len(masks))]

    def record(first: int) -> dict[str, Recording]:
        at = np.arange(first, first + PIECE) % CLIP
        return {
            name: Recording.from_masks(seen[at], fps=FPS, lines=1000, name=name)
            for name, seen in zip(names, masks, strict=True)
        }

    network = epibar.calibrate_network(record(0), time_offset=0.0)
    progress(f"network: {network.reason}")
    in_place = 0
    for hour in range(hours):
        recordings = record(hour * 61)
        epibar.calibrate(recordings["cam1"], recordings["cam2"], time_offset=0.0)
        in_place += network.check(recordings).ok
        gc.collect()
        gauge.look()
        progress(f"hour {hour + 1} of {hours}: {gauge.seen[-1][1]:.0f} MB")
    return in_place


def main() -> int:
    """Run it."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0, help="default: %(default)s")
    parser.add_argument("--json", type=Path, help="file for all of it")
    args = parser.parse_args()
    scene = synthetic.cubes(3, cameras=3, objects=5, frames=CLIP, size=SIZE, size_m=(0.25, 0.45))
    masks = [scene.masks(index) for index in range(3)]
    day, hourly = Gauge(), Gauge()
    with TemporaryDirectory() as name:
        frames, held = whole_day(Path(name), args.hours, masks[0], day)
    in_place = hour_by_hour(max(3, round(args.hours)), masks, hourly)
    rows = day.rows(f"one video of {args.hours:g} hours") + hourly.rows("hour by hour")
    print(table(["", "memory, MB", "open files", "threads"], rows))
    print(f"\nThe recording of {frames:,} frames itself holds {held:.0f} MB.")
    write_json(args.json, args, [], {"frames": frames, "held": held, "in place": in_place, "rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
