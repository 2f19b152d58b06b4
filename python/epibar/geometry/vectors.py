"""Checks of what a user hands in, with errors that name the argument; vectors as geometry needs them."""

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
