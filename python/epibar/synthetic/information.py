"""How well the motion can determine F at all, whatever the method: the Cramér–Rao bound at the truth.

Every mover shows two frontier points a second: where the epipolar planes that bound it touch it. How far they
are from their epipolar lines is measured with `NOISE` pixels, and how well the seven parameters of F can then
be known follows from the Fisher information (Hartley & Zisserman, §5.1.3, and §11.4.3 for the Sampson
distance). That nobody hides anybody is assumed, so what is not determined here is not determined.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..arguments import Array, Bits
from .camera import Camera
from .film import Film
from .made_up_world import ALL


class Filmed(Protocol):
    """What the bound asks of a `Situation`."""

    @property
    def cameras(self) -> Sequence[Camera]:
        """True cameras."""

    @property
    def films(self) -> Sequence[Film]:
        """What each of them films."""

    def seen(self, index: int, points: Array) -> Bits:
        """Tell which of (n, 3) points a camera shows."""

    def fundamental(self, a: int, b: int) -> Array:
        """Return the true F of a pair."""

    def correspondences(self, a: int, b: int, points: Array | None = None) -> tuple[Array, Array]:
        """Project points that both see: two (m, 2) arrays."""


NOISE = 0.5
"""Pixels: standard deviation of a tangent."""

MOMENTS = 200
"""At most so many of the seconds are looked at, evenly spread, and the others counted like them."""

_DIRECTIONS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)],
    dtype=float,
)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


def frontier_points(situation: Filmed, a: int, b: int) -> tuple[Array, float]:
    """World points where epipolar planes touch movers, (n, 3), and how many seconds each stands for."""
    first, second = situation.films[a], situation.films[b]
    start = max(first.moments.min(), second.moments.min())
    end = min(first.moments.max(), second.moments.max())
    seconds = np.arange(start, end, max(1.0, (end - start) / MOMENTS))
    world = first.world
    posture = world.at(seconds)
    centre, other = situation.cameras[a].centre, situation.cameras[b].centre
    axis = (other - centre) / np.linalg.norm(other - centre)
    across = np.linalg.svd(axis[None])[2][1:]
    corners = posture.centres[:, :, None] + np.einsum("kmij,dj->kmdi", posture.axes, _DIRECTIONS)
    found = []
    for mover in np.flatnonzero(world.only == ALL):
        solids = np.flatnonzero(world.owner == mover)
        there = posture.present[:, solids].all(axis=1)
        if not there.any():
            continue
        points = corners[there][:, solids].reshape(int(there.sum()), -1, 3)
        # The angle of the epipolar plane, against that of the middle of the mover.
        flat = (points - centre) @ across.T
        middle = flat.mean(axis=1, keepdims=True)
        angle = np.arctan2(
            middle[..., 0] * flat[..., 1] - middle[..., 1] * flat[..., 0], (middle * flat).sum(axis=2)
        )
        for corner in (angle.argmin(axis=1), angle.argmax(axis=1)):
            found.append(points[np.arange(len(points)), corner])
    points = np.concatenate(found) if found else np.empty((0, 3))
    seen = situation.seen(a, points) & situation.seen(b, points) if len(points) else np.empty(0, bool)
    return points[seen], max(1.0, (end - start) / MOMENTS)


def error_bound(situation: Filmed, a: int, b: int, where: Array | None = None, noise: float = NOISE) -> float:
    """Mean symmetric epipolar distance that the best method must expect, pixels.

    It is over (n, 3) points ``where``, by default those of the volume. Infinite where the tangents do not
    determine the seven parameters.
    """
    points, weight = frontier_points(situation, a, b)
    if len(points) * weight < 8:
        return float("inf")
    F = situation.fundamental(a, b)
    steps = _directions(F, situation.cameras[a].size, situation.cameras[b].size)
    one, other = (_homogeneous(p) for p in situation.correspondences(a, b, points))
    lengths = np.linalg.norm((one @ F.T)[:, :2], axis=1), np.linalg.norm((other @ F)[:, :2], axis=1)
    slopes = np.einsum("ni,kij,nj->nk", other, steps, one)
    sampson = slopes / np.hypot(*lengths)[:, None]
    information = weight * sampson.T @ sampson / noise**2
    values, vectors = np.linalg.eigh(information)
    if values[0] <= 1e-12 * values[-1]:
        return float("inf")
    root = vectors / np.sqrt(values)
    one, other = (_homogeneous(p) for p in situation.correspondences(a, b, where))
    if not len(one):
        return float("inf")
    deviation = np.linalg.norm(np.einsum("ni,kij,nj->nk", other, steps, one) @ root, axis=1)
    lengths = np.linalg.norm((one @ F.T)[:, :2], axis=1), np.linalg.norm((other @ F)[:, :2], axis=1)
    distance = 0.5 * deviation * (1 / lengths[0] + 1 / lengths[1])
    return float(np.sqrt(2 / np.pi) * distance.mean())


def _homogeneous(points: Array) -> Array:
    return np.column_stack([points, np.ones(len(points))])


def _directions(F: Array, size_a: tuple[int, int], size_b: tuple[int, int]) -> Array:
    """Seven directions in which F can go and keep its rank, (7, 3, 3), of like lengths over the images."""

    def scaled(size: tuple[int, int]) -> Array:
        return np.array([[2 / size[0], 0, -1], [0, 2 / size[0], -size[1] / size[0]], [0, 0, 1.0]])

    to_a, to_b = scaled(size_a), scaled(size_b)
    even = np.linalg.inv(to_b).T @ F @ np.linalg.inv(to_a)
    u, _, vt = np.linalg.svd(even)
    # Neither along F, which changes its scale, nor along the product of its null vectors, which its rank.
    forbidden = np.stack([even.ravel() / np.linalg.norm(even), np.outer(u[:, 2], vt[2]).ravel()])
    free = np.linalg.svd(forbidden)[2][2:]
    return np.stack([to_b.T @ step.reshape(3, 3) @ to_a for step in free])
