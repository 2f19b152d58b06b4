"""Two cameras whose clocks are not known: no other pair can vouch for an offset that barcodes find."""

from __future__ import annotations

from typing import Any

from ..calibration import Calibration, calibrate
from ..clocks import frame_interval
from ..recording import Recording
from .offsets import ClockOffsets

__all__ = ["calibrate_unsynchronised", "offsets_of_pair"]


def calibrate_unsynchronised(rec_a: Recording, rec_b: Recording, **options: Any) -> Calibration:
    """Calibrate a pair that may or may not have been started together.

    No offset is tried first. What is accepted so has passed the test of shifted clocks, so that another
    offset would have been noticed; only where it is refused an offset is searched for.

    Parameters
    ----------
    rec_a, rec_b : Recording
    options
        As those of :func:`epibar.calibrate`, but for the offset.

    Returns
    -------
    Calibration
        The first that is accepted; where neither is, the one for which more speaks.
    """
    together = calibrate(rec_a, rec_b, time_offset=0.0, **options)
    if together.accepted:
        return together
    searched = calibrate(rec_a, rec_b, time_offset="search", **options)
    if searched.accepted or searched.evidence.get("z", 0.0) > together.evidence.get("z", 0.0):
        return searched
    return together


def offsets_of_pair(rec_b: Recording, calibration: Calibration) -> ClockOffsets:
    """Clocks of the two cameras of a pair, whose offset was tried or searched for."""
    if calibration.time_offset == 0:
        return ClockOffsets((0.0, 0.0), together=True)
    return ClockOffsets((0.0, calibration.time_offset * frame_interval(rec_b)))
