"""Lines in an image: clipped to it, through segments, and the area between two of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Bits, Size, as_finite
from ..errors import EpibarError


def clip_lines(lines: ArrayLike, size: Size) -> tuple[Array, Bits]:
    """Clip lines to an image.

    Parameters
    ----------
    lines : (n, 3) array
    size : (width, height)

    Returns
    -------
    segments : (n, 2, 2) array
        The two ends of each, pixels; meaningless where ``hit`` is false.
    hit : (n,) bool array
        Whether the line crosses the image.
    """
    lines = as_finite("lines", lines, 3)
    norm = np.hypot(lines[:, 0], lines[:, 1])
    usable = norm > 0
    a, b, c = (lines / np.where(usable, norm, 1.0)[:, None]).T
    # From the foot of the perpendicular from the image's middle, so that both ends are equally precise.
    middle = (np.array(size, dtype=np.float64) - 1) / 2
    offset = a * middle[0] + b * middle[1] + c
    start = middle - offset[:, None] * np.column_stack([a, b])
    direction = np.column_stack([-b, a])
    low, high = np.full(len(lines), -np.inf), np.full(len(lines), np.inf)
    for axis in (0, 1):
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = (np.array([[0.0], [size[axis] - 1.0]]) - start[:, axis]) / direction[:, axis]
        moving = direction[:, axis] != 0
        low = np.where(moving, np.maximum(low, ends.min(axis=0)), low)
        high = np.where(moving, np.minimum(high, ends.max(axis=0)), high)
        usable = usable & (moving | ((start[:, axis] >= 0) & (start[:, axis] <= size[axis] - 1)))
    hit = usable & (low < high)
    low, high = np.where(hit, low, 0.0), np.where(hit, high, 0.0)
    return start[:, None] + np.stack([low, high], axis=1)[:, :, None] * direction[:, None], hit


def _clip_polygons(polygons: Array, lines: Array) -> Array:
    """Cut each convex polygon down to where its line is ≥ 0: (n, v, 2) → (n, 2v, 2), corners repeated."""
    value = np.einsum("nvi,ni->nv", polygons, lines[:, :2]) + lines[:, 2:]
    following, next_value = np.roll(polygons, -1, axis=1), np.roll(value, -1, axis=1)
    inside, crosses = value >= 0, (value >= 0) != (next_value >= 0)
    step = value / np.where(crosses, value - next_value, 1.0)
    crossing = polygons + step[..., None] * (following - polygons)
    count, corners = value.shape
    points = np.stack([polygons, crossing], axis=2).reshape(count, 2 * corners, 2)
    keep = np.stack([inside, crosses], axis=2).reshape(count, 2 * corners)
    # What is dropped repeats the last kept corner, cyclically, which leaves the area as it is.
    source = np.maximum.accumulate(np.where(keep, np.arange(2 * corners), -1), axis=1)
    source = np.where(source < 0, source[:, -1:], source)
    return np.take_along_axis(points, source[:, :, None], axis=1)


def _polygon_area(polygons: Array) -> Array:
    centred = polygons - polygons[:, :1]
    x, y = centred[..., 0], centred[..., 1]
    twice: Array = np.abs((x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1))
    return twice / 2


def area_between_lines(line1: ArrayLike, line2: ArrayLike, size: Size) -> Array | float:
    """Measure the exact image area between two lines, the distance between lines of §3.2 and §4.1.

    Two lines that cross inside the image cut it into two double wedges; the area is that of the smaller.
    Where they do not cross inside, it is that of what lies between them. A line that misses the image cuts
    nothing off, so it lies at area 0 from any other that misses it.

    Parameters
    ----------
    line1, line2 : (3,) or (n, 3) array
        Any scale and sign.
    size : (width, height)

    Returns
    -------
    float or (n,) array
        Square pixels.
    """
    single = np.ndim(line1) == 1
    first, second = as_finite("line1", np.atleast_2d(line1), 3), as_finite("line2", np.atleast_2d(line2), 3)
    if len(first) != len(second):
        raise EpibarError(f"line2: {len(second)} lines, but line1 has {len(first)}")
    right, bottom = size[0] - 1.0, size[1] - 1.0
    image = np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])
    images = np.broadcast_to(image, (len(first), 4, 2))
    # On which side of the other each lies inside the image, 0 where they cross or one of them misses it.
    ours, theirs = _side_of(first, second, size), _side_of(second, first, size)
    apart = (ours != 0) & (theirs != 0)
    first = np.where(apart & (theirs < 0), -1.0, 1.0)[:, None] * first
    second = np.where(apart & (ours < 0), -1.0, 1.0)[:, None] * second
    between = _polygon_area(_clip_polygons(_clip_polygons(images, first), second))
    wedge = _polygon_area(_clip_polygons(_clip_polygons(images, first), -second))
    wedge = wedge + _polygon_area(_clip_polygons(_clip_polygons(images, -first), second))
    area = np.where(apart, between, np.minimum(wedge, np.maximum(right * bottom - wedge, 0.0)))
    return float(area[0]) if single else area


def _side_of(lines: Array, others: Array, size: Size) -> Array:
    """On which side of another line each lies inside the image; 0 where it crosses it or misses the image."""
    segments, hit = clip_lines(lines, size)
    norm = np.maximum(np.hypot(others[:, 0], others[:, 1]), np.finfo(float).tiny)[:, None]
    distance = (np.einsum("nei,ni->ne", segments, others[:, :2]) + others[:, 2:]) / norm
    # Ends nearer than this touch.
    side: Array = (distance.min(axis=1) > 1e-9) * 1.0 - (distance.max(axis=1) < -1e-9) * 1.0
    return np.where(hit, side, 0.0)


def lines_through(segments: Array) -> Array:
    """Lines (a, b, c), a² + b² = 1, through segments (x0, y0, x1, y1); (n, 3) from (n, 4)."""
    x0, y0, x1, y1 = segments.T
    lines = np.stack([y0 - y1, x1 - x0, x0 * y1 - x1 * y0], axis=1)
    lengths: Array = np.hypot(lines[:, 0], lines[:, 1])
    return lines / np.maximum(lengths, 1e-12)[:, None]
