"""Which share of its time a task has had when it tells what it is at.

A search tells its stage and how much of that stage is done. Where in its time the stages begin was measured
on nineteen made-up pairs (``timed`` of ``benchmarks/pair_stages.py``): fourteen ended with few hypotheses,
and five went on, which took three times as long. So what few hypotheses take counts for more than it is of
a search that goes on, and for less than it is of one that ends. With a clock that is learned it begins anew.
"""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise

__all__ = ["PairShare", "joining_share"]

BEGINS = {
    "candidates": 0.0,
    "few": 0.07,
    "best_lines": 0.25,
    "all_lines": 0.30,
    "line_inliers": 0.34,
    "floor": 0.365,
    "floor_epipoles": 0.375,
    "tracks": 0.45,
    "top_view": 0.52,
    "refine": 0.55,
    "restart": 0.65,
    "explore": 0.75,
    "settle": 0.89,
}
"""Share of one round of a search at which each of its stages begins."""

ENDS = dict(pairwise(BEGINS.values())) | {BEGINS["settle"]: 1.0}

ENDS_EARLY = 0.62
"""Share of a round at which settling begins where few hypotheses were enough."""

JOINING = ((0.0, 0.0), (0.4, 0.52), (0.7, 0.81), (0.9, 1.0), (1.0, 1.0))
"""Shares that joining reports, and those of its time."""

NEVER_ALL = 0.98
"""Of a search that goes on, however many rounds it had."""


class PairShare:
    """The share of the search of one pair.

    Parameters
    ----------
    rounds : int
        How often it is gone through its stages, as far as is known before.
    """

    def __init__(self, rounds: int) -> None:
        self._rounds = rounds
        self._round = 0
        self._share = 0.0
        self._before = ""

    def tell(self, stage: str, share: float) -> float:
        """Take what the search tells; returns the share of the whole, which never goes back."""
        if stage == "candidates" and share == 0.0:
            self._round += 1
        if stage in BEGINS:
            begins, ends = BEGINS[stage], ENDS[BEGINS[stage]]
            if stage != "settle":
                self._before = stage
            elif self._before in ("candidates", "few"):
                begins = ENDS_EARLY
            within = begins + (ends - begins) * min(max(share, 0.0), 1.0)
        elif stage == "lines":  # the paper's method has only this
            within = min(max(share, 0.0), 1.0)
        else:
            return self._share
        whole = (max(self._round - 1, 0) + within) / max(self._rounds, self._round)
        self._share = max(self._share, min(whole, NEVER_ALL))
        return self._share


def joining_share(reported: float) -> float:
    """Share of the time of joining all pairs that is over, of the share that joining reports."""
    at = min(bisect_right(JOINING, (reported, 2.0)), len(JOINING) - 1)
    (before, share), (after, end) = JOINING[at - 1], JOINING[at]
    return min(share + (end - share) * max(reported - before, 0.0) / (after - before), 1.0)
