"""Fisheye lenses: what is θ off the axis is seen at θ (1 + k θ²), in units of the focal length.

That is OpenCV's fisheye model with its first coefficient alone
(https://docs.opencv.org/4.x/db/d58/group__calib3d__fisheye.html). With k = 0 it is the equidistant lens, and
near the equisolid one at −1/24 and the stereographic one at 1/12. Networks do not model it:
these are here for what their polynomial makes of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array

STEPS = 8
"""Newton steps on the way back; four are needed."""

STRAIGHT_AHEAD = 1e-12
"""Distances below this are taken for this one: on the axis all directions are alike."""


def seen_at(theta: Any, k: float) -> Any:
    """Return how far from the middle what is ``theta`` off the axis is seen, in units of the focal length."""
    return theta * (1 + k * theta**2)


def bend(points: ArrayLike, k: float) -> Array:
    """Apply a fisheye lens to (..., 2) points of a pinhole, in units of the focal length."""
    points = np.asarray(points, dtype=np.float64)
    r = np.maximum(np.hypot(points[..., 0], points[..., 1]), STRAIGHT_AHEAD)
    bent: Array = points * (seen_at(np.arctan(r), k) / r)[..., None]
    return bent


def unbend(points: ArrayLike, k: float) -> Array:
    """Take a fisheye lens off; NaN at and beyond a right angle to the axis, which no pinhole sees."""
    points = np.asarray(points, dtype=np.float64)
    seen = np.maximum(np.hypot(points[..., 0], points[..., 1]), STRAIGHT_AHEAD)
    theta = np.minimum(seen, np.pi / 2)
    for _ in range(STEPS):
        theta = theta - (seen_at(theta, k) - seen) / (1 + 3 * k * theta**2)
    r = np.where(seen < seen_at(np.pi / 2, k), np.tan(theta), np.nan)
    straight: Array = points * (r / seen)[..., None]
    return straight
