"""Lines that show where cameras stand: frusta, and a grid where z is 0."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arguments import Array
from ..lens.intrinsics import Intrinsics

__all__ = ["frustum", "frustum_depth", "ground_grid", "positions"]

OF_THE_NEAREST = 0.25
"""Depth of a frustum over the median distance of a camera to its nearest neighbour."""
LEAST_CELLS = 5
"""Of the grid, across the places that it covers; at most ten times as many."""
AHEAD = 2.0
"""How far from a camera the place on the floor that it looks at may be, over the spread of the cameras."""


def positions(cameras: Sequence[Intrinsics]) -> Array:
    """Where the cameras stand, (n, 3)."""
    return np.array([-pose.R.T @ pose.t for pose in (camera.posed() for camera in cameras)])


def frustum_depth(cameras: Sequence[Intrinsics]) -> float:
    """How far ahead of the cameras their frusta end, in the unit of the world."""
    places = positions(cameras)
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    found = np.median(nearest[np.isfinite(nearest)]) if np.isfinite(nearest).any() else 0.0
    return OF_THE_NEAREST * float(found) or 1.0


def frustum(camera: Intrinsics, depth: float) -> Array:
    """Segments of a frustum without its lens, and of a mark above its upper edge.

    Returns
    -------
    ndarray, shape (10, 2, 3)
        In the camera: x right, y down, z forward.
    """
    width, height = np.array(camera.size) - 0.5
    corners = np.array([(-0.5, -0.5), (width, -0.5), (width, height), (-0.5, height)])
    K = camera.matrix
    flat = (corners - K[:2, 2]) / K[[0, 1], [0, 1]]
    base = depth * np.column_stack([flat, np.ones(4)])
    (left, right), up = base[:2], 0.25 * (base[0] - base[3])
    top = (left + right) / 2 + up
    apex = np.zeros(3)
    edges = [(apex, corner) for corner in base] + list(zip(base, np.roll(base, -1, axis=0), strict=True))
    return np.array([*edges, (left, top), (right, top)])


def ground_grid(cameras: Sequence[Intrinsics]) -> tuple[Array, float]:
    """Segments of a grid at z = 0, (n, 2, 3), below the cameras and where they look, and its spacing."""
    places = positions(cameras)
    spread = float(np.ptp(places, axis=0).max()) or 1.0
    seen = [places[:, :2]]
    for camera, place in zip(cameras, places, strict=True):
        ahead = camera.posed().R[2]
        if place[2] * ahead[2] < 0:
            far = -place[2] / ahead[2]
            seen.append((place + min(far, AHEAD * spread) * ahead)[None, :2])
    covered = np.concatenate(seen)
    span = float(np.ptp(covered, axis=0).max()) or 1.0
    spacing = 10.0 ** np.floor(np.log10(span / LEAST_CELLS))
    low, high = np.floor(covered.min(axis=0) / spacing), np.ceil(covered.max(axis=0) / spacing)
    (x0, y0), (x1, y1) = low * spacing, high * spacing
    columns = np.arange(low[0], high[0] + 1) * spacing
    rows = np.arange(low[1], high[1] + 1) * spacing
    lines = [((x, y0, 0.0), (x, y1, 0.0)) for x in columns] + [((x0, y, 0.0), (x1, y, 0.0)) for y in rows]
    return np.array(lines), float(spacing)
