"""Pairs of a network, each searched by itself.

Of two cameras whose clocks are not known no other pair can vouch for an offset that barcodes find.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral
from typing import Any

from .. import _core
from ..calibration import Calibration, calibrate
from ..clocks import frame_interval
from ..errors import EpibarError
from ..recording import Recording
from .offsets import ClockOffsets, as_offsets
from .recordings import Recordings, named_recordings
from .stages import Progress, of_pairs

__all__ = ["offsets_of_pair", "pair_to_core", "search_pairs"]

RIVALS = _core.RIVALS
"""Other geometries of a pair that go along, at most."""

RIVAL_SHARE = _core.RIVAL_SHARE
"""Share of the winner's score that such a one has at least."""


def offsets_of_pair(rec_b: Recording, calibration: Calibration) -> ClockOffsets:
    """Clocks of the two cameras of a pair, whose offset was tried or searched for."""
    if calibration.time_offset == 0:
        return ClockOffsets((0.0, 0.0), together=True)
    return ClockOffsets((0.0, calibration.time_offset * frame_interval(rec_b)))


def search_pairs(
    recordings: Recordings,
    chosen: Sequence[tuple[int, int]],
    offsets: ClockOffsets,
    *,
    seed: int = 0,
    upright: bool = True,
    progress: Progress | None = None,
) -> dict[tuple[str, str], Calibration]:
    """Calibrate pairs of cameras, each by itself, from the offsets of their clocks on.

    Parameters
    ----------
    recordings : mapping of str to Recording, or sequence of Recording
        Of all cameras.
    chosen : sequence of (int, int)
        Places a < b among the recordings, such as those of :func:`pairs_to_search`.
    offsets : ClockOffsets
        Of the clocks of all cameras, from :func:`find_offsets` or given.
    seed, upright
        As those of :func:`epibar.calibrate`.
    progress : callable, optional
        Called with "pairs" and the share of the pairs that are done, all the time.

    Returns
    -------
    dict of (str, str) to Calibration
        By the names of the two cameras, for :func:`join_pairs`; refused ones too.

    Raises
    ------
    EpibarError
        An argument is of the wrong kind or out of its range, or nothing tells the offset of a chosen pair.
    """
    cameras = named_recordings(recordings)
    names, films = list(cameras), list(cameras.values())
    as_offsets(offsets, len(names))
    found = {}
    places = [_places(pair, len(names)) for pair in chosen]
    for done, (a, b) in enumerate(places):
        frames = offsets.between(films, a, b)
        if frames is None:
            raise EpibarError(
                f"{names[a]} and {names[b]}: nothing tells the offset of their clocks; leave the pair "
                "out, or give offsets"
            )
        found[names[a], names[b]] = calibrate(
            films[a],
            films[b],
            time_offset=frames,
            sharpen_offset=offsets.sharpen,
            seed=seed,
            upright=upright,
            progress=of_pairs(progress, done, len(places)),
        )
        if progress is not None:
            progress("pairs", (done + 1) / len(places))
    return found


def _places(pair: Any, cameras: int) -> tuple[int, int]:
    """Return two places of cameras, if they are in their order."""
    if isinstance(pair, Sequence) and len(pair) == 2 and all(isinstance(place, Integral) for place in pair):
        a, b = map(int, pair)
        if 0 <= a < b < cameras:
            return a, b
    raise EpibarError(f"chosen has {pair!r}: expected places a < b of the {cameras} cameras, such as (0, 1)")


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
