"""A network whose cameras moved, written over the one of a run: all files that hold it, or none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..errors import EpibarError
from ..files.atomic import write_atomically
from ..files.calibration_json import read_json
from ..files.json_file import write_json
from ..lens.intrinsics import Intrinsics
from ..network.result import Network
from ..network.walkers import WalkerTracks
from .folder import Folder
from .inputs import CAMERAS_FILE, NETWORK_FILE, RESULT, TRACKS_FILE
from .network_files import write_network

__all__ = ["MOVED_KIND", "write_update"]

MOVED_KIND = "moved"
"""Verdict of a pair of which nothing is known by itself since one of its cameras moved."""


def write_update(
    folder: Folder,
    network: Network,
    moved: Sequence[str],
    lenses: Mapping[str, Intrinsics] | None = None,
    given: str | None = None,
    tracks: WalkerTracks | None = None,
) -> list[str]:
    """Write network.json, cameras.toml, tracks.csv and calibration.json where they are; all or none.

    Parameters
    ----------
    folder : Folder
        Of the run, held.
    network : Network
        As it is now.
    moved : sequence of str
        Cameras that were solved for again.
    lenses : mapping of str to Intrinsics, optional
        That were taken out of the recordings.
    given : str, optional
        Camera file that the run was given, which is never replaced.
    tracks : WalkerTracks, optional
        Of the network as it is now, where they are to be written.

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    EpibarError
        A file cannot be read or written; those that had been written are as before.
    """
    result = folder.path / RESULT
    content = read_json(result) if result.exists() else None
    names = (NETWORK_FILE, CAMERAS_FILE, RESULT, *(() if tracks is None else (TRACKS_FILE,)))
    before = _kept(folder.path / name for name in names)
    try:
        warnings = write_network(folder, network, None, lenses, given)[1]
        if tracks is not None:
            tracks.save(folder.path / TRACKS_FILE)
        if content is not None:
            write_json(result, _updated(content, network, moved))
    except BaseException:
        for path, data in before.items():
            with suppress(EpibarError):
                _restore(path, data)
        raise
    return warnings


def _kept(paths: Any) -> dict[Path, bytes | None]:
    """What is in files, None of those that are not there."""
    try:
        return {path: path.read_bytes() if path.exists() else None for path in paths}
    except OSError as error:
        raise EpibarError(f"{error.filename}: cannot be read ({error.strerror or error})") from error


def _restore(path: Path, data: bytes | None) -> None:
    if data is None:
        path.unlink(missing_ok=True)
    elif path.read_bytes() != data:
        write_atomically(path, lambda stream: stream.write(data))


def _updated(content: Mapping[str, Any], network: Network, moved: Sequence[str]) -> dict[str, Any]:
    """Return a calibration.json with the network, and with what its pairs are since cameras moved."""
    straight = {
        one["name"] for one in content["cameras"] if isinstance(one, dict) and one.get("matrix") is not None
    }
    pairs = [
        _pair(pair, network, [name for name in moved if name in (pair.get("a"), pair.get("b"))], straight)
        if isinstance(pair, dict)
        else pair
        for pair in content["pairs"]
    ]
    return {**content, "pairs": pairs, "network": network.as_dict()}


def _pair(pair: dict[str, Any], network: Network, moved: Sequence[str], straight: set[str]) -> dict[str, Any]:
    """Return a pair as it is since its cameras moved: no test of the pair by itself holds any more.

    The network's F is in undistorted pixels, which are those of the pair only where lenses were taken out.
    """
    key = (str(pair.get("a")), str(pair.get("b")))
    if not moved or key not in network.pairs:
        return pair
    who = " and ".join(moved)
    same_pixels = set(key) <= straight
    whose = "F is the network's" if same_pixels else "the network has its F, in undistorted pixels"
    now = {
        "accepted": False,
        "kind": MOVED_KIND,
        "reason": f"{who} moved after the pair was calibrated, whose points are of before; {whose}",
        "F": network.pairs[key].F if same_pixels else None,
        "expected_error": None,
        "floor": None,
        "rivals": [],
        "pose": None,
    }
    return {**pair, **now}
