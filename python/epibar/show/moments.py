"""Which moments of a pair a report shows."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..arguments import Bits, Index
from ..calibration import Calibration
from ..recording import Recording

__all__ = ["MOMENTS", "busiest_window", "choose_moments", "points_per_frame", "with_pictures"]

MOMENTS = 16
"""Frames to scrub through, per pair."""


def points_per_frame(common: Index, a: Recording, b: Recording, calibration: Calibration) -> Index:
    """How much each moment has to show: its frontier points, or else whether both cameras see something."""
    if len(calibration.frontier_points):
        return np.bincount(calibration.frontier_points.frame, minlength=a.frames)[common[:, 0]]
    moving = np.minimum(a.moving_pixels[common[:, 0]], b.moving_pixels[common[:, 1]])
    return moving.astype(np.int64)


def with_pictures(
    common: Index,
    worth: Index,
    pictures_a: Collection[int],
    pictures_b: Collection[int],
    least: int = MOMENTS // 2,
) -> Bits:
    """Which moments have the most to look at: pictures of both cameras; or of one at least; or else all.

    Parameters
    ----------
    common : ndarray, shape (n, 2)
        Frames of A and of B.
    worth : ndarray, shape (n,)
        How much each has to show; those of none do not count where others have some.
    pictures_a, pictures_b : collections of int
        Frames of which there are pictures.
    least : int
        So many moments must have them.

    Returns
    -------
    ndarray, shape (n,), bool
    """
    there = np.isin(common[:, 0], list(pictures_a)).astype(int) + np.isin(common[:, 1], list(pictures_b))
    if (worth > 0).any():
        there[worth <= 0] = 0
    enough = [cameras for cameras in (2, 1) if np.count_nonzero(there >= cameras) >= least]
    shown: Bits = there >= (enough[0] if enough else 0)
    return shown


def choose_moments(
    common: Index, worth: Index, wanted_a: Collection[int], wanted_b: Collection[int], count: int = MOMENTS
) -> Index:
    """Choose moments spread over the time both cameras share.

    Parameters
    ----------
    common : ndarray, shape (n, 2)
        Frames of A and of B, see :func:`epibar.clocks.common_frames`.
    worth : ndarray, shape (n,)
        How much each has to show.
    wanted_a, wanted_b : collections of int
        Frames that other pairs show already: they cost nothing, so they come first where they show anything.
    count : int

    Returns
    -------
    ndarray, shape (at most count, 2)
    """
    busy = np.flatnonzero(worth > 0)
    if len(busy):
        inside = slice(busy[0], busy[-1] + 1)
        common, worth = common[inside], worth[inside]
    known = np.isin(common[:, 0], list(wanted_a)).astype(np.int64) + np.isin(common[:, 1], list(wanted_b))
    score = np.where(worth > 0, worth + known * (int(worth.max(initial=0)) + 1), 0)
    chosen = [
        part[int(score[part].argmax())]
        for part in np.array_split(np.arange(len(common)), min(count, len(common)) or 1)
        if len(part)
    ]
    return common[chosen]


def busiest_window(worth: Index, length: int) -> slice:
    """Find the stretch of ``length`` moments that has most to show."""
    if len(worth) <= length:
        return slice(0, len(worth))
    sums = np.concatenate([[0], np.cumsum(worth)])
    start = int((sums[length:] - sums[:-length]).argmax())
    return slice(start, start + length)
