"""The numbers behind the view of the network in space, as plain data for its script."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arguments import Array
from ..network.parts import NetworkCamera, NetworkParts
from ..network.shared_errors import IN_SPACE
from .camera_angles import image_corners
from .inputs import ReportPair
from .walker_lines import Track

__all__ = ["grid_step", "magnification", "nice", "space_entry"]

FRUSTUM = 0.11
"""Depth of a frustum: share of the extent of what is shown; less where there are more than `FEW`."""

FEW = 6

BALL = 0.03
"""The median stated position error is drawn about so large: share of that extent."""

FAR = 3.0
"""Extents of the accepted cameras: one that was left out and stands farther off would shrink all others."""

CELLS = 12
"""Cells of the grid along its longer side, at most."""

TRACK_POINTS = 12_000
"""Places of walkers that are drawn, about: of more tracks every second, third, … place."""


def nice(value: float) -> float:
    """Round down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9))


def magnification(network: NetworkParts) -> float:
    """By how much stated position errors are enlarged, so that they can be seen; never made smaller."""
    errors = [_error(camera) for camera in network.cameras.values()]
    known = [error for error in errors if error]
    if not known:
        return 1.0
    return max(1.0, nice(BALL * _extent(_places(network)) / float(np.median(known))))


def _error(camera: NetworkCamera) -> float | None:
    error = None if camera.expected is None else camera.expected["position"]
    return error if error is not None and math.isfinite(error) else None


def _drawn(network: NetworkParts) -> list[str]:
    """Names of the cameras that are drawn: those with a place, but none that was left out and is far off."""
    cameras = network.cameras
    placed = {name: camera.position for name, camera in cameras.items() if camera.position is not None}
    standing = np.array([place for name, place in placed.items() if cameras[name].accepted]).reshape(-1, 3)
    if len(standing) < 2:
        return list(placed)
    middle, farthest = standing.mean(axis=0), FAR * _extent(standing)
    return [
        name
        for name, place in placed.items()
        if cameras[name].accepted or np.linalg.norm(place - middle) < farthest
    ]


def _places(network: NetworkParts) -> Array:
    return np.array([network.cameras[name].position for name in _drawn(network)]).reshape(-1, 3)


def _shown(network: NetworkParts, tracks: Sequence[Track]) -> Array:
    """All places that must be seen, (n, 3)."""
    return np.concatenate([_places(network), *(track for track in tracks if len(track))])


def grid_step(network: NetworkParts, tracks: Sequence[Track]) -> float:
    """Side of a cell of the floor's grid, in the network's unit."""
    low, high = _box(_shown(network, tracks))
    return nice(2 * max(*(high - low)[:2], 1e-9) / CELLS)


def _box(places: Array) -> tuple[Array, Array]:
    """Lowest and highest of (n, 3) places, with a margin."""
    if not len(places):
        return -np.ones(3), np.ones(3)
    margin = 0.08 * _extent(places) * np.array([1.0, 1.0, 0.0])
    return places.min(axis=0) - margin, places.max(axis=0) + margin


def _extent(places: Array) -> float:
    """Diagonal of the box about (n, 3) places; 1 where there is none."""
    return float(np.linalg.norm(np.ptp(places, axis=0))) or 1.0 if len(places) else 1.0


def space_entry(
    network: NetworkParts, pairs: Sequence[ReportPair], tracks: Sequence[Track]
) -> dict[str, Any]:
    """Describe cameras, pairs, floor and tracks."""
    every = _shown(network, tracks)
    extent = _extent(every)
    shown = {(pair.a, pair.b): index for index, pair in enumerate(pairs)}
    shown |= {(b, a): index for (a, b), index in shown.items()}
    names = _drawn(network)
    depth = FRUSTUM * extent * min(1.0, math.sqrt(FEW / max(len(names), 1)))
    return {
        "magnification": magnification(network),
        "floor": _floor(network, tracks),
        "cameras": [_camera(network.cameras[name], depth) for name in names],
        "pairs": [
            {
                "a": names.index(pair.a),
                "b": names.index(pair.b),
                "status": pair.status,
                "pair": shown.get((pair.a, pair.b)),
            }
            for pair in network.pairs.values()
            if pair.a in names and pair.b in names
        ],
        "tracks": _thinned(tracks, extent),
    }


def _camera(camera: NetworkCamera, depth: float) -> dict[str, Any]:
    corners = image_corners(camera, depth)
    assert corners is not None
    assert camera.position is not None
    return {
        "name": camera.name,
        "accepted": camera.accepted,
        "place": _rounded(camera.position),
        "corners": _rounded(corners),
        "error": _ellipsoid(camera),
    }


def _ellipsoid(camera: NetworkCamera) -> list[list[float]] | None:
    """Return the half axes of the ellipsoid that holds the true position nine times in ten, three (3,)."""
    error = _error(camera)
    if error is None:
        return None
    if camera.position_covariance is None:
        axes = error * np.eye(3)
    else:
        variances, directions = np.linalg.eigh(camera.position_covariance)
        axes = IN_SPACE * np.sqrt(np.maximum(variances, 0.0))[:, None] * directions.T
    found: list[list[float]] = axes.tolist()
    return found


def _floor(network: NetworkParts, tracks: Sequence[Track]) -> dict[str, Any]:
    """Grid below what is shown: at the floor that was found, or below the lowest camera."""
    places = _shown(network, tracks)
    found = network.ground.source == "floor"
    low, high = _box(places)
    step = grid_step(network, tracks)
    first, last = np.floor(low[:2] / step).astype(int), np.ceil(high[:2] / step).astype(int)
    return {
        "z": 0.0 if found else float(low[2] - 0.15 * _extent(places)),
        "step": step,
        "x": [int(first[0]), int(last[0])],
        "y": [int(first[1]), int(last[1])],
    }


def _thinned(tracks: Sequence[Track], extent: float) -> list[list[list[float]]]:
    every = max(1, math.ceil(sum(map(len, tracks)) / TRACK_POINTS))
    # To a ten-thousandth of what is shown at most: feet differ little in height, in whatever unit.
    digits = max(0, 4 - math.floor(math.log10(extent)))
    return [np.round(track[::every], digits).tolist() for track in tracks if len(track) > every]


def _rounded(values: Array) -> Any:
    return np.round(values, 5).tolist()
