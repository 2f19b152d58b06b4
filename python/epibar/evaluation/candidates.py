"""Which candidate pairs of lines are true (paper, §4.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Bits, Size, as_finite
from ..errors import EpibarError
from ..geometry.epipolar import epipoles
from ..geometry.lines import area_between_lines, clip_lines
from ..geometry.vectors import homogeneous

__all__ = ["true_candidate_rate", "true_candidates"]


def true_candidates(
    lines_a: ArrayLike, lines_b: ArrayLike, F_true: ArrayLike, size_a: Size, size_b: Size
) -> Bits:
    """Tell which candidate pairs of corresponding epipolar lines are true, by §4.1.

    A line is true when the image area between it and the true epipolar line through its midpoint (of the part
    inside the image) is below 3 × image width; a pair is true when both its lines are. As in the paper, the
    two lines are not asked to correspond to each other.

    Parameters
    ----------
    lines_a, lines_b : (n, 3) array
        Line i of A is paired with line i of B.
    F_true : (3, 3) array
    size_a, size_b : (width, height)

    Returns
    -------
    (n,) bool array
    """
    lines_a, lines_b = as_finite("lines_a", lines_a, 3), as_finite("lines_b", lines_b, 3)
    if len(lines_a) != len(lines_b):
        raise EpibarError(f"lines_b: {len(lines_b)} lines, but lines_a has {len(lines_a)}")
    true = np.ones(len(lines_a), dtype=bool)
    for lines, epipole, size in zip((lines_a, lines_b), epipoles(F_true), (size_a, size_b), strict=True):
        segments, hit = clip_lines(lines, size)
        middle = homogeneous(np.where(hit[:, None], segments.mean(axis=1), 0.0))
        epipolar = np.cross(epipole, middle)
        at_epipole = np.hypot(epipolar[:, 0], epipolar[:, 1]) < 1e-12
        area = area_between_lines(lines, np.where(at_epipole[:, None], lines, epipolar), size)
        true &= hit & (area < 3 * size[0])
    return true


def true_candidate_rate(
    lines_a: ArrayLike, lines_b: ArrayLike, F_true: ArrayLike, size_a: Size, size_b: Size
) -> float:
    """Return the share of pairs that are true (§4.1), see `true_candidates`; NaN where there are none."""
    true = true_candidates(lines_a, lines_b, F_true, size_a, size_b)
    return float(true.mean()) if len(true) else float("nan")
