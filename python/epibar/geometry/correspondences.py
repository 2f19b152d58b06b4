"""What the two views of a pair have in common: lines with like motion barcodes, and points."""

from __future__ import annotations

from dataclasses import dataclass

from ..arguments import Array, Bits, Index

__all__ = ["Candidates", "FrontierPoints"]


@dataclass(frozen=True, eq=False)
class Candidates:
    """Pairs of lines whose motion barcodes correlate.

    Attributes
    ----------
    lines_a, lines_b : ndarray, shape (n, 3)
        Lines (a, b, c) with a² + b² = 1, pixels.
    correlation : ndarray, shape (n,)
        Of their barcodes, falling.
    inliers : ndarray, shape (n,), bool
        Which of them are epipolar under F.
    """

    lines_a: Array
    lines_b: Array
    correlation: Array
    inliers: Bits

    def __len__(self) -> int:
        return len(self.correlation)


@dataclass(frozen=True, eq=False)
class FrontierPoints:
    """Point correspondences: where epipolar planes touch a moving object, seen by both cameras.

    Attributes
    ----------
    frame : ndarray, shape (m,), int
        Frame of A. The moment's frame of B is :meth:`Calibration.frame_of_b`.
    a, b : ndarray, shape (m, 2)
        Pixels (x, y), on the silhouettes.
    residual : ndarray, shape (m,)
        Symmetric epipolar distance under F, pixels; what outlines are off by is in it.
    """

    frame: Index
    a: Array
    b: Array
    residual: Array

    def __len__(self) -> int:
        return len(self.frame)
