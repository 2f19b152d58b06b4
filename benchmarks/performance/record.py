"""Where the time of a recording goes: CPU seconds by stage, beside decoding and OpenCV's MOG2 of one file.

CPU seconds, since stages run beside one another and wall time is that of whatever else the machine does.
"""

from __future__ import annotations

import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
from table import Stage
from whole import decode

import epibar
from epibar import synthetic
from epibar.foreground import Foreground
from epibar.health.camera_health import CameraHealth
from epibar.recording import DEFAULT_LINES, MIN_COMPONENT_AREA, new_recorder
from epibar.sources.colour_frames import ColourFrames
from epibar.sources.picture_taking import PictureTaker

ROUNDS = 2


def record_stages(frames: int, size: tuple[int, int]) -> list[Stage]:
    """Render a video of eight walkers and record it, as a whole and stage by stage."""
    with tempfile.TemporaryDirectory() as folder:
        scene = synthetic.people(1, cameras=1, frames=frames - 25, size=size)
        video = synthetic.render_video(scene, 0, Path(folder) / "cam1.mp4", seed=1)
        least: dict[str, float] = {}
        for _ in range(ROUNDS):
            for name, seconds in _one_round(video).items():
                least[name] = min(seconds, least.get(name, seconds))
    name = f"{size[0]}x{size[1]}x{frames}"
    whole, peer = least.pop("record"), least.pop("decode and MOG2")
    notes = {"times decoding and MOG2, CPU": f"{whole / peer:.2f}"}
    notes["times decoding and MOG2, wall"] = f"{least.pop('record, wall') / least.pop('MOG2, wall'):.2f}"
    alone = {"decoding alone, CPU": least.pop("decode"), "decoding and MOG2, CPU": peer}
    stages = [Stage(f"record {name}, CPU", "frames", frames, whole, peers=alone, notes=notes)]
    return stages + [
        Stage(f"record {name}: {stage}, CPU", "frames", frames, seconds) for stage, seconds in least.items()
    ]


def _one_round(video: Path) -> dict[str, float]:
    """CPU seconds by stage, and of the whole; wall seconds of what is compared."""
    cpu: dict[str, float] = defaultdict(float)

    @contextmanager
    def timed(stage: str) -> Iterator[None]:
        started = time.process_time()
        yield
        cpu[stage] += time.process_time() - started

    wall = time.perf_counter()
    with timed("decode and MOG2"):
        decode(video, True)
    cpu["MOG2, wall"] = time.perf_counter() - wall
    with timed("decode"):
        decode(video, False)
    wall = time.perf_counter()
    with timed("record"):
        epibar.record(video, progress=False)
    cpu["record, wall"] = time.perf_counter() - wall

    with ColourFrames(video) as frames:
        with timed("the empty scene"):
            foreground = Foreground.for_frames(frames)
        health = CameraHealth("camera")
        health.count(foreground.counted)
        recorder = new_recorder(*frames.size, DEFAULT_LINES, 0, MIN_COMPONENT_AREA)
        taker = PictureTaker(frames.frame_count, frames.fps)
        moments = iter(frames)
        while True:
            with timed("decoding"):
                moment = next(moments, None)
            if moment is None:
                break
            index, at, frame = moment
            with timed("model"):
                moving = foreground.moving(frame)
            with timed("filters"):
                mask = foreground.clean(moving)
            with timed("health of the camera"):
                mask = health.update(index, frame, mask)
            with timed("components, hulls, packing"):
                recorder.push(mask, at)
            with timed("pictures for the report, if asked for"):
                taker.look(index, at, mask, partial(np.copy, frame))
        with timed("barcodes"):
            recorder.finish()
    return cpu
