"""Clocks: which frame of B shows the moment of a frame of A, and how the clocks of the two cameras run.

A pair of clocks is a line: A's first frame falls at ``time_offset`` in B, in frames of B, and each frame of A
takes ``frames_per_frame`` frames of B (:func:`position_in_b`). Where frames are missing, or the rates differ,
the frame times say more: :func:`positions_in_b` and :func:`common_frames` ask the compiled module, for what
the estimation goes by.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from .arguments import Array, Index
from .recording import Recording

__all__ = [
    "Clocked",
    "Timing",
    "clock_rate",
    "common_frames",
    "frame_interval",
    "frames_of_b",
    "nearest_frame",
    "position_in_b",
    "positions_in_b",
]


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


class Clocked(Protocol):
    """What has the clocks of a pair: a :class:`~epibar.Calibration`."""

    @property
    def time_offset(self) -> float:
        """Where A's first frame falls in B, in frames of B."""

    @property
    def timing(self) -> Timing:
        """The rest."""


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
    return _core.frame_interval(recording._core)


def clock_rate(rec_a: Recording, rec_b: Recording, frames_per_frame: float) -> float:
    """Seconds by B's clock for each second by A's: 1 + 1e-6 drift."""
    return _core.clock_rate(rec_a._core, rec_b._core, frames_per_frame)


def positions_in_b(rec_a: Recording, rec_b: Recording, calibration: Clocked) -> Array:
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
    return _core.positions(rec_a._core, rec_b._core, *_clock(calibration))


def common_frames(rec_a: Recording, rec_b: Recording, calibration: Clocked) -> Index:
    """Pair the frames that show the same moment, as the estimation does.

    Returns
    -------
    ndarray, shape (n, 2), int64
        Frame of A, and the frame of B nearest to it in time.
    """
    return _core.common_frames(rec_a._core, rec_b._core, *_clock(calibration))


def frames_of_b(
    rec_a: Recording, rec_b: Recording, time_offset: float, frames_per_frame: float, frames: Index
) -> Index:
    """Return the frame of B that the estimation saw with each of some frames of A, whichever are missing."""
    common = _core.common_frames(rec_a._core, rec_b._core, time_offset, frames_per_frame)
    seen = np.full(max(rec_a.frames, int(np.max(frames, initial=-1)) + 1), -1, dtype=np.int64)
    seen[common[:, 0]] = common[:, 1]
    nearest = nearest_frame(position_in_b(frames, time_offset, frames_per_frame))
    return np.clip(np.where(seen[frames] < 0, nearest, seen[frames]), 0, max(rec_b.frames - 1, 0))


def _clock(calibration: Clocked) -> tuple[float, float]:
    return calibration.time_offset, calibration.timing.frames_per_frame
