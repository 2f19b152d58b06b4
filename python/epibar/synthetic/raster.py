"""Sub-pixel exact silhouettes: a pixel is set if and only if its centre lies inside the projected shape.

Shapes are convex, so a shape is one span per image row: the row's line y = integer meets it between x = left
and x = right, and the pixels set are ceil(left) … floor(right). OpenCV's polygon filling also sets the pixels
that the outline touches, which grows every shape by about half a pixel and biases every tangent.

Ellipsoids project exactly (Hartley & Zisserman, §8.3): an ellipsoid with centre c and half-axes as the
columns of A has the dual quadric Q* = Z diag(1, 1, 1, −1) Zᵀ with Z = [A c; 0 1], and its outline is the dual
conic P Q* Pᵀ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Bits, Index
from .camera import Camera

# Corners of a box in units of its half-axes, and its edges: pairs of corners that differ in one coordinate.
# The outline of a projected box consists of projected edges, so the edges bound its rows without computing a
# hull.
BOX_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
BOX_EDGES = np.array(
    [(i, j) for i in range(8) for j in range(i + 1, 8) if (BOX_CORNERS[i] != BOX_CORNERS[j]).sum() == 1]
)
NEAR = 0.05


@dataclass(frozen=True)
class Spans:
    """Rows of shapes: ``item`` covers the pixels ``left`` … ``right`` (inclusive) of image row ``row``."""

    item: Index
    row: Index
    left: Index
    right: Index

    def pixels(self, width: int) -> tuple[Index, Index]:
        """List every covered pixel: the index of its span, and its place row · width + x."""
        length = self.right - self.left + 1
        span = np.repeat(np.arange(len(length)), length)
        before = np.cumsum(length) - length
        return span, np.arange(len(span)) + (self.row * width + self.left - before)[span]

    def take(self, order: Index) -> Spans:
        """Put these spans in another order, or take some of them."""
        return Spans(self.item[order], self.row[order], self.left[order], self.right[order])


def concatenate(parts: list[Spans]) -> Spans:
    """Join several sets of spans as one."""
    names = ("item", "row", "left", "right")
    return Spans(*(np.concatenate([getattr(spans, name) for spans in parts]) for name in names))


def _rows(top: Array, bottom: Array, height: int) -> tuple[Index, Index]:
    """List the image rows between top and bottom of each shape: shape index and row, one entry per row."""
    first = np.ceil(np.clip(top, 0, height)).astype(np.int64)
    last = np.floor(np.clip(bottom, -1, height - 1)).astype(np.int64)
    count = np.maximum(last - first + 1, 0)
    item = np.repeat(np.arange(len(count)), count)
    return item, np.arange(len(item)) + (first - np.cumsum(count) + count)[item]


def spans_between(item: Index, row: Index, left: Array, right: Array, width: int) -> Spans:
    """Spans of the pixel centres between left and right, without the empty ones.

    All but ``width``, that of the image in pixels, are (n,): whose span it is, its image row, and x of its
    ends in pixels, which may lie outside of the image.
    """
    first = np.ceil(np.clip(left, 0, width)).astype(np.int64)
    last = np.floor(np.clip(right, -1, width - 1)).astype(np.int64)
    keep = first <= last
    return Spans(item[keep], row[keep], first[keep], last[keep])


def ellipse_spans(mean: Array, shape: Array, size: tuple[int, int]) -> Spans:
    """Spans of the ellipses (x − mean)ᵀ shape⁻¹ (x − mean) ≤ 1, for (m, 2) means and (m, 2, 2) shapes."""
    sxx, sxy, syy = shape[:, 0, 0], shape[:, 0, 1], shape[:, 1, 1]
    reach = np.sqrt(np.maximum(syy, 0.0))
    item, row = _rows(mean[:, 1] - reach, mean[:, 1] + reach, size[1])
    up = row - mean[item, 1]
    syy = np.maximum(syy, 1e-12)
    middle = mean[item, 0] + (sxy / syy)[item] * up
    # Half width at height up: √(det(shape) / syy · (1 − up² / syy)).
    widest = np.maximum(sxx - sxy**2 / syy, 0.0)
    half = np.sqrt(widest[item] * np.maximum(1.0 - up**2 / syy[item], 0.0))
    return spans_between(item, row, middle - half, middle + half, size[0])


def polygon_spans(corners: Array, edges: Index, size: tuple[int, int]) -> Spans:
    """Spans of convex polygons given by (m, k, 2) corners and (e, 2) edges that contain the outline."""
    x, y = corners[..., 0], corners[..., 1]
    item, row = _rows(y.min(axis=1), y.max(axis=1), size[1])
    left, right = np.full(len(item), np.inf), np.full(len(item), -np.inf)
    for i, j in edges:
        rise = y[:, j] - y[:, i]
        # A horizontal edge adds nothing to its neighbours, which end in the same corners.
        slope = (x[:, j] - x[:, i]) / np.where(rise == 0, 1.0, rise)
        low, high = np.minimum(y[:, i], y[:, j]), np.maximum(y[:, i], y[:, j])
        meets = (row >= low[item]) & (row <= high[item]) & (rise != 0)[item]
        at = x[item, i] + (row - y[item, i]) * slope[item]
        left = np.where(meets, np.minimum(left, at), left)
        right = np.where(meets, np.maximum(right, at), right)
    return spans_between(item, row, left, right, size[0])


def ellipsoid_outlines(camera: Camera, centres: Array, axes: Array) -> tuple[Array, Array, Bits]:
    """Exact outlines of ellipsoids, (m, 3) centres and (m, 3, 3) half-axes in columns.

    Returns
    -------
    mean : (m, 2) array
    shape : (m, 2, 2) array
        As for `ellipse_spans`.
    visible : (m,) bool array
        False where the ellipsoid is not all in front of the camera.
    """
    local = centres @ camera.R.T + camera.t
    turned = camera.R @ axes
    visible = local[:, 2] - np.linalg.norm(turned[:, 2], axis=1) > NEAR
    p, B = local @ camera.K.T, camera.K @ turned
    conic = B @ B.transpose(0, 2, 1) - p[:, :, None] * p[:, None, :]
    scale = np.where(visible, -conic[:, 2, 2], 1.0)
    conic = conic / scale[:, None, None]
    mean = -conic[:, :2, 2]
    return mean, conic[:, :2, :2] + mean[:, :, None] * mean[:, None, :], visible


def box_outlines(camera: Camera, centres: Array, axes: Array) -> tuple[Array, Bits]:
    """Project boxes: (m, 8, 2) corners, as in `BOX_CORNERS`, and which are all in front of the camera."""
    corners = centres[:, None] + BOX_CORNERS @ axes.transpose(0, 2, 1)
    local = corners @ camera.R.T + camera.t
    depth = local[..., 2]
    visible = depth.min(axis=1) > NEAR
    return (local @ camera.K.T)[..., :2] / np.where(visible[:, None], depth, 1.0)[..., None], visible


def solid_spans(camera: Camera, centres: Array, axes: Array, box: Bits) -> Spans:
    """Spans of boxes (where ``box``) and ellipsoids: (m, 3) centres, (m, 3, 3) half-axes in columns."""
    found = []
    which = np.flatnonzero(~box)
    mean, shape, visible = ellipsoid_outlines(camera, centres[which], axes[which])
    spans = ellipse_spans(mean[visible], shape[visible], camera.size)
    found.append(Spans(which[visible][spans.item], spans.row, spans.left, spans.right))
    which = np.flatnonzero(box)
    corners, visible = box_outlines(camera, centres[which], axes[which])
    spans = polygon_spans(corners[visible], BOX_EDGES, camera.size)
    found.append(Spans(which[visible][spans.item], spans.row, spans.left, spans.right))
    return concatenate(found)
