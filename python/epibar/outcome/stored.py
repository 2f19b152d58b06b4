"""Entries of a calibration.json that may come from anyone, each value checked as it is taken."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ..arguments import Array, is_number
from ..errors import EpibarError
from ..files.calibration_json import is_plain_name
from ..files.checks import is_text, is_truth, is_whole_number

__all__ = ["Stored", "entries"]

LARGEST = 1e300
SHOWN = 60
"""Characters of a wrong value that an error shows."""


def _is_finite(value: Any) -> bool:
    return is_number(value) and abs(value) < LARGEST


@dataclass(frozen=True)
class Stored:
    """One table of the file.

    Attributes
    ----------
    path : Path
        The file.
    place : str
        Where the table is in it, e.g. ``pairs[3]``.
    values : mapping of str to any
    """

    path: Path
    place: str
    values: Mapping[str, Any]

    def text(self, name: str) -> str:
        """Return a text that is there."""
        value = self.values.get(name)
        if not is_text(value):
            self._wrong(name, "a text")
        return value

    def truth(self, name: str) -> bool:
        """Return true or false."""
        value = self.values.get(name)
        if not is_truth(value):
            self._wrong(name, "true or false")
        return value

    def whole(self, name: str, least: int, most: int) -> int:
        """Return a whole number within bounds."""
        value = self.values.get(name)
        if not is_whole_number(value, least, most):
            self._wrong(name, f"a whole number from {least} to {most}")
        return value

    def number(self, name: str, least: float = -math.inf, otherwise: float | None = None) -> float:
        """Return a finite number above ``least``; ``otherwise`` where there is none at all."""
        if name not in self.values and otherwise is not None:
            return otherwise
        value = self.values.get(name)
        if not _is_finite(value) or not value > least:  # type: ignore[operator]
            self._wrong(name, "a finite number" + (f" above {least:g}" if math.isfinite(least) else ""))
        return float(value)  # type: ignore[arg-type]

    def maybe_number(self, name: str) -> float | None:
        """Return a finite number that is there, or null."""
        return None if name in self.values and self.values[name] is None else self.number(name)

    def matrix(self, name: str) -> Array | None:
        """Return 3 x 3 finite numbers that are there, or null."""
        value = self.values.get(name)
        if name in self.values and value is None:
            return None
        rows = value if isinstance(value, list) and all(isinstance(row, list) for row in value) else []
        if [len(row) for row in rows] != [3, 3, 3] or not all(_is_finite(x) for row in rows for x in row):
            self._wrong(name, "3 x 3 finite numbers")
        return np.array(rows, dtype=np.float64)

    def table(self, name: str) -> Stored:
        """Return a table; an empty one where there is none at all."""
        value = self.values.get(name, {})
        if not isinstance(value, dict):
            self._wrong(name, "a table")
        return Stored(self.path, f"{self.place}.{name}", value)

    def file(self, name: str) -> Path | None:
        """Return a file of the folder itself, if one is named."""
        value = self.values.get(name)
        if value is None:
            return None
        if not is_text(value) or not is_plain_name(value):
            self._wrong(name, "the name of a file in the same folder")
        found = self.path.parent / value
        if found.resolve().parent != self.path.parent.resolve():
            self._wrong(name, "a file in the same folder, which this leads out of")
        return found

    def _wrong(self, name: str, expected: str) -> NoReturn:
        found = repr(self.values[name]) if name in self.values else "missing"
        found = found if len(found) <= SHOWN else found[:SHOWN] + "..."
        raise EpibarError(
            f"{self.path}: damaged: {self.place}.{name} is {found}, expected {expected}; "
            "run 'epibar calibrate' again"
        )


def entries(path: Path, result: Mapping[str, Any], name: str) -> Iterator[Stored]:
    """Yield the tables of a list."""
    found = result.get(name)
    if not isinstance(found, list):
        raise EpibarError(f"{path}: damaged: {name} is no list; run 'epibar calibrate' again")
    for index, values in enumerate(found):
        if not isinstance(values, dict):
            raise EpibarError(f"{path}: damaged: {name}[{index}] is no table; run 'epibar calibrate' again")
        yield Stored(path, f"{name}[{index}]", values)
