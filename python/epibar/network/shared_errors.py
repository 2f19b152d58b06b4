"""What lengths in a network are wrong by together: the floor under all heights, and the places of cameras.

The relative error of a length is made of what was measured, which is its own, and of parts that others have
as well: how high the floor lies, how it leans, and where a camera stands. By each part all lengths are wrong
by as many of its standard deviations, so that the mean of several does not get rid of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .. import _core
from ..arguments import Array
from .parts import KnownLength, NetworkParts

__all__ = ["FIGURES", "IN_SPACE", "error_of_mean", "parts_of"]

Part = tuple[str, str, int]
"""Whose error: what, of which camera, along which axis."""

FIGURES = 0.012
"""Relative standard error with which the network measures how tall people are: feet are touched a little
above the floor (``FOOT_ABOVE`` of the crate)."""

IN_SPACE = _core.NINE_IN_TEN_IN_SPACE
"""Nine in ten normal errors in space are shorter than so many standard deviations along one direction."""


def error_of_mean(network: NetworkParts, lengths: Sequence[KnownLength], weights: Array) -> float:
    """Relative standard error of a weighted mean of what some lengths say.

    Parameters
    ----------
    network : NetworkParts
        In which they are measured.
    lengths : sequence of KnownLength
    weights : (n,) array
        Their sum is 1; of a difference 0.
    """
    parts = [_parts(network, one) for one in lengths]
    together: dict[Part, float] = {}
    variance = 0.0
    for one, own, weight in zip(lengths, parts, weights, strict=True):
        # What is left of all that it is wrong by is its own.
        variance += weight**2 * max(one.error**2 - sum(part**2 for part in own.values()), 0.0)
        for name, part in own.items():
            together[name] = together.get(name, 0.0) + weight * part
    return math.sqrt(variance + sum(part**2 for part in together.values()))


def _parts(network: NetworkParts, length: KnownLength) -> dict[Part, float]:
    """By how much of itself a length is wrong by a standard deviation of each part that others may share."""
    if length.of[:1] == ("person_height",):
        # Feet are touched above the floor, which lifts that as well.
        return {("level", "", 0): min(FIGURES, length.error)}
    return parts_of(network, length.of)


def parts_of(network: NetworkParts, of: tuple[str, ...]) -> dict[Part, float]:
    """By how much of itself a length of cameras is wrong by each of these, as far as the network says.

    A vertical that leans lifts or lowers what is far from where people walked: amid the cameras.
    """
    what, *names = of or ("",)
    cameras = [network.cameras.get(name) for name in names]
    places = [camera.position for camera in cameras if camera is not None and camera.position is not None]
    if not names or len(places) < len(names):
        return {}
    errors = [
        camera.expected["position"] / IN_SPACE
        for camera in cameras
        if camera is not None and camera.expected is not None
    ]
    if what == "distance" and len(errors) == len(names):
        between = places[0] - places[1]
        relative = between / float(between @ between)
        signed = zip(names, (1, -1), errors, strict=True)
        return {
            ("place", name, k): sign * error * float(relative[k])
            for name, sign, error in signed
            for k in range(3)
        }
    ground = network.ground
    if what != "camera_height" or ground.vertical_error is None or ground.level_error is None or not errors:
        return {}
    standing = [one.position for one in network.cameras.values() if one.position is not None]
    units = float(places[0][2])
    aside = (places[0] - np.mean(standing, axis=0)) * math.radians(ground.vertical_error) / units
    return {
        ("place", names[0], 2): errors[0] / units,
        ("level", "", 0): ground.level_error / units,
        ("lean", "", 0): float(aside[0]),
        ("lean", "", 1): float(aside[1]),
    }
