"""The two scores of hypotheses in vectorised numpy: what one would write without a compiler."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from epibar import Recording

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


class LineScore:
    """Line inliers: the image area between a line of B and the one that F gives it is below 3 widths.

    Parameters
    ----------
    lines_a, lines_b : ndarray, shape (n, 3)
        Unit normals.
    sizes : two of (width, height)
    """

    def __init__(self, lines_a: Array, lines_b: Array, sizes: list[tuple[int, int]]) -> None:
        ends_a, ends_b = (_ends(lines, size) for lines, size in zip((lines_a, lines_b), sizes, strict=True))
        self.middle_a = np.column_stack([ends_a.mean(axis=1), np.ones(len(ends_a))])
        self.middle_b = np.column_stack([ends_b.mean(axis=1), np.ones(len(ends_b))])
        self.half_b = 0.5 * np.linalg.norm(ends_b[:, 1] - ends_b[:, 0], axis=1)
        self.lines = lines_b
        self.x, self.y = float(sizes[1][0] - 1), float(sizes[1][1] - 1)
        self.limit = 3.0 * sizes[1][0]
        everywhere = np.array([0.0, 0.0, 1.0])
        self.own = self._area(lines_b, everywhere)

    def __call__(self, matrices: Array) -> NDArray[np.int64]:
        """Inliers of each matrix (m, 3, 3)."""
        found = np.einsum("mij,nj->mni", matrices, self.middle_a)
        found /= np.linalg.norm(found[..., :2], axis=-1, keepdims=True)
        near = np.abs((found * self.middle_b).sum(axis=-1)) * self.half_b <= 4 * self.limit
        everywhere = np.array([0.0, 0.0, 1.0])
        one, both = self._area(found, everywhere), self._area(self.lines, found)
        wedge = np.maximum(self.own + one - 2 * both, 0)
        total = self.x * self.y
        low, high = self._inside(found)
        wedge = np.where(low < high, np.minimum(wedge, total - wedge), total)
        return (near & (wedge < self.limit)).sum(axis=1)

    def _area(self, p: Array, q: Array) -> Array:
        """Area of the image on the positive side of both lines, by Green's theorem along its edges."""
        right = _length(0, self.y, p, q, lambda n: (n[..., 1], n[..., 0] * self.x + n[..., 2]))
        lower = _length(0, self.x, p, q, lambda n: (n[..., 0], n[..., 1] * self.y + n[..., 2]))
        return 0.5 * (self.x * right + self.y * lower + self._along(p, q) + self._along(q, p))

    def _along(self, p: Array, q: Array) -> Array:
        """Twice the part of the area's boundary integral that lies on p."""
        low, high = self._inside(p)
        slope = q[..., 0] * p[..., 1] - q[..., 1] * p[..., 0]
        start = q[..., 2] - p[..., 2] * (q[..., 0] * p[..., 0] + q[..., 1] * p[..., 1])
        low, high = _cut(low, high, slope, start)
        return p[..., 2] * np.maximum(high - low, 0)

    def _inside(self, p: Array) -> tuple[Array, Array]:
        """Where p is in the image, as a range of its points -c·(a, b) + t·(b, -a)."""
        a, b, c = p[..., 0], p[..., 1], p[..., 2]
        low, high = np.full(a.shape, -1e9), np.full(a.shape, 1e9)
        if not np.any(a) and not np.any(b):
            return low, low
        for slope, start, most in ((b, -a * c, self.x), (-a, -b * c, self.y)):
            low, high = _cut(low, high, slope, start)
            low, high = _cut(low, high, -slope, most - start)
        return low, high


def _cut(low: Array, high: Array, slope: Array, start: Array) -> tuple[Array, Array]:
    """The part of low ≤ t ≤ high where slope·t + start ≥ 0; high < low where there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -start / slope
    low = np.where(slope > 0, np.maximum(low, t), low)
    high = np.where(slope < 0, np.minimum(high, t), high)
    return low, np.where((slope == 0) & (start < 0), low, high)


def _length(low: float, high: float, p: Array, q: Array, along: object) -> Array:
    """How much of an edge of the image is on the positive side of both lines."""
    shape = np.broadcast_shapes(p.shape[:-1], q.shape[:-1])
    lows, highs = np.full(shape, low, float), np.full(shape, high, float)
    for line in (p, q):
        lows, highs = _cut(lows, highs, *along(line))  # type: ignore[operator]
    return np.maximum(highs - lows, 0)


def _ends(lines: Array, size: tuple[int, int]) -> Array:
    """Ends of lines in an image, (n, 2, 2)."""
    a, b, c = lines.T
    low, high = np.full(len(lines), -1e9), np.full(len(lines), 1e9)
    for slope, start, most in ((b, -a * c, size[0] - 1.0), (-a, -b * c, size[1] - 1.0)):
        low, high = _cut(low, high, slope, start)
        low, high = _cut(low, high, -slope, most - start)
    middle, along = np.column_stack([-a * c, -b * c]), np.column_stack([b, -a])
    return np.stack([middle + low[:, None] * along, middle + high[:, None] * along], axis=1)


class TangentScore:
    """Tangents of A that meet one of B under F, one to one, without the chance of it: the less work.

    Parameters
    ----------
    a, b : Recording
    radius : float
        Two tangents meet below this Sampson distance, pixels.
    frames : int
        At most so many common frames in which both see something.
    """

    STEEP = 0.2

    def __init__(self, a: Recording, b: Recording, radius: float, frames: int) -> None:
        hulls = [[rec.hulls(frame) for frame in range(rec.frames)] for rec in (a, b)]
        busy = [i for i, both in enumerate(zip(*hulls, strict=True)) if all(both)]
        if len(busy) > frames:
            busy = [busy[k * len(busy) // frames] for k in range(frames)]
        self.views = [_View([view[i] for i in busy], rec) for view, rec in zip(hulls, (a, b), strict=True)]
        self.frames, self.radius = len(busy), radius

    def __call__(self, f: Array) -> int:
        """Matches of one matrix, (3, 3)."""
        u, _, vt = np.linalg.svd(f)
        e_a, e_b = vt[2], u[:, 2]
        point_a, positive_a, top_a, steep_a, frame_a = self.views[0].tangents(e_a)
        point_b, positive_b, top_b, steep_b, frame_b = self.views[1].tangents(e_b)
        # All pairs of tangents of one frame.
        count_b = np.bincount(frame_b, minlength=self.frames)
        first_b = np.concatenate([[0], np.cumsum(count_b)])
        repeats = count_b[frame_a]
        i = np.repeat(np.arange(len(frame_a)), repeats)
        j = np.arange(len(i)) - np.repeat(np.cumsum(repeats) - repeats, repeats) + first_b[frame_a][i]
        line, back = point_a @ f.T, point_b @ f
        lines_b = np.cross(e_b, point_b)
        same = self._keeps_side(f, e_a, e_b)
        allowed = (positive_a[i] == positive_b[j]) == same
        allowed &= (top_a[i] == top_b[j]) | steep_a[i] | steep_b[j]
        side = (lines_b[j] * line[i]).sum(axis=1)
        squares = (line[:, :2] ** 2).sum(axis=1)[i] + (back[:, :2] ** 2).sum(axis=1)[j]
        distance = np.abs((point_b[j] * line[i]).sum(axis=1)) / np.sqrt(squares)
        return max(self._mutual(i, j, np.where(allowed & (s * side > 0), distance, np.inf)) for s in (1, -1))

    def _mutual(self, i: NDArray[np.int64], j: NDArray[np.int64], distance: Array) -> int:
        """Pairs within the radius, each the nearest of the other."""
        if not len(i):
            return 0
        best_i, best_j = np.full(i.max() + 1, np.inf), np.full(j.max() + 1, np.inf)
        np.minimum.at(best_i, i, distance)
        np.minimum.at(best_j, j, distance)
        near = (distance < self.radius) & (distance == best_i[i]) & (distance == best_j[j])
        return int(near.sum())

    def _keeps_side(self, f: Array, e_a: Array, e_b: Array) -> bool:
        x, y = self.views[0].last
        corners = np.array([[0, 0, 1], [x, 0, 1], [0, y, 1.0]])
        p, q = corners, np.roll(corners, -1, axis=0)
        in_a = np.cross(p, q) @ e_a
        in_b = np.cross(p @ f.T, q @ f.T) @ e_b
        k = np.abs(in_a).argmax()
        return bool(in_a[k] * in_b[k] > 0)


class _View:
    """Vertices of the hulls of one camera, end to end."""

    def __init__(self, frames: list[list[Array]], rec: Recording) -> None:
        kept = [(i, hull) for i, hulls in enumerate(frames) for hull in hulls if len(hull) >= 3]
        self.frame = np.array([i for i, hull in kept for _ in hull])
        self.vertices = np.column_stack(
            [np.concatenate([hull for _, hull in kept]), np.ones(len(self.frame))]
        )
        sizes = np.array([len(hull) for _, hull in kept])
        self.start = np.cumsum(sizes) - sizes
        self.hull = np.repeat(np.arange(len(sizes)), sizes)
        self.following = np.arange(len(self.frame)) + 1
        self.following[self.start + sizes - 1] = self.start
        self.before = np.empty_like(self.following)
        self.before[self.following] = np.arange(len(self.frame))
        self.last = np.array(rec.size) - 1.0
        x, y = self.vertices[:, 0], self.vertices[:, 1]
        self.border = (x < 0.5) | (y < 0.5) | (x > self.last[0] - 0.5) | (y > self.last[1] - 0.5)
        self.edges = np.cross(self.vertices, self.vertices[self.following])

    def tangents(self, e: Array) -> tuple[Array, Flags, Flags, Flags, NDArray[np.int64]]:
        """Point; object on the positive side; a top; steep; and frame of each tangent."""
        out = self.edges @ e > 0
        into = out[self.before]
        at = np.flatnonzero((out != into) & ~self.border)
        positive, point = out[at], self.vertices[at]
        line = np.cross(e, point)
        towards = np.where(positive, line[:, 1], -line[:, 1])
        steep = np.abs(line[:, 1]) < TangentScore.STEEP * np.hypot(line[:, 0], line[:, 1])
        return point, positive, towards > 0, steep, self.frame[at]
