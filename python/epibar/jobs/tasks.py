"""The two tasks of a job. Plain functions of plain data: they run in any thread, process or machine.

Only recordings travel: a video is opened by the task that records it, and nowhere else.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from ..calibration import Calibration, calibrate
from ..from_video import record
from ..recording import Recording
from .inputs import CameraInput, PairOptions, RecordOptions
from .saved_recordings import load_saved

__all__ = ["calibrate_pair", "record_camera"]

Progress = Callable[[str, float], None]


def record_camera(
    camera: CameraInput, options: RecordOptions, progress: Progress | bool = False, pictures: bool = True
) -> tuple[Recording, float]:
    """Record one camera, or load it where it was recorded before; also returns the seconds it took.

    What is recorded has ``pictures``, so that nobody need open the video again.

    Raises
    ------
    EpibarError
        The source cannot be read, does not fit its intrinsics, background or ignore mask, or is a recording
        of other frames than the options ask for.
    """
    started = time.perf_counter()
    if camera.is_saved(options):
        recording = load_saved(camera, options)
        recording.name = camera.name
    else:
        recording = record(
            camera.source,
            lines=options.lines,
            seed=options.seed,
            name=camera.name,
            masks=options.masks,
            background=camera.background,
            foreground=options.foreground,
            intrinsics=camera.intrinsics,
            ignore=camera.ignore,
            fps=options.fps,
            frames=(options.frames.first, options.frames.last),
            seconds=options.frames.seconds,
            chapters=options.chapters,
            pictures=pictures,
            progress=progress,
        )
    return recording, time.perf_counter() - started


def calibrate_pair(
    a: Recording, b: Recording, options: PairOptions, progress: Progress | None = None
) -> tuple[Calibration, float]:
    """Calibrate one pair; also returns the seconds it took.

    Raises
    ------
    EpibarError
        An option does not fit the recordings.
    """
    started = time.perf_counter()
    calibration = calibrate(
        a,
        b,
        method=options.method,
        seed=options.seed,
        time_offset=options.time_offset,
        upright=options.upright,
        essential=options.essential,
        search_seconds=options.search_seconds,
        sharpen_offset=options.sharpen_offset,
        max_expected_error=options.max_expected_error,
        progress=progress,
    )
    return calibration, time.perf_counter() - started
