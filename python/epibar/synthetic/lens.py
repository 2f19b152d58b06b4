"""Lenses that bend lines: OpenCV's polynomial model (Brown–Conrady), k1, k2, p1, p2, k3.

With x, y in units of the focal length and r² = x² + y²::

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
    y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y

(https://docs.opencv.org/4.x/d9/d0c/group__calib3d.html). The radial part grows with r only up to the *fold*,
the first root of 1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶; with k1 alone that is r = 1/√(−3 k1). Behind the fold the
polynomial shows things twice, which no lens does, so a camera whose image reaches that far is an error here,
and outside the image the model goes on straight.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array
from ..errors import EpibarError

FOLD_MARGIN = 1.08
"""How much farther out than the corners of the image, in r, a lens must not fold."""

BEYOND = 1.05
"""How far beyond the corners of the image, in r, the polynomial is used, before it goes on straight."""


def _polynomial(distortions: Sequence[float]) -> tuple[float, float, float]:
    return distortions[0], distortions[1], distortions[4]


def fold_radius(distortions: Sequence[float]) -> float:
    """Find the least r at which the radial part stops growing; infinite where it always grows."""
    k1, k2, k3 = _polynomial(distortions)
    roots = np.roots(np.trim_zeros(np.array([7 * k3, 5 * k2, 3 * k1, 1.0]), "f"))
    squared = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    return float(np.sqrt(squared.min())) if len(squared) else float("inf")


def _bent(points: Array, distortions: Sequence[float]) -> Array:
    """Apply the polynomial to (..., 2) points in units of the focal length."""
    k1, k2, p1, p2, k3 = distortions
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    out = points * radial[..., None]
    if p1 or p2:
        xy2 = 2 * x * y
        out[..., 0] += p1 * xy2 + p2 * (r2 + 2 * x * x)
        out[..., 1] += p1 * (r2 + 2 * y * y) + p2 * xy2
    return out


def bend(points: ArrayLike, distortions: Sequence[float], limit: float = np.inf) -> Array:
    """Apply a lens to points in units of the focal length.

    Parameters
    ----------
    points : (..., 2) array
    distortions : five floats
        k1, k2, p1, p2, k3.
    limit : float
        Beyond this r the model goes on straight, with the slope that it has there.

    Returns
    -------
    (..., 2) array
    """
    points = np.asarray(points, dtype=np.float64)
    if not np.isfinite(limit):
        return _bent(points, distortions)
    r = np.hypot(points[..., 0], points[..., 1])
    beyond = np.maximum(r / limit, 1.0)[..., None]
    if not (beyond > 1).any():
        return _bent(points, distortions)
    k1, k2, k3 = _polynomial(distortions)
    slope = 1 + limit**2 * (3 * k1 + limit**2 * (5 * k2 + limit**2 * 7 * k3))
    edge = points / beyond
    straight_on: Array = _bent(edge, distortions) + (points - edge) * slope
    return straight_on


def unbend(points: ArrayLike, distortions: Sequence[float], limit: float = np.inf) -> Array:
    """Take a lens off: the inverse of `bend`, to 1e-10, for points before the fold.

    Newton's method with the radial part alone as its slope; tangential terms are small.
    """
    target = np.asarray(points, dtype=np.float64)
    k1, k2, k3 = _polynomial(distortions)
    limit = min(limit, 0.999 * fold_radius(distortions))
    found = target.copy()
    for _ in range(100):
        error = target - bend(found, distortions, limit)
        if not len(error) or np.abs(error).max() < 1e-12:
            break
        r = np.minimum(np.hypot(found[..., 0], found[..., 1]), limit)
        r2 = r * r
        across = np.maximum(1 + r2 * (k1 + r2 * (k2 + r2 * k3)), 1e-3)
        along = np.maximum(1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3)), 1e-3)
        # Radially the slope is `along`, across it `across`.
        unit = found / np.maximum(np.hypot(found[..., 0], found[..., 1]), 1e-12)[..., None]
        radial = (error * unit).sum(axis=-1)
        step = error / across[..., None] + unit * (radial * (1 / along - 1 / across))[..., None]
        found = found + step
    return found


def border(size: tuple[int, int], count: int = 33) -> Array:
    """Return pixels along the border of an image, (4 · count, 2)."""
    right, bottom = size[0] - 0.5, size[1] - 0.5
    x, y = np.linspace(-0.5, right, count), np.linspace(-0.5, bottom, count)
    sides = [np.column_stack([x, np.full(count, at)]) for at in (-0.5, bottom)]
    sides += [np.column_stack([np.full(count, at), y]) for at in (-0.5, right)]
    return np.concatenate(sides)


def image_limit(K: Array, distortions: Sequence[float], size: tuple[int, int]) -> float:
    """Find the r, in units of the focal length and without the lens, up to which an image looks.

    Raises
    ------
    EpibarError
        The polynomial folds inside the image, or just beyond its corners.
    """
    seen = (border(size) - K[:2, 2]) / np.diag(K)[:2]
    fold = fold_radius(distortions)
    k1, k2, k3 = _polynomial(distortions)
    if np.isfinite(fold):
        reach = fold * (1 + fold**2 * (k1 + fold**2 * (k2 + fold**2 * k3)))
        if np.hypot(*seen.T).max() > 0.999 * reach:
            raise EpibarError(f"distortions {tuple(distortions)}: the lens folds inside the image")
    straight = unbend(seen, distortions)
    if np.abs(_bent(straight, distortions) - seen).max() > 1e-6:
        raise EpibarError(f"distortions {tuple(distortions)}: the lens has no inverse on the whole image")
    limit = float(np.hypot(*straight.T).max())
    if limit * FOLD_MARGIN > fold:
        raise EpibarError(f"distortions {tuple(distortions)}: the lens folds just beyond the image")
    return limit * BEYOND


def smooth_lens(k1: float, growth: float, reach: float, terms: int = 3) -> tuple[float, ...]:
    """Make the distortions of a wide lens as they are built: bending back evenly, without a fold.

    With r in units of the focal length, r' = r (1 + q r²)^(k1/q), q = ``growth``, grows everywhere for
    q ≥ −2 k1; equidistant lenses are near k1 = −1/3, q = 1. The k2 and k3 that come closest to it up to
    r = ``reach`` are found by least squares, k1 is kept.

    Parameters
    ----------
    k1 : float
    growth : float
    reach : float
        The largest r that the image shows.
    terms : {2, 3}
        Whether k3 is used.

    Returns
    -------
    k1, k2, p1, p2, k3 : tuple of float
    """
    r2 = np.linspace(0.0, reach, 200)[1:] ** 2
    left = (1 + growth * r2) ** (k1 / growth) - 1 - k1 * r2
    powers = np.column_stack([r2**2, r2**3])[:, : terms - 1]
    # Weighted by r: what counts is the displacement.
    weight = np.sqrt(r2)
    found = np.linalg.lstsq(powers * weight[:, None], left * weight, rcond=None)[0]
    return (k1, float(found[0]), 0.0, 0.0, float(found[1]) if terms > 2 else 0.0)
