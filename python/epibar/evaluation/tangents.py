"""Frontier points under a known F: they show where things moved in a recording with known cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Index, Size, as_finite
from ..errors import EpibarError
from ..geometry.epipolar import epipoles, symmetric_epipolar_distance
from ..geometry.vectors import cross_matrix, homogeneous


def _pencil_ends(hull: Array, to_pencil: Array) -> tuple[int, int] | None:
    """Find the corners with the lowest and highest line of the pencil; None if the epipole is in the hull."""
    pencil = homogeneous(hull) @ to_pencil.T
    pencil /= np.maximum(np.linalg.norm(pencil, axis=1, keepdims=True), 1e-300)
    x, y = pencil.mean(axis=0)
    angle = np.arctan2(x * pencil[:, 1] - y * pencil[:, 0], x * pencil[:, 0] + y * pencil[:, 1])
    # Seen from a point outside, a convex shape covers less than half a turn; from inside, a whole one.
    if np.ptp(angle) >= np.pi:
        return None
    return int(angle.argmin()), int(angle.argmax())


def matched_tangent_points(
    hulls_a: Sequence[Sequence[Any]],
    hulls_b: Sequence[Sequence[Any]],
    F: ArrayLike,
    radius: float = 6.0,
    size_a: Size | None = None,
    size_b: Size | None = None,
) -> tuple[Array, Array, Index]:
    """Find frontier points under a known F: tangent points of the epipolar tangents that meet one to one.

    The lines F x_a and e_b × x_b are one pencil, a projective line that keeps its direction when a line
    changes its sign. A hull covers an interval of it, whose two ends are its tangents; a lower end can only
    meet a lower end and an upper an upper, which is the same-side rule for whatever position of the epipoles.

    Parameters
    ----------
    hulls_a, hulls_b : per frame a sequence of (k, 2) arrays
        Convex hulls, pixels; frame i of A is frame i of B.
    F : (3, 3) array
    radius : float
        Largest symmetric epipolar distance of a match, pixels. A tangent with two candidates is not used.
    size_a, size_b : (width, height), optional
        When given, tangent points within a pixel of the border are left out: there the border was touched.

    Returns
    -------
    points_a, points_b : (n, 2) array
    frames : (n,) int array
    """
    F = as_finite("F", F, (3, 3))
    if len(hulls_a) != len(hulls_b):
        raise EpibarError(f"hulls_b: {len(hulls_b)} frames, but hulls_a has {len(hulls_a)}")
    epipole = epipoles(F)[1]
    basis = np.linalg.svd(epipole[None])[2][1:]
    to_pencil_a, to_pencil_b = basis @ F, basis @ cross_matrix(epipole)

    def tangent_points(hulls: Sequence[Any], to_pencil: Array, size: Size | None) -> tuple[Array, Array]:
        ends: tuple[list[Array], list[Array]] = ([], [])
        for hull in hulls:
            hull = np.asarray(hull, dtype=np.float64).reshape(-1, 2)
            found = _pencil_ends(hull, to_pencil) if len(hull) else None
            for side, corner in zip(ends, found or (), strict=False):
                point = hull[corner]
                if size is None or ((point >= 1) & (point <= np.array(size) - 2)).all():
                    side.append(point)
        return np.reshape(ends[0], (-1, 2)), np.reshape(ends[1], (-1, 2))

    matched: list[tuple[Array, Array, int]] = []
    for frame, (frame_a, frame_b) in enumerate(zip(hulls_a, hulls_b, strict=True)):
        sides_a = tangent_points(frame_a, to_pencil_a, size_a)
        sides_b = tangent_points(frame_b, to_pencil_b, size_b)
        for a, b in zip(sides_a, sides_b, strict=True):
            pairs = np.indices((len(a), len(b))).reshape(2, -1)
            near = symmetric_epipolar_distance(F, a[pairs[0]], b[pairs[1]]) <= radius
            near = near.reshape(len(a), len(b))
            alone = near & (near.sum(axis=0) == 1) & (near.sum(axis=1) == 1)[:, None]
            matched += [(a[i], b[j], frame) for i, j in np.argwhere(alone)]
    return (
        np.array([m[0] for m in matched]).reshape(-1, 2),
        np.array([m[1] for m in matched]).reshape(-1, 2),
        np.array([m[2] for m in matched], dtype=np.int64),
    )
