"""Epipoles, and how far correspondences are from the epipolar lines of an F: ``x_bᵀ F x_a = 0``."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, as_finite
from ..errors import EpibarError
from .vectors import homogeneous

__all__ = ["epipoles", "symmetric_epipolar_distance"]


def epipoles(F: ArrayLike) -> tuple[Array, Array]:
    """Find the epipoles in A and in B, homogeneous and of norm 1: ``F e_a = 0`` and ``Fᵀ e_b = 0``."""
    u, _, vt = np.linalg.svd(as_finite("F", F, (3, 3)))
    return vt[2], u[:, 2]


def symmetric_epipolar_distance(F: ArrayLike, points_a: ArrayLike, points_b: ArrayLike) -> Array:
    """Measure correspondences against F: ``½(d(x_b, F x_a) + d(x_a, Fᵀ x_b))``.

    Parameters
    ----------
    F : (3, 3) array
        Any scale.
    points_a, points_b : (n, 2) array
        Pixels.

    Returns
    -------
    (n,) array
        Pixels. Infinite where a point is an epipole of F, as it then has no epipolar line.

    Raises
    ------
    EpibarError
        For a wrong shape, unequal lengths, NaN, or F = 0.

    Examples
    --------
    >>> F = [[0, 0, 0], [0, 0, -1], [0, 1, 0]]  # rectified cameras: epipolar lines are the rows
    >>> float(symmetric_epipolar_distance(F, [[10, 20]], [[35, 22]])[0])
    2.0
    """
    F = as_finite("F", F, (3, 3))
    if not F.any():
        raise EpibarError("F: all zero")
    a, b = as_finite("points_a", points_a, 2), as_finite("points_b", points_b, 2)
    if len(a) != len(b):
        raise EpibarError(f"points_b: {len(b)} points, but points_a has {len(a)}")
    a, b = homogeneous(a), homogeneous(b)
    lines_b, lines_a = a @ F.T, b @ F
    algebraic = np.abs(np.einsum("ni,ni->n", b, lines_b))
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = 0.5 * algebraic * (1 / np.hypot(*lines_b[:, :2].T) + 1 / np.hypot(*lines_a[:, :2].T))
    return np.where(np.isfinite(distance), distance, np.inf)
