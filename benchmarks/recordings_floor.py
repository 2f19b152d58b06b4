"""Floors of real recordings whose known cameras have it at z = 0: how far off where people walk."""

from __future__ import annotations

from typing import Any

import numpy as np

import epibar
from epibar.network import Ground, NetworkCamera, NetworkClock
from epibar.network.metres import NINE_IN_TEN
from epibar.network.parts import METRE, NetworkPairs

METRES = {"wildtrack": 0.01, "pets_cameras": 0.001, "four_people": 0.001}
"""Metres that one unit of the known cameras measures, where that is known: they have the floor at z = 0."""

PERSON = 1.75
"""Metres that people are taken to be tall."""


def feet(true: dict[str, Any], recordings: dict[str, Any], unit: float) -> np.ndarray:
    """Where the known cameras see people stand, (n, 3), metres."""
    exact = {"focal": 0.0, "rotation": 0.0, "position": 0.0}
    cameras = {
        name: NetworkCamera(
            *(name, recordings[name].size, True, "accepted", "known", c.K),
            *(np.array([*c.distortions, *[0.0] * 5][:5]), c.R, -unit * c.R @ c.centre, exact),
        )
        for name, c in true.items()
    }
    clocks = {name: NetworkClock(0.0, 0.0) for name in cameras}
    ground = Ground("floor", height=PERSON)
    network = epibar.Network(cameras, NetworkPairs([]), clocks, True, "the known one", METRE, ground)
    return network.tracks(recordings).foot


def floor(network: Any, walked: np.ndarray, turn: Any, scale: float, middles: tuple[Any, Any]) -> str:
    """Say how far the floor of a network is off where people walk, cm, and what is stated.

    ``turn`` takes the network's axes to the known ones, ``scale`` its unit to metres, and the first of
    ``middles``, in its unit, lies where the second does, in metres.
    """
    ground = network.ground
    if ground.source != "floor":
        return "no floor"
    ours, theirs = middles
    up, origin = turn[2], theirs - scale * ours @ turn
    heights = origin[2] - (walked[:, :2] - origin[:2]) @ up[:2] / up[2]
    stated = NINE_IN_TEN * scale * ground.level_error
    return f"{100 * np.abs(heights).mean():.1f}, {100 * stated:.1f}"
