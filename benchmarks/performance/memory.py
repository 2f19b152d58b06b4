"""Peak memory of recording 1920x1080 video, short and long: each in a process of its own.

Run as a program, ``memory.py FRAMES``, it is that process: it records a made-up video of so many frames and
prints its peak memory in megabytes and the seconds it took.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from machine import memory_mb
from table import Stage

SIZE = (1920, 1080)
LOOP = 100
"""Frames after which the made-up video repeats itself."""


def memory_stage(frames: int) -> Stage:
    """Record so many frames and tell the peak."""
    run = subprocess.run(
        [sys.executable, __file__, str(frames)], stdout=subprocess.PIPE, text=True, check=True
    )
    peak, seconds = (float(part) for part in run.stdout.split())
    name = f"record, {SIZE[0]}x{SIZE[1]}, {frames:,} frames"
    return Stage(name, "frames", frames, seconds, notes={"peak memory": f"{peak:.0f} MB"})


def _write(path: Path, frames: int) -> None:
    """Squares that wander before a noisy background."""
    rng = np.random.default_rng(0)
    width, height = SIZE
    empty = cv2.resize(rng.integers(60, 180, (68, 120, 3), np.uint8), SIZE)
    writer: Any = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 25.0, SIZE)
    if not writer.isOpened():
        raise OSError("this OpenCV cannot write mp4v")
    pictures = []
    for t in range(LOOP):
        image = empty.copy()
        for i in range(8):
            x = int((0.5 + 0.45 * np.sin(2 * np.pi * (t / LOOP + i / 8))) * (width - 200))
            y = int((0.5 + 0.45 * np.cos(2 * np.pi * ((1 + i % 3) * t / LOOP + i / 5))) * (height - 300))
            cv2.rectangle(image, (x, y), (x + 120, y + 260), (30 * i, 255 - 25 * i, 40), -1)
        pictures.append(image)
    for frame in range(frames):
        writer.write(pictures[frame % LOOP])
    writer.release()


def _main(frames: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.mp4"
        # Written by another process, whose memory does not count.
        subprocess.run([sys.executable, __file__, str(frames), str(path)], check=True)
        import epibar

        started = time.perf_counter()
        rec = epibar.record(path, progress=False)
        seconds = time.perf_counter() - started
        if rec.frames != frames:
            raise AssertionError(f"{rec.frames} frames")
        print(memory_mb("VmHWM"), seconds)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        _write(Path(sys.argv[2]), int(sys.argv[1]))
    else:
        _main(int(sys.argv[1]))
