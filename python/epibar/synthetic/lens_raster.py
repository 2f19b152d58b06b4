"""Silhouettes through a lens, sub-pixel exact: outlines are bent point by point and drawn as polygons.

An ellipse becomes a polygon of the same area with so many corners that it stays within `TOLERANCE` of it; the
edges of a box's faces are cut so that their pieces bend less than that. A pixel is set if and only if its
centre lies inside, as in `raster`. What a lens bends need not be convex: a row may cross it four times.
"""

from __future__ import annotations

import numpy as np

from ..arguments import Array, Bits, Index
from . import raster
from .camera import Camera
from .raster import Spans

TOLERANCE = 0.05
"""Pixels between an outline and the polygon drawn for it."""

PIECE = 16.0
"""Pixels; a piece of a straight edge. The strongest lens in use bends that by less than the tolerance."""

# The faces of a box: corners of `BOX_CORNERS` in a circle.
FACES = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def solid_spans(camera: Camera, centres: Array, axes: Array, box: Bits) -> Spans:
    """Spans of solids as the lens shows them; the parameters are those of `raster.solid_spans`.

    A solid may have several spans in a row.
    """
    if not camera.distorted:
        return raster.solid_spans(camera, centres, axes, box)
    found = []
    which = np.flatnonzero(~box)
    mean, shape, visible = raster.ellipsoid_outlines(camera, centres[which], axes[which])
    found.append(_of(which[visible], _ellipses(camera, mean[visible], shape[visible])))
    which = np.flatnonzero(box)
    owner, quads = _faces(camera, centres[which], axes[which])
    found.append(_of(which[owner], _quads(camera, quads)))
    return raster.concatenate(found)


def _of(which: Index, spans: Spans) -> Spans:
    return Spans(which[spans.item], spans.row, spans.left, spans.right)


def _by_corners(wanted: Array, least: int) -> list[tuple[int, Index]]:
    """Group shapes by how many corners they are to have: powers of two times the least."""
    steps = np.ceil(np.log2(np.clip(wanted / least, 1.0, 64.0))).astype(np.int64)
    return [(least << int(step), np.flatnonzero(steps == step)) for step in np.unique(steps)]


def _near_image(camera: Camera, corners: Array) -> Bits:
    """Tell which (m, k, 2) polygons have a bounding box that meets the image."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    near: Bits = ((high >= 0) & (low <= np.array(camera.size) - 1)).all(axis=1)
    return near


def _ellipses(camera: Camera, mean: Array, shape: Array) -> Spans:
    """Draw bent ellipses; the parameters are those of `raster.ellipse_spans`."""
    sxx, sxy, syy = shape[:, 0, 0], shape[:, 0, 1], shape[:, 1, 1]
    longest = np.sqrt(np.maximum((sxx + syy) / 2 + np.hypot((sxx - syy) / 2, sxy), 0.0))
    # A polygon of n corners with the area of a circle is within R π² / (3 n²) of it.
    wanted = np.pi * np.sqrt(longest / (3 * TOLERANCE))
    up = np.sqrt(np.maximum(sxx, 1e-12))
    root = np.zeros_like(shape)
    root[:, 0, 0], root[:, 1, 0] = up, sxy / up
    root[:, 1, 1] = np.sqrt(np.maximum(syy - (sxy / up) ** 2, 0.0))
    found = []
    for corners, which in _by_corners(wanted, 12):
        angle = 2 * np.pi * np.arange(corners) / corners
        scale = np.sqrt((2 * np.pi / corners) / np.sin(2 * np.pi / corners))
        circle = scale * np.column_stack([np.cos(angle), np.sin(angle)])
        points = camera.distort(mean[which, None] + circle @ root[which].transpose(0, 2, 1))
        near = _near_image(camera, points)
        found.append(_of(which[near], polygon_spans(points[near], camera.size)))
    return raster.concatenate(found) if found else _none()


def _faces(camera: Camera, centres: Array, axes: Array) -> tuple[Index, Array]:
    """Project the faces of boxes, which together are the box: whose they are, and (m, 4, 2) pixels."""
    corners, visible = raster.box_outlines(camera, centres, axes)
    which = np.flatnonzero(visible)
    return np.repeat(which, len(FACES)), corners[which][:, FACES].reshape(-1, 4, 2)


def _quads(camera: Camera, quads: Array) -> Spans:
    """Draw bent quadrilaterals, (m, 4, 2) straight pixels."""
    edges = np.roll(quads, -1, axis=1) - quads
    pieces = np.linalg.norm(edges, axis=2).max(axis=1, initial=0.0) / PIECE
    found = []
    for count, which in _by_corners(pieces, 1):
        share = (np.arange(count) / count)[:, None]
        points = quads[which, :, None] + share * edges[which, :, None]
        points = camera.distort(points.reshape(len(which), 4 * count, 2))
        near = _near_image(camera, points)
        found.append(_of(which[near], polygon_spans(points[near], camera.size)))
    return raster.concatenate(found) if found else _none()


def _none() -> Spans:
    empty = np.empty(0, np.int64)
    return Spans(empty, empty, empty, empty)


def polygon_spans(corners: Array, size: tuple[int, int]) -> Spans:
    """Spans of simple polygons, convex or not: (m, k, 2) corners in a circle."""
    width, height = size
    item, row, at = _crossings(corners, height)
    # Each row crosses an outline an even number of times, twice unless the lens has bent it round.
    cell = item * height + row
    order = np.argsort(cell, kind="stable")
    cell, at = cell[order], at[order]
    first, second = at[::2], at[1::2]
    if (cell[2::2] == cell[1:-1:2]).any():
        order = np.lexsort((at, cell))
        at = at[order]
        first, second = at[::2], at[1::2]
    item, row = np.divmod(cell[::2], height)
    left, right = np.minimum(first, second), np.maximum(first, second)
    return raster.spans_between(item, row, left, right, width)


def _crossings(corners: Array, height: int) -> tuple[Index, Index, Array]:
    """List where image rows cross the edges of polygons: polygon, row, and x.

    An edge covers the rows from its upper end, inclusive, to its lower end, so that a corner is not counted
    twice.
    """
    x, y = corners[..., 0], corners[..., 1]
    next_x, next_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    top = np.ceil(np.clip(np.minimum(y, next_y), 0, height)).astype(np.int64).ravel()
    bottom = np.ceil(np.clip(np.maximum(y, next_y), 0, height)).astype(np.int64).ravel()
    edges = np.flatnonzero(bottom > top)
    top, count = top[edges], (bottom - top)[edges]
    edge = np.repeat(np.arange(len(edges)), count)
    row = np.arange(len(edge)) + (top - np.cumsum(count) + count)[edge]
    x0, y0 = x.ravel()[edges], y.ravel()[edges]
    slope = (next_x.ravel()[edges] - x0) / (next_y.ravel()[edges] - y0)
    at = (x0 - y0 * slope)[edge] + row * slope[edge]
    return (edges // corners.shape[1])[edge], row, at
