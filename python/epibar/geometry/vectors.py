"""Vectors, and angles between rotations, as geometry needs them."""

from __future__ import annotations

import numpy as np

from ..arguments import Array


def homogeneous(points: Array) -> Array:
    """(n, 2) points as (n, 3) with a one."""
    return np.column_stack([points, np.ones(len(points))])


def cross_matrix(vector: Array) -> Array:
    """``[v]ₓ``, with ``[v]ₓ w = v × w``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def angle_between(one: Array, other: Array) -> float:
    """Angle of the rotation between two rotation matrices, degrees; exact for small ones too."""
    return float(np.rad2deg(2 * np.arcsin(np.clip(np.linalg.norm(one - other) / np.sqrt(8), 0, 1))))
