"""Points that two cameras see alike, to be written beside the cameras."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import Array

__all__ = ["TwoViews"]


@dataclass(frozen=True, eq=False)
class TwoViews:
    """Points of two cameras, n of them in the order of time: measured in the images, not projected.

    Attributes
    ----------
    a, b : str
        Names of the cameras.
    pixels_a, pixels_b : ndarray, shape (n, 2)
        Where either sees them, raw pixels of its lens, pixel centres at integers.
    """

    a: str
    b: str
    pixels_a: Array
    pixels_b: Array

    def __len__(self) -> int:
        return len(self.pixels_a)

    def thinned(self, most: int) -> TwoViews:
        """Return so many at most, spread evenly over the time."""
        if len(self) <= most:
            return self
        kept = np.linspace(0, len(self) - 1, most).round().astype(int)
        return TwoViews(self.a, self.b, self.pixels_a[kept], self.pixels_b[kept])
