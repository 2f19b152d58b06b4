"""A :class:`~epibar.calibration.Calibration` as named arrays, which is what its ``.npz`` file holds.

Every array is an entry of its own, ``candidates.lines_a`` or ``shift_curve.0``; all the rest is one JSON
text, in which numbers are written so that they come back exactly.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from ..arguments import AnyArray
from ..errors import EpibarError
from .checks import check_calibration, check_format

__all__ = ["KIND", "from_arrays", "to_arrays"]

FORMAT = 1
"""Version of the saved file; a file of another one is refused."""

KIND = "a calibration saved by epibar"
MARK = "epibar_calibration"
HEADER = "header"
ARRAY = "ndarray"

T = TypeVar("T")


def to_arrays(calibration: Any) -> dict[str, AnyArray]:
    """Take a calibration apart."""
    arrays: dict[str, AnyArray] = {MARK: np.array(FORMAT)}
    header: dict[str, Any] = {}
    for name, value in _parts(calibration):
        if isinstance(value, np.ndarray):
            arrays[name] = value
        else:
            header[name] = value
    arrays[HEADER] = np.array(json.dumps(header, default=_json_value, ensure_ascii=False))
    return arrays


def _parts(value: Any) -> Iterator[tuple[str, Any]]:
    """Names and values of a dataclass, those of its dataclasses and tuples behind a dot."""
    for field in fields(value):
        part = getattr(value, field.name)
        if is_dataclass(part):
            yield from ((f"{field.name}.{name}", inner) for name, inner in _parts(part))
        elif isinstance(part, tuple):
            yield from ((f"{field.name}.{index}", inner) for index, inner in enumerate(part))
        else:
            yield field.name, part


def _json_value(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return {ARRAY: value.tolist()}
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no place in a saved calibration")


def from_arrays(
    kind: type[T], nested: Mapping[str, type[Any]], arrays: Mapping[str, AnyArray], where: str
) -> T:
    """Put a calibration together again.

    Parameters
    ----------
    kind : type
        The dataclass.
    nested : mapping of str to type
        Its fields that are dataclasses themselves.
    arrays : mapping of str to ndarray
        What :func:`to_arrays` returned; further entries are not looked at.
    where : str
        What to call them in errors.

    Raises
    ------
    EpibarError
        They are something else, damaged, or of another format.
    """
    if MARK not in arrays:
        raise EpibarError(f"{where}: not {KIND}")
    try:
        check_format(where, arrays[MARK], FORMAT)
        header = json.loads(str(arrays[HEADER]), object_hook=_array_of)
        if not isinstance(header, dict) or not header.keys().isdisjoint(arrays):
            raise ValueError("the header is no list of names and values of its own")
        values = {**{name: array for name, array in arrays.items() if name not in (MARK, HEADER)}, **header}
        check_calibration(values)
        return _built(kind, "", nested, values)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
        if isinstance(error, EpibarError):
            raise
        raise EpibarError(f"{where}: damaged ({error})") from error


def _array_of(value: dict[str, Any]) -> Any:
    return np.array(value[ARRAY]) if value.keys() == {ARRAY} else value


def _built(kind: type[T], prefix: str, nested: Mapping[str, type[Any]], values: Mapping[str, Any]) -> T:
    arguments = {}
    for field in fields(kind):  # type: ignore[arg-type]
        name = prefix + field.name
        if name in values:
            arguments[field.name] = values[name]
        elif field.name in nested:
            arguments[field.name] = _built(nested[field.name], name + ".", {}, values)
        elif f"{name}.0" in values:
            count = sum(key.startswith(f"{name}.") for key in values)
            arguments[field.name] = tuple(values[f"{name}.{index}"] for index in range(count))
        elif field.default is MISSING and field.default_factory is MISSING:
            raise KeyError(f"{name} is missing")
    return kind(**arguments)
