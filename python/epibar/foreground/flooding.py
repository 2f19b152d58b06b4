"""Flooded frames: more than 60 % foreground tells nothing about what moves."""

from __future__ import annotations

import numpy as np

from ..arguments import Mask

__all__ = ["FLOOD_SHARE", "moving_share"]

FLOOD_SHARE = 0.6


def moving_share(mask: Mask, counted: Mask | None = None) -> float:
    """Share of the image that is foreground, where it counts."""
    if counted is None:
        return float(np.count_nonzero(mask) / mask.size)
    return float(np.count_nonzero(np.logical_and(mask, counted)) / max(1, int(np.count_nonzero(counted))))
