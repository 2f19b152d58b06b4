"""What a caller passes in: the types of arrays, and the checks, whose messages name the argument."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import EpibarError

__all__ = [
    "MAX_SEED",
    "AnyArray",
    "Array",
    "Array32",
    "Bits",
    "Image",
    "Index",
    "Mask",
    "Order",
    "PackedBits",
    "PathLike",
    "Size",
    "Unsigned",
    "as_camera_matrix",
    "as_finite",
    "as_masks",
    "as_numbers",
    "as_positive",
    "as_rotation",
    "as_text",
    "as_whole_number",
    "camera_names",
    "check_between",
    "check_choice",
    "check_pairs",
    "core_errors",
    "is_number",
]

AnyArray = NDArray[Any]
Array = NDArray[np.float64]
Array32 = NDArray[np.float32]
Bits = NDArray[np.bool_]
PackedBits = NDArray[np.uint64]
"""(n, words): bit i of a row is frame i."""
Index = NDArray[np.int64]
Order = NDArray[np.intp]
"""Indices as NumPy's own sorting gives them."""
Unsigned = NDArray[np.uint32]
Image = NDArray[np.uint8]
"""(H, W, 3), blue, green, red; or (H, W), grey."""
Mask = NDArray[np.uint8]
"""(H, W) or (T, H, W), non-zero where something moves."""
Size = tuple[int, int]
"""Width and height, pixels."""
PathLike = str | os.PathLike[str]

MAX_SEED = 2**64 - 1


@contextmanager
def core_errors() -> Iterator[None]:
    """Turn what the compiled module refuses into :class:`EpibarError`."""
    try:
        yield
    except EpibarError:
        raise
    except (ValueError, OverflowError) as error:
        raise EpibarError(str(error)) from error


def as_whole_number(name: str, value: Any, least: int, most: int | None = None) -> int:
    """Return ``value`` as an int within [least, most]; bool and float are refused."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise EpibarError(f"{name} = {value!r}: expected a whole number") from None
    if number < least or (most is not None and number > most):
        bound = f"at least {least}" if most is None else f"between {least} and {most}"
        raise EpibarError(f"{name} = {number}: it must be {bound}")
    return number


def as_masks(masks: Any) -> Mask:
    """Return masks as a C-contiguous (T, H, W) array of uint8, or say what is wrong with them."""
    try:
        array = np.asarray(masks)
    except ValueError as error:
        raise EpibarError(f"masks are no array of (frames, height, width): {error}") from None
    if array.dtype != np.bool_ and array.dtype != np.uint8:
        raise EpibarError(
            f"masks have dtype {array.dtype}, expected bool or uint8, non-zero = moving; "
            "threshold them first, e.g. masks > 0.5"
        )
    if array.ndim != 3:
        raise EpibarError(f"masks have shape {array.shape}, expected (frames, height, width)")
    if array.size == 0:
        raise EpibarError(f"masks have shape {array.shape}: no frames or no pixels")
    array = np.ascontiguousarray(array)
    return array.view(np.uint8)


LEAST_SKEW = 1e-3
"""Pixels of skew of a camera matrix that are none."""


def as_camera_matrix(matrix: Any, name: str = "matrix") -> Array:
    """Return a camera matrix as a (3, 3) array, or say what is wrong with it."""
    try:
        array = np.array(matrix, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):
        raise EpibarError(f"{name} = {matrix!r}: expected numbers, 3 x 3") from None
    if array.shape != (3, 3):
        raise EpibarError(f"{name} has shape {array.shape}, expected 3 x 3 numbers")
    if not np.isfinite(array).all():
        raise EpibarError(f"{name} is {array.tolist()}, which is not finite")
    if array[0, 0] <= 0 or array[1, 1] <= 0 or not np.allclose(array[2], (0, 0, 1), atol=1e-9):
        raise EpibarError(f"{name} is {array.tolist()}, expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
    return array


def as_text(name: str, value: Any) -> str:
    """Return a text, or say that it is none."""
    if not isinstance(value, str):
        raise EpibarError(f"{name} is {value!r}, expected a text")
    return value


def as_rotation(name: str, value: Any, tolerance: float) -> Array:
    """Return a rotation (3, 3), whose RᵀR may differ from the identity by so much, or say that it is none."""
    rotation = as_numbers(name, value, (3, 3))
    large = np.abs(rotation).max() > 1 + tolerance  # products of such may overflow
    if large or np.abs(rotation.T @ rotation - np.eye(3)).max() > tolerance or np.linalg.det(rotation) < 0:
        raise EpibarError(f"{name} is {rotation.tolist()}, which is none")
    return rotation


def as_numbers(name: str, value: Any, shape: tuple[int, ...] | None) -> Array:
    """Return finite numbers of a shape, or of any where that is None."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise EpibarError(f"{name} is {value!r}, expected numbers") from None
    if shape is not None and numbers.shape != shape:
        raise EpibarError(f"{name} has shape {numbers.shape}, expected {shape}")
    if not np.isfinite(numbers).all():
        raise EpibarError(f"{name} is {numbers.tolist()}, which is not finite")
    return numbers


def is_number(value: Any) -> bool:
    """Whether a value is a finite real number, and not a truth value."""
    if not isinstance(value, (int, float, np.integer, np.floating)) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number that is larger than any other
        return False


def as_positive(name: str, value: Any, unit: str) -> float:
    """Return a number above 0; ``unit`` says of what, for the error."""
    if not (is_number(value) and value > 0):
        raise EpibarError(f"{name} = {value!r}: it must be a positive number of {unit}")
    return float(value)


def check_between(name: str, value: Any, least: float, below: float, expected: str) -> None:
    """Check that a number lies within [least, below); ``expected`` says so, for the error."""
    if not (is_number(value) and least <= value < below):
        raise EpibarError(f"{name} = {value!r}: it must be {expected}")


def check_choice(name: str, value: Any, choices: Collection[str]) -> None:
    """Check that a value is one of some words."""
    if not isinstance(value, str) or value not in choices:
        raise EpibarError(f"{name} = {value!r}: it must be one of {', '.join(choices)}")


def camera_names(names: Iterable[str]) -> list[str]:
    """Return the names of recordings; those without one are called cam1, cam2, … by their place."""
    found = [name or f"cam{index + 1}" for index, name in enumerate(names)]
    if len(set(found)) < len(found):
        raise EpibarError(f"recordings are called {', '.join(found)}: give each its own name")
    return found


def check_pairs(keys: Iterable[Any], cameras: int) -> None:
    """Check that each key of a mapping of calibrations is two places among so many recordings."""
    for key in keys:
        pair = isinstance(key, tuple) and len(key) == 2 and key[0] != key[1]
        if not pair or not all(index in range(cameras) for index in key):
            raise EpibarError(f"calibrations have key {key!r}: expected two places in recordings")


def as_finite(name: str, value: ArrayLike, columns: int | tuple[int, int]) -> Array:
    """``value`` as finite float64 of shape (n, columns), or of the exact shape when a tuple is given."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise EpibarError(f"{name}: expected numbers") from None
    exact = isinstance(columns, tuple)
    if array.shape != columns if exact else (array.ndim != 2 or array.shape[1] != columns):
        wanted = columns if exact else f"(n, {columns})"
        raise EpibarError(f"{name}: shape {array.shape}, expected {wanted}")
    if not np.isfinite(array).all():
        raise EpibarError(f"{name}: {int((~np.isfinite(array)).sum())} values are NaN or infinite")
    return array
