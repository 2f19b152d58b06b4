"""What a job leaves of its network: ``network.json``, and ``cameras.toml`` with the accepted cameras."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from ..errors import EpibarError
from ..files.json_file import read_json_object, write_json
from ..lens.intrinsics import Intrinsics
from ..network.result import Network

__all__ = ["CAMERAS", "NETWORK", "kept_network", "replaceable", "write_network"]

NETWORK = "network.json"
CAMERAS = "cameras.toml"
KEY = "epibar_key"


def kept_network(out: Path, key: str | None) -> Network | None:
    """Return the network of an earlier run, if it was made of the same."""
    path = out / NETWORK
    if key is None or not path.exists():
        return None
    with suppress(EpibarError):
        if read_json_object(path, "a network").get(KEY) == key:
            return Network.load(path)
    return None


def write_network(
    out: Path,
    network: Network | None,
    key: str | None = None,
    lenses: Mapping[str, Intrinsics] | None = None,
    given: str | None = None,
) -> list[str]:
    """Write both files, or remove those of an earlier network.

    Parameters
    ----------
    out : Path
        Folder of the run.
    network : Network or None
    key : str or None
        To know it again by.
    lenses : mapping of str to Intrinsics, optional
        That were taken out of the recordings.
    given : str, optional
        Camera file that the run was given, which is never replaced.

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    EpibarError
        A file cannot be written or removed.
    """
    path, cameras = out / NETWORK, out / CAMERAS
    if network is None:
        _remove(path)
    else:
        write_json(path, {**network.as_dict(), **({} if key is None else {KEY: key})})
    there = network is not None and any(camera.accepted for camera in network.cameras.values())
    if cameras.exists() and not replaceable(out, given):
        if not there:
            return []
        return [f"{cameras} is not of an earlier network: it stays as it is; the cameras are in {path}"]
    if network is not None and there:
        network.export(cameras, "anipose", lenses)
    else:
        _remove(cameras)
    return []


def replaceable(out: Path, given: str | None) -> bool:
    """Whether the ``cameras.toml`` of a run is of an earlier network, and not what the run was given."""
    path = out / CAMERAS
    return _ours(path) and not _same(path, given)


def _ours(path: Path) -> bool:
    """Whether a camera file was written by this program, and not by its user."""
    try:
        metadata = tomllib.loads(path.read_text(encoding="utf-8")).get("metadata", {})
    except (OSError, ValueError):
        return False
    return isinstance(metadata, dict) and metadata.get("software") == "epibar"


def _same(path: Path, given: str | None) -> bool:
    return given is not None and path.resolve() == Path(given).resolve()


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise EpibarError(f"{path}: cannot be removed ({error.strerror or error})") from error
