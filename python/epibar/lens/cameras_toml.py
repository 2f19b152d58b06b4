"""The ``cameras.toml`` that known cameras are read from and written to.

The file is the one aniposelib writes, one table per camera: ``name``, ``size``, ``matrix``, ``distortions``,
``rotation`` (Rodrigues), ``translation``; X_c = R X + t. What Caliscope adds is understood or ignored: tables
under ``[cameras]``, ``port`` or ``cam_id`` for a name, rotations as matrices, ``fisheye``.
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Array, as_numbers, as_rotation
from ..errors import UNPRINTABLE, EpibarError
from ..files.atomic import write_text
from .intrinsics import Intrinsics

__all__ = [
    "find_camera",
    "find_cameras",
    "intrinsics_of",
    "load_cameras",
    "not_used",
    "write_cameras",
    "written_by_epibar",
]

ROUNDED = 3e-2
"""By how much RᵀR of a rotation that was written with few digits may differ from the identity."""


def load_cameras(path: str | os.PathLike[str]) -> list[Intrinsics]:
    """Read the cameras of an aniposelib or Caliscope ``.toml`` file, in its order.

    Raises
    ------
    EpibarError
        The file is missing, is not TOML, or has no camera; a camera lacks something or has a wrong value.
    """
    path = os.fspath(path)
    try:
        if os.path.exists(path) and not os.path.isfile(path):  # a pipe would be waited for
            raise EpibarError(f"{path}: not a file")
        document = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise EpibarError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise EpibarError(f"{path}: cannot be read ({error})") from error
    except RecursionError as error:
        raise EpibarError(f"{path}: not a TOML file of cameras (too deep)") from error
    except tomllib.TOMLDecodeError as error:
        raise EpibarError(f"{path}: not a TOML file ({error})") from error
    cameras = [_camera(path, section, table) for section, table in _tables(document)]
    if not cameras:
        raise EpibarError(
            f"{path}: no cameras; expected tables like [cam_0] with size, matrix and distortions"
        )
    names = [camera.name for camera in cameras]
    for name in names:
        if names.count(name) > 1:
            raise EpibarError(f"{path}: two cameras are called {name!r}")
    return cameras


def written_by_epibar(path: str | os.PathLike[str]) -> bool:
    """Whether the metadata of a camera file say so; not of one that cannot be read."""
    try:
        file = Path(path)
        metadata = tomllib.loads(file.read_text(encoding="utf-8")).get("metadata") if file.is_file() else None
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(metadata, dict) and metadata.get("software") == "epibar"


def _tables(document: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Tables that describe a camera, also those one level down in ``[cameras.x]`` or ``[[cameras]]``."""
    found: list[tuple[str, dict[str, Any]]] = []
    for section, table in document.items():
        if section == "cameras" and isinstance(table, (dict, list)):
            inner = table.items() if isinstance(table, dict) else enumerate(table)
            found += [(str(key), value) for key, value in inner if isinstance(value, dict)]
        elif isinstance(table, dict) and ("matrix" in table or "distortions" in table):
            found.append((section, table))
    return found


def _camera(path: str, section: str, table: dict[str, Any]) -> Intrinsics:
    given = next((table[key] for key in ("name", "cam_id", "port") if key in table), section)
    for key in ("size", "matrix", "distortions"):
        if table.get(key) is None:
            raise EpibarError(f"{path}: [{section}] has no {key}; calibrate that camera, or remove the table")
    name = str(given)
    try:
        rotation, translation = _optional(table, "rotation"), _optional(table, "translation")
        if rotation is not None and np.shape(rotation) == (3, 3):
            import cv2

            rotation = cv2.Rodrigues(as_rotation(f"{name}: rotation", rotation, ROUNDED))[0]
        return Intrinsics(
            name,
            table["size"],
            table["matrix"],
            table["distortions"],
            bool(table.get("fisheye", False)),
            None if rotation is None else as_numbers(f"{name}: rotation", rotation, None).ravel(),
            None if translation is None else as_numbers(f"{name}: translation", translation, None).ravel(),
        )
    except EpibarError as error:
        raise EpibarError(f"{path}: [{section}] {error}") from error


def _optional(table: dict[str, Any], key: str) -> Any:
    """Return a value, or None for the empty lists and strings of a camera that was not placed yet."""
    value = table.get(key)
    return None if value in (None, [], "", "null") else value


def find_camera(
    cameras: Sequence[Intrinsics], stem: str, index: int | None, others: Sequence[str] = ()
) -> Intrinsics:
    """Find the camera of a video: the one called like the file without suffix, or else the one at its place.

    A video alone has no place, and ``index`` is None. ``others`` are the names of the other videos: where the
    one at a place is called like one of these, that place says nothing.

    Raises
    ------
    EpibarError
        Neither exists.
    """
    for same in (str, str.casefold):
        for camera in cameras:
            if same(camera.name) == same(stem):
                return camera
    known = ", ".join(camera.name for camera in cameras)
    if index is not None and 0 <= index < len(cameras):
        found = cameras[index]
        if found.name.casefold() in (other.casefold() for other in others if other != stem):
            raise EpibarError(
                f"{stem}: no camera of that name in the camera file, and the one at its place, {found.name}, "
                f"is that of another video; it has {known}"
            )
        return found
    nor = "" if index is None else f", nor one at place {index}"
    raise EpibarError(f"{stem}: no camera of that name in the camera file{nor}; it has {known}")


def find_cameras(
    cameras: Sequence[Intrinsics], names: Sequence[str], places: Sequence[int] | None = None
) -> dict[str, Intrinsics]:
    """Find the cameras of several videos, by their names, as far as the file has them.

    Places, by default those in the list, say something only where the file has a camera for every one of
    them: of a file of some of the cameras it is not known which it lacks.

    Raises
    ------
    EpibarError
        There is none of any of the videos.
    """
    places = range(len(names)) if places is None else places
    by_place = len(cameras) > max(places, default=0)
    found = {}
    why: EpibarError | None = None
    for name, place in zip(names, places, strict=True):
        try:
            found[name] = find_camera(cameras, name, place if by_place else None, names)
        except EpibarError as error:
            why = why or error
    if why is not None and not found:
        raise why
    return found


def not_used(cameras: Sequence[Intrinsics], used: Iterable[Intrinsics]) -> list[str]:
    """Names of the cameras of a file that no video has."""
    names = {camera.name for camera in used}
    return [camera.name for camera in cameras if camera.name not in names]


def write_cameras(
    path: str | os.PathLike[str],
    cameras: Iterable[Intrinsics],
    metadata: Mapping[str, str | list[str]] | None = None,
    caliscope: bool = False,
    more: Sequence[Mapping[str, Array]] | None = None,
) -> None:
    """Write cameras the way :func:`load_cameras` reads them, and aniposelib or Caliscope.

    Parameters
    ----------
    path : str or path
    cameras : iterable of Intrinsics
    metadata : mapping of str to str or list of str, optional
        For the table ``metadata``, which readers keep or skip.
    caliscope : bool
        Tables as Caliscope reads them, ``[cameras.0]``, rather than as aniposelib does, ``[cam_0]``.
    more : sequence of mapping of str to array, optional
        Of each camera, what else its table holds.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """
    tables = []
    cameras = list(cameras)
    # aniposelib sorts its tables by their names: numbers are as long as the last one.
    digits = len(str(len(cameras) - 1))
    for index, camera in enumerate(cameras):
        number = f"{index:0{digits}d}"
        rows = [f"[cameras.{index}]", f"cam_id = {index}"] if caliscope else [f"[cam_{number}]"]
        rows += [f"name = {_toml(camera.name)}"]
        rows += [f"size = {list(camera.size)}", f"matrix = {camera.matrix.tolist()}"]
        rows += [f"distortions = {camera.distortions.tolist()}"]
        rows += ["fisheye = true"] if camera.fisheye else []
        for key in ("rotation", "translation"):
            value = getattr(camera, key)
            rows += [] if value is None else [f"{key} = {value.tolist()}"]
        rows += [f"{key} = {value.tolist()}" for key, value in (more[index] if more else {}).items()]
        tables.append("\n".join(rows) + "\n")
    if metadata:
        rows = [f"{key} = {_toml(value)}" for key, value in metadata.items()]
        tables.append("\n".join(["[metadata]", *rows]) + "\n")
    text = "\n".join(tables)
    write_text(path, text)


def _toml(value: str | list[str]) -> str:
    """Set texts as TOML: as JSON, and what a terminal would obey spelt out, which TOML partly asks for."""
    text = json.dumps(value, ensure_ascii=False)
    return UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def intrinsics_of(path: str | os.PathLike[str], name: str) -> Intrinsics:
    """Look one camera up by its name: alone it has no place in an order, unless the file has only one."""
    cameras = load_cameras(path)
    return find_camera(cameras, name, 0 if len(cameras) == 1 else None)
