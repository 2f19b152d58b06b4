"""What to plan with: minutes of footage in a minute, memory, how time grows with frames, lines and cameras.

Each measurement is a process of its own on so many cores. Run as a program, ``plan.py KIND ... CORES``, it
is that process: it prints its seconds and its peak memory in megabytes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from machine import memory_mb
from table import Stage

SIZES = ((640, 480), (1280, 720), (1920, 1080), (3840, 2160))
RECORDED = {(3840, 2160): 150}
"""Frames of a video, where these are fewer than :data:`FRAMES`."""

FRAMES, FPS = 300, 25.0
LENGTHS = (500, 1000, 2000)
LINES = (5000, 60000)
CAMERAS = (3, 4, 6)
PAIR = (640, 480)
"""Size of the masks of pairs and networks."""


def plan_stages() -> list[Stage]:
    """Footage by size and cores; pairs by frames and by lines; networks by cameras."""
    cores = sorted({1, os.cpu_count() or 1})
    stages = [stage for size in SIZES for stage in _recorded(size, cores)]
    stages += [_calibrated(2, frames, 20000, cores[-1]) for frames in LENGTHS]
    stages += [_calibrated(2, 1000, lines, cores[-1]) for lines in LINES]
    return stages + [_calibrated(cameras, 800, 20000, cores[-1]) for cameras in CAMERAS]


def _measured(*words: object) -> tuple[float, float]:
    """Seconds and megabytes of a process."""
    command = [sys.executable, __file__, *map(str, words)]
    run = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    seconds, peak = (float(part) for part in run.stdout.split()[-2:])
    return seconds, peak


def _recorded(size: tuple[int, int], cores: list[int]) -> Iterator[Stage]:
    """One video, on each number of cores."""
    frames = RECORDED.get(size, FRAMES)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "cam1.mp4"
        _measured("render", *size, frames, video, os.cpu_count() or 1)
        for count in cores:
            seconds, peak = _measured("record", video, count)
            footage = f"{frames / FPS / seconds:.2f}"
            notes = {f"minutes of footage at {FPS:.0f} frames a second in a minute": footage}
            name = f"record {size[0]}x{size[1]}, {_of(count)}"
            yield Stage(name, "frames", frames, seconds, notes=notes | _memory(peak))


def _calibrated(cameras: int, frames: int, lines: int, cores: int) -> Stage:
    """A pair, or a network of more cameras, of masks that were recorded before."""
    with tempfile.TemporaryDirectory() as folder:
        _measured("masks", cameras, frames, lines, folder, os.cpu_count() or 1)
        seconds, peak = _measured("calibrate", folder, cores)
    what = "pair" if cameras == 2 else f"network of {cameras} unknown cameras"
    name = f"{what}, {frames} frames, {lines:,} lines, {_of(cores)}"
    return Stage(name, "cameras", cameras, seconds, notes=_memory(peak))


def _of(cores: int) -> str:
    return "one core" if cores == 1 else f"{cores} cores"


def _memory(peak: float) -> dict[str, str]:
    return {"peak memory": f"{peak:.0f} MB"}


def _render(width: str, height: str, frames: str, path: str) -> None:
    """Eight walkers, as a video that begins with an empty scene of a second."""
    from epibar import synthetic

    scene = synthetic.people(1, cameras=1, frames=int(frames) - 25, size=(int(width), int(height)))
    synthetic.render_video(scene, 0, Path(path), seed=1)


def _record(path: str) -> float:
    import epibar

    started = time.perf_counter()
    epibar.record(path, progress=False)
    return time.perf_counter() - started


def _masks(cameras: str, frames: str, lines: str, folder: str) -> None:
    """Record masks of eight walkers, so that drawing them counts for nothing."""
    import epibar
    from epibar import synthetic

    scene = synthetic.people(1, cameras=int(cameras), frames=int(frames), size=PAIR)
    for k in range(int(cameras)):
        recording = epibar.Recording.from_masks(scene.masks(k), fps=FPS, lines=int(lines), seed=k)
        recording.save(Path(folder) / f"cam{k + 1}.npz")


def _calibrate(folder: str) -> float:
    """A pair, or a network of more."""
    import epibar

    recordings = {path.stem: epibar.Recording.load(path) for path in sorted(Path(folder).glob("*.npz"))}
    started = time.perf_counter()
    if len(recordings) == 2:
        epibar.calibrate(*recordings.values())
    else:
        epibar.calibrate_network(recordings, time_offset=0.0)
    return time.perf_counter() - started


def _main(kind: str, *rest: str) -> None:
    *words, cores = rest
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: int(cores)])
    do: dict[str, Callable[..., float | None]] = {
        "render": _render,
        "record": _record,
        "masks": _masks,
        "calibrate": _calibrate,
    }
    print(do[kind](*words) or 0.0, memory_mb("VmHWM"))


if __name__ == "__main__":
    _main(*sys.argv[1:])
