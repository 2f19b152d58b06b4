"""Whether what a saved file holds can be what epibar wrote: shapes, types, ranges.

A recording's shapes are checked before its arrays are expanded; its values are the compiled module's to
check. Values of JSON are asked for one by one, by what they must be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeGuard

import numpy as np

from .. import _core
from ..arguments import is_number
from ..errors import EpibarError

__all__ = [
    "LONGEST_SIDE",
    "check_calibration",
    "check_format",
    "check_recording",
    "is_text",
    "is_truth",
    "is_whole_number",
    "list_of",
    "number_of",
    "text_of",
    "truth_of",
]

LONGEST_SIDE = 16_384
"""Pixels of an image, either way."""

MOST_LINES = _core.MAX_LINES


class Shaped(Protocol):
    """An array, or what a file says of one."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Its sides."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of its elements."""


def check_format(where: str, version: Any, known: int) -> None:
    """Check the version of a file.

    Raises
    ------
    EpibarError
        It is older or newer than the one that is read, or no version at all.
    """
    number = version.item() if isinstance(version, np.ndarray) and version.ndim == 0 else version
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise EpibarError(f"{where}: damaged: {str(version)[:40]!r} is no version of a format")
    if number != known:
        older, remedy = ("an older", "make it again") if number < known else ("a newer", "update epibar")
        reads = f"{where}: format {number}, but this epibar reads format {known}"
        raise EpibarError(f"{reads}: {older} epibar wrote it; {remedy}")


def is_truth(value: Any) -> TypeGuard[bool]:
    """Whether a value is true or false, and not 1 or 0."""
    return isinstance(value, bool)


def is_text(value: Any) -> TypeGuard[str]:
    """Whether a value is a text, if an empty one."""
    return isinstance(value, str)


def is_whole_number(value: Any, least: int, most: int) -> TypeGuard[int]:
    """Whether a value is a whole number within bounds, and not a truth value."""
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def truth_of(values: Mapping[str, Any], name: str) -> bool:
    """Return true or false.

    Raises
    ------
    KeyError
        There is no such value; so do :func:`text_of`, :func:`list_of` and :func:`number_of`.
    EpibarError
        It is something else; so do these.
    """
    value = values[name]
    if not is_truth(value):
        raise EpibarError(f"{name} is {value!r}, expected true or false")
    return value


def text_of(values: Mapping[str, Any], name: str) -> str:
    """Return a text that is not empty."""
    value = values[name]
    if not is_text(value) or not value:
        raise EpibarError(f"{name} is {value!r}, expected a text")
    return value


def list_of(values: Mapping[str, Any], name: str) -> list[Any]:
    """Return a list."""
    value = values[name]
    if not isinstance(value, list):
        raise EpibarError(f"{name} is {value!r}, expected a list")
    return value


def number_of(
    values: Mapping[str, Any], name: str, least: float = -math.inf, most: float = math.inf
) -> float | None:
    """Return a finite number within bounds, or None where that stands there."""
    value = values[name]
    if value is None:
        return None
    if not is_number(value):
        raise EpibarError(f"{name} is {value!r}, expected a finite number")
    if not least <= value <= most:
        raise EpibarError(f"{name} is {value!r}, expected a number between {least:g} and {most:g}")
    return float(value)


RECORDING: dict[str, tuple[str, tuple[int | str, ...]]] = {
    "epibar_recording": ("iu", ()),
    "name": ("U", ()),
    "warnings": ("U", ("warnings",)),
    "health_names": ("U", ("health",)),
    "health_values": ("f", ("health",)),
    "first_frame": ("iu", ()),
    "pixel_aspect": ("f", ()),
    "matrix": ("f", (3, 3)),
    "distortions": ("f", ("distortions",)),
    "fisheye": ("b", ()),
    "core_size": ("u", (2,)),
    "core_seed": ("u", (1,)),
    "core_times": ("f", ("frames",)),
    "core_segments": ("f", ("lines", 4)),
    "core_barcodes": ("u", ("lines", "words")),
    "core_heat": ("u", ("height", "width")),
    "core_visible": ("u", ("height", "width")),
    "core_moving_pixels": ("u", ("frames",)),
    "core_frame_start": ("u", ("frames + 1",)),
    "core_hull_start": ("u", ("hulls + 1",)),
    "core_hull_points": ("u", ("points", 2)),
    "core_hull_area": ("u", ("hulls",)),
    "core_hull_border": ("b", ("hulls",)),
    "core_outline_start": ("u", ("outlines",)),
    "core_outline_points": ("u", ("points of outlines", 2)),
}
"""Kind of dtype and shape of each array; the same word is the same length everywhere."""

OPTIONAL = {
    "matrix",
    "distortions",
    "fisheye",
    "core_visible",
    "health_names",
    "health_values",
    "first_frame",
    "pixel_aspect",
    "core_outline_start",
    "core_outline_points",
}


def check_recording(where: str, arrays: Mapping[str, Shaped]) -> None:
    """Check that the shapes and types of a recording's arrays fit together; others are not looked at.

    Raises
    ------
    EpibarError
        One is missing, or does not fit.
    """
    lengths: dict[str, int] = {}
    if "core_times" in arrays and len(arrays["core_times"].shape) == 1:
        lengths["words"] = -(-arrays["core_times"].shape[0] // 64)
    for name, (kind, sides) in RECORDING.items():
        if name not in arrays:
            if name in OPTIONAL:
                continue
            raise EpibarError(f"{where}: damaged: {name} is missing")
        array = arrays[name]
        if array.dtype.kind not in kind or len(array.shape) != len(sides):
            raise EpibarError(f"{where}: damaged: {name} is {array.dtype} of shape {array.shape}")
        expected = [_side(lengths, side, length) for side, length in zip(sides, array.shape, strict=True)]
        if expected != list(array.shape):
            raise EpibarError(f"{where}: damaged: {name} has the shape {array.shape}, which does not fit")
    most = {"lines": MOST_LINES, "width": LONGEST_SIDE, "height": LONGEST_SIDE}
    for word, limit in most.items():
        if lengths[word] > limit:
            raise EpibarError(f"{where}: damaged: {lengths[word]:,} {word}, where at most {limit:,} can be")


def _side(lengths: dict[str, int], side: int | str, length: int) -> int:
    """Return what a side must be; where that is known by a word, the first to have it says how long it is."""
    if isinstance(side, int):
        return side
    word, _, more = side.partition(" + ")
    return max(0, lengths.setdefault(word, length - int(more or 0))) + int(more or 0)


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _positive(value: Any) -> bool:
    return is_number(value) and value > 0


def _count(value: Any) -> bool:
    return is_whole_number(value, 0, 2**64 - 1)


def _or_none(holds: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: value is None or holds(value)


def _named(holds: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, dict) and all(map(holds, value.values()))


def _array(kind: str, *sides: int | None, finite: bool = True) -> Callable[[Any], bool]:
    def holds(value: Any) -> bool:
        if not isinstance(value, np.ndarray) or value.dtype.kind not in kind or value.ndim != len(sides):
            return False
        fits = all(side in (None, length) for side, length in zip(sides, value.shape, strict=True))
        return fits and (not finite or bool(np.isfinite(value).all()))

    return holds


_matrix = _array("fiu", 3, 3)


def _rivals(value: Any) -> bool:
    return isinstance(value, list) and all(map(_rival, value))


def _rival(value: Any) -> bool:
    if not isinstance(value, dict) or not _matrix(value.get("F")) or not is_text(value.get("source")):
        return False
    return all(_number(value.get(name, 0.0)) for name in ("evidence_share", "evidence_z", "distance"))


CALIBRATION: dict[str, Callable[[Any], bool]] = {
    "F": _or_none(_matrix),
    "accepted": is_truth,
    "kind": is_text,
    "reason": is_text,
    "expected_error": _or_none(is_number),
    "time_offset": is_number,
    "counts": _named(_count),
    "floor": _or_none(_matrix),
    "rivals": _rivals,
    "evidence": _named(_number),
    "source": is_text,
    "method": is_text,
    "seed": _count,
    "timing.frames_per_frame": _positive,
    "timing.offset_uncertainty": _or_none(_number),
    "timing.drift": _or_none(_number),
    "timing.drift_uncertainty": _or_none(_number),
    "timing.drift_used": is_truth,
    "timing.runner_up": _or_none(_number),
    "timing.runner_up_share": _or_none(_number),
    "timing.offsets_tried": _count,
    "candidates.lines_a": _array("f", None, 3),
    "candidates.lines_b": _array("f", None, 3),
    "candidates.correlation": _array("f", None),
    "candidates.inliers": _array("b", None),
    "frontier_points.frame": _array("iu", None),
    "frontier_points.a": _array("f", None, 2),
    "frontier_points.b": _array("f", None, 2),
    "frontier_points.residual": _array("f", None),
    "shift_curve.0": _array("fiu", None),
    "shift_curve.1": _array("f", None, finite=False),
    "error_maps.0": _array("f", None, None, finite=False),
    "error_maps.1": _array("f", None, None, finite=False),
}
"""What each value of a calibration must be, where it is there."""

TUPLES = ("shift_curve", "error_maps")
NESTED = ("candidates", "frontier_points", "timing")
"""Values that come in parts, with a dot in their names."""

ALIKE = (
    ("candidates.lines_a", "candidates.lines_b", "candidates.correlation", "candidates.inliers"),
    ("frontier_points.frame", "frontier_points.a", "frontier_points.b", "frontier_points.residual"),
    ("shift_curve.0", "shift_curve.1"),
)
"""Arrays of one length."""


def check_calibration(values: Mapping[str, Any]) -> None:
    """Check the values of a saved calibration by their names; others are not looked at.

    Raises
    ------
    ValueError
        One is of another type, shape or range, or two do not fit together.
    """
    for name, holds in CALIBRATION.items():
        if name in values and not holds(values[name]):
            raise ValueError(f"{name} is not what belongs there")
    for name, value in values.items():
        whole, dot, _ = name.partition(".")
        missing = name == "error_maps" and value is None
        if whole in (TUPLES if dot else (*TUPLES, *NESTED)) and name not in CALIBRATION and not missing:
            raise ValueError(f"{name} has no place in a calibration")
    for names in ALIKE:
        if len({len(values[name]) for name in names if name in values}) > 1:
            raise ValueError(f"{' and '.join(reversed(names))} do not have one length")
    for name in TUPLES:
        if (f"{name}.0" in values) != (f"{name}.1" in values):
            raise ValueError(f"there is one {name}, where two belong")
    frames = values.get("frontier_points.frame", np.empty(0))
    if len(frames) and not 0 <= int(frames.min()) <= int(frames.max()) < 2**32:
        raise ValueError("frontier_points.frame is out of range")
    if values.get("accepted") and values.get("F") is None:
        raise ValueError("it is accepted, but has no F")
