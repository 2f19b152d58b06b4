"""Pairs of a network, each searched by itself.

Of two cameras whose clocks are not known no other pair can vouch for an offset that barcodes find.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .. import _core
from ..calibration import Calibration, calibrate
from ..clocks import frame_interval
from ..recording import Recording
from .offsets import ClockOffsets

__all__ = ["calibrate_unsynchronised", "offsets_of_pair", "pair_to_core", "search_pairs"]

RIVALS = _core.RIVALS
"""Other geometries of a pair that go along, at most."""

RIVAL_SHARE = _core.RIVAL_SHARE
"""Share of the winner's score that such a one has at least."""


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


def search_pairs(
    cameras: Mapping[str, Recording],
    chosen: Sequence[tuple[int, int]],
    offsets: ClockOffsets,
    tell: Callable[[int, int], Callable[[str, float], None] | None],
    **options: Any,
) -> dict[tuple[str, str], Calibration]:
    """Calibrate pairs of cameras, each by itself.

    Parameters
    ----------
    cameras : mapping of str to Recording
    chosen : sequence of (int, int)
        Places a < b among the cameras.
    offsets : ClockOffsets
        Of all cameras.
    tell : callable
        Of how many pairs are done, and of how many, makes what the next one's progress is told to.
    options
        As those of :func:`epibar.calibrate`, but for the offset.
    """
    names, films = list(cameras), list(cameras.values())
    found = {}
    for done, (a, b) in enumerate(chosen):
        frames = offsets.between(films, a, b)
        assert frames is not None
        found[names[a], names[b]] = calibrate(
            films[a],
            films[b],
            time_offset=frames,
            sharpen_offset=offsets.sharpen,
            progress=tell(done, len(chosen)),
            **options,
        )
    return found


def pair_to_core(a: int, b: int, calibration: Calibration) -> dict[str, Any]:
    """Return a pair as the compiled module takes it."""
    rivals = [rival for rival in calibration.rivals if (rival.get("evidence_share") or 0) > RIVAL_SHARE]
    geometries = [(calibration.F, 1.0)] + [(rival["F"], rival["evidence_share"]) for rival in rivals[:RIVALS]]
    z = float(calibration.evidence.get("z", 0.0))
    return {
        "a": a,
        "b": b,
        "geometries": [([list(map(float, row)) for row in F], float(share)) for F, share in geometries],
        "offset": float(calibration.time_offset),
        "frames_per_frame": float(calibration.timing.frames_per_frame),
        "z": z if math.isfinite(z) else 0.0,
        "accepted": calibration.accepted,
    }
