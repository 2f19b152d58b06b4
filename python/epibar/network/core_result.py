"""What the compiled module found, as a :class:`~epibar.network.Network`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..recording import Recording
from .core_parts import camera_of, clock_of, finite, ground_of, pair_of
from .parts import BASELINE, NetworkPairs
from .result import Network

__all__ = ["network_of"]


def network_of(found: Mapping[str, Any], recordings: Mapping[str, Recording]) -> Network:
    """Make a network of the dict that ``_core.join_network`` returns."""
    names = list(recordings)
    cameras = {}
    for one in found["cameras"]:
        recording = recordings[one["name"]]
        cameras[one["name"]] = camera_of(one, recording.size, recording)
    return Network(
        cameras=cameras,
        pairs=NetworkPairs([pair_of(one, names) for one in found["pairs"]]),
        clocks={one["name"]: clock_of(one) for one in found["cameras"]},
        accepted=bool(found["accepted"]),
        reason=found["reason"],
        unit=BASELINE,
        ground=ground_of(found["ground"]),
        radius=finite(found["radius"]),
    )
