"""What a report is made of."""

from __future__ import annotations

from dataclasses import dataclass

from ..calibration import Calibration
from ..lens.intrinsics import Intrinsics
from ..recording import Recording

__all__ = ["ReportCamera", "ReportPair"]


@dataclass(frozen=True)
class ReportCamera:
    """One camera of a report.

    Attributes
    ----------
    name : str
        As the pairs call it.
    source : str or None
        What it was recorded from. Where that can no longer be read, the report shows silhouettes over
        the heat map instead of frames.
    masks : bool
        The source is ready-made masks.
    recording : Recording
    intrinsics : Intrinsics or None
        With which the frames are undistorted, as the recording was.
    """

    name: str
    source: str | None
    masks: bool
    recording: Recording
    intrinsics: Intrinsics | None


@dataclass(frozen=True)
class ReportPair:
    """One calibrated pair of a report.

    Attributes
    ----------
    a, b : str
        Names of its cameras.
    calibration : Calibration
    seconds : float
        How long it took.
    """

    a: str
    b: str
    calibration: Calibration
    seconds: float
