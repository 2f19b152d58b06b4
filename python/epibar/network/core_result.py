"""What the compiled module found, as a :class:`~epibar.network.Network`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..recording import Recording
from .parts import BASELINE, Ground, NetworkCamera, NetworkClock, NetworkPair, NetworkPairs, evidence_of
from .result import Network

__all__ = ["network_of"]


def network_of(found: Mapping[str, Any], recordings: Mapping[str, Recording]) -> Network:
    """Make a network of the dict that ``_core.join_network`` returns."""
    names = list(recordings)
    cameras = {
        one["name"]: NetworkCamera(
            name=one["name"],
            size=recordings[one["name"]].size,
            accepted=bool(one["accepted"]),
            status=one["status"],
            reason=one["reason"],
            matrix=one["matrix"],
            distortions=one["distortions"],
            rotation=one["rotation"],
            translation=one["translation"],
            expected=None if one["expected"] is None else dict(one["expected"]),
            evidence=evidence_of(one["deviates"]),
        )
        for one in found["cameras"]
    }
    clocks = {one["name"]: _clock(one) for one in found["cameras"]}
    pairs = [
        NetworkPair(
            names[one["a"]],
            names[one["b"]],
            bool(one["accepted"]),
            one["status"],
            one["F"],
            evidence_of(one["deviates"]),
        )
        for one in found["pairs"]
    ]
    ground = Ground(**found["ground"])
    radius = _finite(found["radius"])
    return Network(
        cameras=cameras,
        pairs=NetworkPairs(pairs),
        clocks=clocks,
        accepted=bool(found["accepted"]),
        reason=found["reason"],
        unit=BASELINE,
        ground=ground,
        radius=radius,
    )


def _clock(one: Mapping[str, Any]) -> NetworkClock:
    if one["clock"] is None:
        return NetworkClock()
    offset, drift = one["clock"]
    return NetworkClock(float(offset), float(drift), _finite(one["offset_error"]))


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
