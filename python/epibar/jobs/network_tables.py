"""What a job leaves of its network for spreadsheets: ``tracks.csv`` of walkers, ``sync.csv`` of clocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from ..errors import EpibarError
from ..network.result import Network
from ..network.tracks_csv import load_tracks
from ..network.walkers import WalkerTracks, height_on_floor
from ..outcome.sync import camera_starts, write_starts
from ..recording import Recording
from .folder import Folder
from .inputs import SYNC_FILE, TRACKS_FILE

__all__ = ["forget_tables", "rescaled_tracks", "tracks_of", "write_tables"]

T = TypeVar("T")


def forget_tables(folder: Folder) -> None:
    """Remove the tables of an earlier network.

    Raises
    ------
    EpibarError
        One cannot be removed.
    """
    try:
        folder.remove(folder.path / TRACKS_FILE)
    finally:
        folder.remove(folder.path / SYNC_FILE)


def write_tables(
    folder: Folder, network: Network, recordings: Mapping[str, Recording], sources: Mapping[str, str]
) -> tuple[list[Path], list[str]]:
    """Write those that are not there; there are no tracks without a floor, and neither table of one camera.

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
    there : list of Path
        The tables that are there.
    warnings : list of str
        Why one could not be made.

    Raises
    ------
    EpibarError
        One cannot be written.
    """
    tracks, sync = folder.path / TRACKS_FILE, folder.path / SYNC_FILE
    several = sum(camera.accepted for camera in network.cameras.values()) > 1
    warnings: list[str] = []
    if several and height_on_floor(network) is not None and not tracks.exists():
        found = _made(tracks, lambda: network.tracks(recordings), warnings)
        if found is not None:
            folder.will_write(tracks)
            found.save(tracks)
    if several and not sync.exists():
        times = _made(sync, lambda: network.start_times(recordings), warnings)
        if times is not None:
            folder.will_write(sync)
            write_starts(sync, camera_starts(times, sources))
    return [path for path in (tracks, sync) if path.exists()], warnings


def _made(path: Path, make: Callable[[], T], warnings: list[str]) -> T | None:
    """Make what goes into a table; where it cannot be made, say why: the network itself is none the worse."""
    try:
        return make()
    except EpibarError as error:
        warnings.append(f"{path}: not written: {error}")
        return None


def tracks_of(folder: Folder, network: Network) -> WalkerTracks | None:
    """Read the tracks of a run that are to be scaled with its network; None where there are none.

    Raises
    ------
    EpibarError
        The table is damaged, or in another unit than the network.
    """
    path = folder.path / TRACKS_FILE
    if not (path.exists() and folder.owns(path)) or not network.ground.height:
        return None
    tracks = load_tracks(path)
    if len(tracks) and tracks.unit != network.unit:
        raise EpibarError(
            f"{path}: in the unit {tracks.unit!r}, and the network is in {network.unit!r}, as when scaling "
            "was interrupted; 'epibar calibrate' with the same videos writes both anew"
        )
    return tracks


def rescaled_tracks(tracks: WalkerTracks, before: Network, after: Network) -> WalkerTracks:
    """Return tracks of a run in the unit of the same network after it was scaled."""
    if not before.ground.height or not after.ground.height:
        return tracks
    return tracks.scaled(after.ground.height / before.ground.height, after.unit)
