"""What a job leaves of its network for spreadsheets: ``tracks.csv`` of walkers, ``sync.csv`` of clocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from ..errors import EpibarError
from ..network.result import Network
from ..network.walker_file import load_tracks
from ..recording import Recording
from ..runs.sync import camera_starts, write_starts
from .folder import Folder
from .inputs import SYNC_FILE, TRACKS_FILE

__all__ = ["forget_tables", "rescale_tracks", "write_tables"]

T = TypeVar("T")


def forget_tables(folder: Folder) -> None:
    """Remove the tables of an earlier network.

    Raises
    ------
    EpibarError
        One cannot be removed.
    """
    folder.remove(folder.path / TRACKS_FILE, folder.path / SYNC_FILE)


def write_tables(
    folder: Folder, network: Network, recordings: Mapping[str, Recording], sources: Mapping[str, str]
) -> list[Path]:
    """Write those that are not there; a table of what this network does not have is left out.

    Parameters
    ----------
    folder : Folder
        Of the run, held; without tables of another network.
    network : Network
    recordings : mapping of str to Recording
        Of its cameras.
    sources : mapping of str to str
        The videos, without passwords.

    Returns
    -------
    list of Path
        The tables that are there.

    Raises
    ------
    EpibarError
        One cannot be written.
    """
    tracks, sync = folder.path / TRACKS_FILE, folder.path / SYNC_FILE
    if not tracks.exists():
        found = _or_none(lambda: network.tracks(recordings))
        if found is not None:
            folder.will_write(tracks)
            found.save(tracks)
    if not sync.exists():
        times = _or_none(lambda: network.start_times(recordings))
        if times is not None:
            folder.will_write(sync)
            write_starts(sync, camera_starts(times, sources))
    return [path for path in (tracks, sync) if path.exists()]


def _or_none(make: Callable[[], T]) -> T | None:
    """Make what a network may not have: without a floor, or two accepted cameras, nobody can be followed."""
    try:
        return make()
    except EpibarError:
        return None


def rescale_tracks(folder: Folder, before: Network, after: Network) -> None:
    """Bring the tracks of a run to the unit of the same network after it was scaled.

    Raises
    ------
    EpibarError
        The table is damaged, or cannot be written.
    """
    path = folder.path / TRACKS_FILE
    if not (path.exists() and folder.owns(path)) or not (before.ground.height and after.ground.height):
        return
    load_tracks(path).scaled(after.ground.height / before.ground.height, after.unit).save(path)
