"""What a job leaves of its network: ``network.json``, and ``cameras.toml`` with the accepted cameras."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from ..errors import EpibarError
from ..files.json_file import read_json_object, write_json
from ..lens.cameras_toml import written_by_epibar
from ..lens.intrinsics import Intrinsics
from ..network.result import Network
from ..network.saved import as_file
from .folder import Folder
from .inputs import CAMERAS_FILE, NETWORK_FILE

__all__ = ["kept_network", "write_network"]

KEY = "epibar_key"


def kept_network(out: Path, key: str | None, names: Sequence[str]) -> Network | None:
    """Return the network of an earlier run, if it was made of the same."""
    path = out / NETWORK_FILE
    if key is None or not path.exists():
        return None
    with suppress(EpibarError):
        if read_json_object(path, "a network").get(KEY) == key:
            network = Network.load(path)
            return network if list(network.cameras) == list(names) else None
    return None


def write_network(
    folder: Folder,
    network: Network | None,
    key: str | None = None,
    lenses: Mapping[str, Intrinsics] | None = None,
    given: str | None = None,
) -> tuple[list[Path], list[str]]:
    """Write both files, or remove those of an earlier network.

    Parameters
    ----------
    folder : Folder
        Of the run, held.
    network : Network or None
    key : str or None
        To know it again by.
    lenses : mapping of str to Intrinsics, optional
        That were taken out of the recordings.
    given : str, optional
        Camera file that the run was given, which is never replaced.

    Returns
    -------
    written : list of Path
    warnings : list of str

    Raises
    ------
    EpibarError
        A file cannot be written or removed.
    """
    path, cameras = folder.path / NETWORK_FILE, folder.path / CAMERAS_FILE
    accepted = network is not None and any(camera.accepted for camera in network.cameras.values())
    replaceable = not os.path.lexists(cameras) or _of_a_network(folder, cameras, given)
    if network is None or not accepted:
        if replaceable:
            folder.remove(cameras)
        if network is None:
            folder.remove(path)
            return [], []
    folder.will_write(path)
    write_json(path, {**as_file(network), **({} if key is None else {KEY: key})})
    if not accepted:
        return [path], []
    if not replaceable:
        warning = f"{cameras} is not of an earlier network: it stays as it is; the cameras are in {path}"
        return [path], [warning]
    folder.will_write(cameras)
    network.export(cameras, "anipose", lenses)
    return [path, cameras], []


def _of_a_network(folder: Folder, cameras: Path, given: str | None) -> bool:
    """Whether a run wrote the camera file, nobody has replaced it, and it is not what this run was given."""
    same = given is not None and os.path.realpath(cameras) == os.path.realpath(given)
    return folder.owns(cameras) and written_by_epibar(cameras) and not same
