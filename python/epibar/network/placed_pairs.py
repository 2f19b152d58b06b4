"""A pair of cameras whose places are known: its geometry, and whether they stand far enough apart."""

from __future__ import annotations

import math

import numpy as np

from .. import _core
from ..geometry.cameras import Pose, fundamental_from_cameras
from .parts import NetworkCamera, NetworkPair

__all__ = ["placed_pair"]

CONFIRMED = _core.PAIR_DEVIATES
"""Normal deviate of the tangents of a pair that confirms a network."""


def placed_pair(
    one: NetworkCamera, other: NetworkCamera, evidence: dict[str, float] | None = None
) -> NetworkPair:
    """Return the pair by where its cameras stand, and by what its tangents say of that.

    As in the core, it is accepted where both are and their baseline is long beside the errors of places.
    """
    evidence = evidence or {}
    places = [_posed(one), _posed(other)]
    if places[0] is None or places[1] is None:
        return NetworkPair(one.name, other.name, False, "outside")
    status = "confirmed" if evidence.get("tangents", 0.0) >= CONFIRMED else "predicted"
    accepted = one.accepted and other.accepted
    if accepted and not _stand_apart(one, other):
        accepted, status = False, "no_baseline"
    F = fundamental_from_cameras(places[0], places[1])
    return NetworkPair(one.name, other.name, accepted, status, F, evidence)


def _stand_apart(one: NetworkCamera, other: NetworkCamera) -> bool:
    assert one.position is not None
    assert other.position is not None
    errors = [math.nan if c.expected is None else c.expected["position"] for c in (one, other)]
    return bool(np.linalg.norm(one.position - other.position) >= _core.BASELINE * math.hypot(*errors))


def _posed(camera: NetworkCamera) -> Pose | None:
    if camera.matrix is None or camera.rotation is None or camera.translation is None:
        return None
    return Pose(camera.matrix, camera.rotation, camera.translation, camera.size)
