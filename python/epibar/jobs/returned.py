"""What came back from a task, which may have run on a machine that is broken, or lies.

A recording is made of its arrays again on the way, with every check of a file. Here it is held against what
was asked for, so that no result of another camera or pair is taken.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..calibration import Calibration
from ..errors import EpibarError
from ..files.calibration_npz import to_arrays
from ..recording import Recording
from .inputs import CameraInput, PairOptions, RecordOptions

__all__ = ["checked_calibration", "checked_recording"]

MARGIN = 2
"""Pixels that a point may lie outside of its image."""


def _taken_apart(value: Any, kind: type, what: str) -> tuple[Any, float]:
    if not isinstance(value, tuple) or len(value) != 2 or not isinstance(value[0], kind):
        raise EpibarError(f"what ran the task returned no {what}; its result is not used")
    seconds = value[1]
    if not isinstance(seconds, float) or not 0 <= seconds < math.inf:
        raise EpibarError(f"what ran the task says that it took {seconds!r} seconds; its result is not used")
    return value[0], seconds


def checked_recording(value: Any, camera: CameraInput, options: RecordOptions) -> tuple[Recording, float]:
    """Return a recording and the seconds it took, if it is one of that camera as was asked for.

    Raises
    ------
    EpibarError
        It is not.
    """
    recording, seconds = _taken_apart(value, Recording, "recording")
    wrong = recording.name != camera.name
    if not camera.is_saved(options):
        wrong |= recording.seed != options.seed or len(recording.segments) != options.lines
        wrong |= recording.first_frame != options.frames.first
    if wrong:
        raise EpibarError(
            f"{camera.name}: what ran the task returned another recording, {recording!r} of seed "
            f"{recording.seed}; its result is not used"
        )
    return recording, seconds


def checked_calibration(
    value: Any, a: Recording, b: Recording, options: PairOptions
) -> tuple[Calibration, float]:
    """Return a calibration and the seconds it took, if it can be one of that pair as was asked for.

    Raises
    ------
    EpibarError
        It cannot.
    """
    calibration, seconds = _taken_apart(value, Calibration, "calibration")
    try:
        Calibration.from_arrays(to_arrays(calibration), f"{a.name} - {b.name}: what ran the task returned")
    except (TypeError, AttributeError) as error:
        raise EpibarError(f"{a.name} - {b.name}: what ran the task returned is damaged ({error})") from error
    points = calibration.frontier_points
    inside = all(
        np.all((places > -MARGIN) & (places < np.array(recording.size) + MARGIN))
        for places, recording in ((points.a, a), (points.b, b))
    )
    frames = bool(np.all(points.frame < a.frames))
    asked = calibration.method == options.method and calibration.seed == options.seed
    if not (inside and frames and asked):
        raise EpibarError(
            f"{a.name} - {b.name}: what ran the task returned the calibration of another pair, or with other "
            "options; its result is not used"
        )
    return calibration, seconds
