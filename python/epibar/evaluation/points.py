"""Correspondences to measure an F on, and how far they are from its epipolar lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Size, as_finite
from ..errors import EpibarError
from ..geometry.epipolar import symmetric_epipolar_distance
from ..geometry.lines import clip_lines
from ..geometry.vectors import homogeneous

GOOD_PAIR_PX = 3.0


def image_correspondences(
    F_true: ArrayLike, size_a: Size, size_b: Size, n: int = 10_000, seed: int = 0
) -> tuple[Array, Array]:
    """Correspondences over the whole image, made with the true F as the paper makes them.

    x_a is uniform in image A, x_b uniform on the part of its true epipolar line inside image B; points whose
    line misses B are drawn anew.

    Returns
    -------
    points_a, points_b : (n, 2) array
        Pixels.

    Raises
    ------
    EpibarError
        If the epipolar lines of image A (nearly) all miss image B.
    """
    F = as_finite("F_true", F_true, (3, 3))
    rng = np.random.default_rng(seed)
    kept_a, kept_b, count = [], [], 0
    for _ in range(100):
        a = rng.uniform(0.0, 1.0, (n, 2)) * (np.array(size_a) - 1.0)
        segments, hit = clip_lines(homogeneous(a) @ F.T, size_b)
        share = rng.uniform(0.0, 1.0, (n, 1))
        b = segments[:, 0] + share * (segments[:, 1] - segments[:, 0])
        kept_a.append(a[hit])
        kept_b.append(b[hit])
        count += int(hit.sum())
        if count >= n:
            return np.concatenate(kept_a)[:n], np.concatenate(kept_b)[:n]
    raise EpibarError(f"F_true: only {count} of {100 * n} epipolar lines of image A cross image B")


def moving_volume(
    points3d: ArrayLike, n: int = 10_000, seed: int = 0, percentiles: tuple[float, float] = (3.0, 97.0)
) -> Array:
    """Random points in the volume where things moved, for recordings with known cameras.

    The volume is the axis-aligned box between two percentiles of triangulated points, which leaves out
    what a few wrong matches put far away.

    Returns
    -------
    (n, 3) array
    """
    points = as_finite("points3d", points3d, 3)
    if len(points) < 2:
        raise EpibarError(f"points3d: {len(points)} points do not span a volume")
    low, high = np.percentile(points, percentiles, axis=0)
    return np.random.default_rng(seed).uniform(low, high, (n, 3))


@dataclass(frozen=True)
class MeanErrors:
    """Mean symmetric epipolar distances of an F, pixels: over the image, and over the volume of motion."""

    image_error: float
    volume_error: float
    volume_points: int

    @property
    def good(self) -> bool:
        """A good pair, by the error over the volume (over the image where no volume was given)."""
        return good_pair(self.volume_error if self.volume_points else self.image_error)


def good_pair(error_px: float, limit: float = GOOD_PAIR_PX) -> bool:
    """Whether an error makes a good pair: below 3 px; NaN is not good."""
    return bool(error_px < limit)


def compare(
    F: ArrayLike,
    F_true: ArrayLike,
    size_a: Size,
    size_b: Size,
    volume: tuple[ArrayLike, ArrayLike] | None = None,
    n: int = 10_000,
    seed: int = 0,
) -> MeanErrors:
    """Errors of F against the true one.

    Parameters
    ----------
    F, F_true : (3, 3) array
    size_a, size_b : (width, height)
    volume : pair of (m, 2) arrays, optional
        True correspondences over the volume where things moved, from `volume_correspondences`.
        Without it, or with none in both images, the volume error is NaN.
    n, seed
        For `image_correspondences`.
    """
    a, b = image_correspondences(F_true, size_a, size_b, n, seed)
    image_error = float(symmetric_epipolar_distance(F, a, b).mean())
    if volume is None or len(np.asarray(volume[0])) == 0:
        return MeanErrors(image_error, float("nan"), 0)
    distance = symmetric_epipolar_distance(F, *volume)
    return MeanErrors(image_error, float(distance.mean()), len(distance))
