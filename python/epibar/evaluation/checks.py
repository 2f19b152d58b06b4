"""Checks of what a user hands in, with errors that name the argument; vectors as geometry needs them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import EpibarError

Array = NDArray[np.float64]
Size = tuple[int, int]


def checked(name: str, value: ArrayLike, columns: int | tuple[int, int]) -> Array:
    """``value`` as finite float64 of shape (n, columns), or of the exact shape when a tuple is given."""
    array = np.asarray(value, dtype=np.float64)
    exact = isinstance(columns, tuple)
    if array.shape != columns if exact else (array.ndim != 2 or array.shape[1] != columns):
        wanted = columns if exact else f"(n, {columns})"
        raise EpibarError(f"{name}: shape {array.shape}, expected {wanted}")
    if not np.isfinite(array).all():
        raise EpibarError(f"{name}: {int((~np.isfinite(array)).sum())} values are NaN or infinite")
    return array


def homogeneous(points: Array) -> Array:
    """(n, 2) points as (n, 3) with a one."""
    return np.column_stack([points, np.ones(len(points))])


def cross_matrix(vector: Array) -> Array:
    """``[v]ₓ``, with ``[v]ₓ w = v × w``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
