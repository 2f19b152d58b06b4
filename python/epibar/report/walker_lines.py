"""Tracks of walkers of a run, ``tracks.csv``, as lines for the view in space."""

from __future__ import annotations

from pathlib import Path

from ..arguments import Array
from ..errors import EpibarError
from ..network.tracks_csv import load_tracks

__all__ = ["Track", "read_tracks"]

Track = Array
"""Places of one walker in the order of time, (n, 3), in the network's unit."""


def read_tracks(path: Path) -> list[Track]:
    """Read the tracks of a run; none where the file is not there.

    Raises
    ------
    EpibarError
        The file is there and is no table of tracks.
    """
    if not path.is_file():
        return []
    try:
        return [way.foot for way in load_tracks(path).ways()]
    except EpibarError as error:
        raise EpibarError(f"{error}: the walkers are not shown") from error
