"""Which frame of B shows the moment of a frame of A: the one place where that is said.

A pair of clocks is a line: A's first frame falls at ``time_offset`` in B, in frames of B, and each frame of A
takes ``frames_per_frame`` frames of B (:func:`position_in_b`). Where frames are missing, or the rates differ,
the frame times say more, as they do in the compiled module (``calibrate/alignment/mod.rs``, whose rules these
are): :func:`positions_in_b`, :func:`common_frames`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from .calibration import Calibration
    from .recording import Recording

__all__ = [
    "Timing",
    "clock_rate",
    "common_frames",
    "frame_interval",
    "nearest_frame",
    "position_in_b",
    "positions_in_b",
]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SAME_RATE = 1e-4
"""Ratios of frame intervals nearer to one than this are one."""
LONG_STEP = 1.6
"""Frames further apart than so many frame intervals have others missing between them."""
NEAR = 0.6
"""Two frames are of one moment within this share of the shorter frame interval."""


@dataclass(frozen=True)
class Timing:
    """What is known about the clocks of two cameras, beside the offset.

    Attributes
    ----------
    frames_per_frame : float
        Frames of B for each frame of A: the ratio of the frame rates, times 1 + 1e-6 ``drift`` where that is
        used. 1 for equal frame rates and clocks that run alike.
    offset_uncertainty : float or None
        Standard error of a searched offset, frames of B. None where it was given, or could not be measured.
    drift : float or None
        By how much B's clock runs faster than A's, parts per million. None where the recordings are too short
        to show it: where its standard error would be above 100 ppm.
    drift_uncertainty : float or None
        Its standard error, parts per million.
    drift_used : bool
        The drift is significant, and F and ``frames_per_frame`` take it into account.
    runner_up : float or None
        Second best offset by the motion barcodes, where the offset was searched.
    runner_up_share : float or None
        Its score as a share of the best.
    offsets_tried : int
        1 where the offset was given.
    """

    frames_per_frame: float = 1.0
    offset_uncertainty: float | None = None
    drift: float | None = None
    drift_uncertainty: float | None = None
    drift_used: bool = False
    runner_up: float | None = None
    runner_up_share: float | None = None
    offsets_tried: int = 1


def position_in_b(frame: ArrayLike, time_offset: float, frames_per_frame: float) -> Array:
    """Where frames of A fall among the frames of B, where no frame of either is missing."""
    return time_offset + np.asarray(frame, dtype=np.float64) * frames_per_frame


def nearest_frame(position: ArrayLike) -> Index:
    """The frame nearest to a position, the later of two."""
    return np.floor(np.asarray(position, dtype=np.float64) + 0.5).astype(np.int64)


def frame_interval(recording: Recording) -> float:
    """Seconds from one frame to the next, over the whole recording; 1 for fewer than two frames.

    Neither a dropped frame nor time stamps in whole milliseconds move it, as they would a mean or a median.
    """
    if recording.frames < 2:
        return 1.0
    times = recording.times
    steps = np.diff(times)
    count = np.maximum(nearest_frame(steps / np.median(steps)), 1).sum()
    return float((times[-1] - times[0]) / count)


def clock_rate(rec_a: Recording, rec_b: Recording, frames_per_frame: float) -> float:
    """Seconds by B's clock for each second by A's: 1 + 1e-6 drift."""
    return frames_per_frame / _interval_ratio(rec_a, rec_b)


def positions_in_b(rec_a: Recording, rec_b: Recording, calibration: Calibration) -> Array:
    """Where each frame of A falls among the frames of B, whichever frames are missing.

    Equal frame rates go by index, so that rounded time stamps cannot slip a frame; others, and recordings
    with frames missing, go by the frame times.

    Parameters
    ----------
    rec_a, rec_b : Recording
        Of the two cameras.
    calibration : Calibration
        Of the pair.

    Returns
    -------
    ndarray, shape (frames of A,)
        Not whole numbers as a rule; NaN where B saw nothing of that moment.
    """
    if not rec_a.frames or not rec_b.frames:
        return np.full(rec_a.frames, np.nan)
    per_frame = calibration.timing.frames_per_frame
    step_a, step_b = frame_interval(rec_a), frame_interval(rec_b)
    last = rec_b.frames - 1
    if abs(step_a / step_b - 1) < SAME_RATE and _is_regular(rec_a, step_a) and _is_regular(rec_b, step_b):
        position = position_in_b(np.arange(rec_a.frames), calibration.time_offset, per_frame)
        inside = (position >= -0.5) & (position < last + 0.5)
        return np.where(inside, position.clip(0, last), np.nan)
    times_a, times_b = rec_a.times, rec_b.times
    rate = clock_rate(rec_a, rec_b, per_frame)
    target = (times_a - times_a[0]) * rate + calibration.time_offset * step_b + times_b[0]
    before = (np.searchsorted(times_b, target, side="right") - 1).clip(0)
    after = np.minimum(before + 1, last)
    outside = (target < times_b[before]) | (before == last)
    gap = np.where(outside, step_b, times_b[after] - times_b[before])
    share = (target - times_b[before]) / gap
    missing = gap > LONG_STEP * step_b
    one = np.where(outside | (share < 0.5), before, after)
    tolerance = np.where(outside, 0.5 * step_b, NEAR * min(step_a, step_b))
    alone = np.where(np.abs(times_b[one] - target) <= tolerance, one, np.nan)
    return np.where(outside | missing, alone, before + share)


def common_frames(rec_a: Recording, rec_b: Recording, calibration: Calibration) -> Index:
    """Pair the frames that show the same moment, as the estimation does.

    Returns
    -------
    ndarray, shape (n, 2), int64
        Frame of A, and the frame of B nearest to it in time.
    """
    position = positions_in_b(rec_a, rec_b, calibration)
    frames = np.flatnonzero(np.isfinite(position))
    nearest = nearest_frame(position[frames])
    within = NEAR * min(1.0, frame_interval(rec_a) / frame_interval(rec_b))
    near = np.abs(position[frames] - nearest) <= within
    return np.column_stack([frames, nearest])[near]


def _interval_ratio(rec_a: Recording, rec_b: Recording) -> float:
    ratio = frame_interval(rec_a) / frame_interval(rec_b)
    return 1.0 if abs(ratio - 1) < SAME_RATE else ratio


def _is_regular(recording: Recording, step: float) -> bool:
    """Whether no frame is missing: every step is within half of the usual one."""
    return bool(np.all(np.abs(np.diff(recording.times) / step - 1) < 0.5))
