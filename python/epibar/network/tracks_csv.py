"""Tracks of walkers as they stand in ``tracks.csv``, read back."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np

from ..errors import EpibarError
from .parts import BASELINE, METRE
from .walkers import COLUMNS, SEEN_BY, WalkerTracks

__all__ = ["load_tracks"]


def load_tracks(path: str | os.PathLike[str]) -> WalkerTracks:
    """Read the table that :meth:`WalkerTracks.save` wrote.

    Raises
    ------
    EpibarError
        The file is missing, or something else.
    """
    try:
        if Path(path).exists() and not Path(path).is_file():  # a pipe would be waited for
            raise ValueError("not a file")
        with Path(path).open(encoding="utf-8", newline="") as stream:
            header, *rows = csv.reader(stream)
        return _tracks(header, rows)
    except (OSError, ValueError, csv.Error) as error:
        raise EpibarError(f"{os.fspath(path)}: no table of tracks, or damaged ({error})") from error


def _tracks(header: list[str], rows: list[list[str]]) -> WalkerTracks:
    fixed = len(COLUMNS)
    seen_by = header[fixed:]
    if tuple(header[:fixed]) != COLUMNS or not all(name.startswith(SEEN_BY) for name in seen_by):
        raise ValueError("the first line is another")
    if any(len(row) != len(header) for row in rows):
        raise ValueError("a line is longer or shorter than the first")
    unit_at = COLUMNS.index("unit")
    units = {row[unit_at] for row in rows} or {BASELINE}
    if len(units) > 1 or not units <= {BASELINE, METRE}:
        raise ValueError("a unit is unknown")
    numbers = np.array([[float(cell) for cell in row[:unit_at]] for row in rows]).reshape(-1, unit_at)
    # Not as an array of texts, in which every cell is as large as the longest.
    if not all(cell in ("0", "1") for row in rows for cell in row[fixed:]):
        raise ValueError("whether a camera sees somebody is neither 0 nor 1")
    cameras = np.array([[cell == "1" for cell in row[fixed:]] for row in rows], bool).reshape(
        -1, len(seen_by)
    )
    tracks = numbers[:, 1]
    if not np.isfinite(numbers).all() or not ((tracks >= 0) & (tracks < 2**32) & (tracks % 1 == 0)).all():
        raise ValueError("a number is not finite, or a track is no whole number")
    return WalkerTracks(
        names=tuple(name.removeprefix(SEEN_BY) for name in seen_by),
        unit=units.pop(),
        time=numbers[:, 0],
        track=tracks.astype(np.int64),
        foot=numbers[:, 2:5],
        top=numbers[:, 5:8],
        cameras=cameras,
        residual=numbers[:, COLUMNS.index("residual")],
    )
