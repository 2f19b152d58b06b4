"""Tracks of walkers, ``tracks.csv``, for the view in space: time, track, x, y, z and whatever else."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import EpibarError

__all__ = ["Track", "read_tracks"]

Track = NDArray[np.float64]
"""Places of one walker in the order of time, (n, 3), in the network's unit."""

NEEDED = ("time", "track", "x", "y", "z")

GAP = 1.0
"""Seconds without a place after which a track is drawn as another one."""

LONGEST = 1_000_000
"""Rows that are read."""

FARTHEST = 1e6
"""Units of length: a place farther off is none."""


def read_tracks(path: Path) -> list[Track]:
    """Read the tracks of a run; none where the file is not there.

    Lines that begin with # are notes. A row without a time or place is left out.

    Raises
    ------
    EpibarError
        The file is there and cannot be read, or has other columns.
    """
    if not path.is_file():
        return []
    rows: dict[str, list[tuple[float, float, float, float]]] = {}
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            table = csv.DictReader(line for line in stream if not line.startswith("#"))
            missing = [name for name in NEEDED if name not in (table.fieldnames or ())]
            if missing:
                raise EpibarError(f"{path}: no column {', '.join(missing)}: the walkers are not shown")
            for number, row in enumerate(table):
                if number >= LONGEST:
                    break
                place = _numbers(row)
                if place is not None:
                    rows.setdefault(str(row["track"]), []).append(place)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise EpibarError(f"{path}: cannot be read ({error}): the walkers are not shown") from error
    return [part for track in rows.values() for part in _parts(np.array(sorted(track)))]


def _numbers(row: dict[str, str | None]) -> tuple[float, float, float, float] | None:
    """Time and place of a row; None where one is no number, or out of all bounds."""
    try:
        time, x, y, z = (float(row[name] or "nan") for name in ("time", "x", "y", "z"))
    except ValueError:
        return None
    known = np.isfinite(time) and bool((np.abs((x, y, z)) < FARTHEST).all())
    return (time, x, y, z) if known else None


def _parts(rows: NDArray[np.float64]) -> list[Track]:
    """Cut a track where nobody saw the walker for some time."""
    gaps = np.flatnonzero(np.diff(rows[:, 0]) > GAP) + 1
    return [part[:, 1:] for part in np.split(rows, gaps)]
