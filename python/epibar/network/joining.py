"""Pairs that were calibrated become one network."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from .. import _core
from ..arguments import core_errors
from ..calibration import Calibration
from ..errors import EpibarError
from ..recording import Recording
from .core_result import network_of
from .knowledge import KnownCamera, known_of
from .offsets import ClockOffsets
from .recordings import Recordings, named_recordings
from .result import Network

__all__ = ["join_pairs", "knowledge_of"]

RIVALS = 3
"""Other geometries of a pair that go along, at most."""

RIVAL_SHARE = 0.5
"""Share of the winner's score that such a one has at least."""


def knowledge_of(
    recordings: Mapping[str, Recording], known: Mapping[str, KnownCamera] | None
) -> list[dict[str, Any]]:
    """Return what is known of each camera, as the compiled module takes it."""
    known = known or {}
    for name, one in known.items():
        if name not in recordings:
            raise EpibarError(f"known has {name!r}, but the cameras are {', '.join(recordings)}")
        if not isinstance(one, KnownCamera):
            raise EpibarError(f"known[{name!r}] is a {type(one).__name__}, expected a KnownCamera")
    return [known_of(name, one, known.get(name)) for name, one in recordings.items()]


def join_pairs(
    recordings: Recordings,
    calibrations: Mapping[tuple[str, str], Calibration],
    offsets: ClockOffsets,
    *,
    known: Mapping[str, KnownCamera] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Network:
    """Make one network of pairs that are calibrated already.

    Parameters
    ----------
    recordings : mapping of str to Recording, or sequence of Recording
        Of all cameras.
    calibrations : mapping of (str, str) to Calibration
        By the names of two cameras in the order of the recordings; not all pairs need be there, and refused
        ones are of use.
    offsets : ClockOffsets
        Of the clocks of all cameras, from :func:`find_offsets` or given.
    known : mapping of str to KnownCamera, optional
        What is known of cameras whose lens was not taken out.
    progress : callable, optional
        Called with the name of the stage and the share of it that is done.

    Returns
    -------
    Network
        Also where there is none: then no camera is accepted, and each says why.

    Raises
    ------
    EpibarError
        An argument is of the wrong kind or out of its range.
    """
    cameras = named_recordings(recordings)
    names = list(cameras)
    if len(offsets.seconds) != len(names):
        raise EpibarError(f"{len(offsets.seconds)} clocks for {len(names)} cameras")
    knowledge = knowledge_of(cameras, known)
    pairs = []
    for key, calibration in calibrations.items():
        if not (isinstance(key, tuple) and len(key) == 2 and all(name in cameras for name in key)):
            raise EpibarError(
                f"calibrations have key {key!r}: expected two of the cameras {', '.join(names)}"
            )
        a, b = (names.index(name) for name in key)
        if a >= b:
            raise EpibarError(f"calibrations have key {key!r}: the two in the order of the recordings")
        if calibration.F is not None:
            pairs.append(_pair(a, b, calibration))
    with core_errors():
        found = _core.join_network(
            [one._core for one in cameras.values()], names, knowledge, pairs, offsets.to_core(), progress
        )
    return network_of(found, cameras)


def _pair(a: int, b: int, calibration: Calibration) -> dict[str, Any]:
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
