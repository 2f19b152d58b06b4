"""Runs without a network as camera files, with the poses that F and the intrinsics give."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arguments import Array, PathLike, check_choice
from ..camera_export.formats import CAMERA_FORMATS
from ..camera_export.world import World
from ..errors import EpibarError
from ..geometry.pose import RelativePose
from ..lens.cameras_toml import load_cameras
from ..lens.intrinsics import Intrinsics, rotation_vector
from ..outcome.run import Pair, Run
from .placing import place_cameras

__all__ = ["write_placed", "write_placed_caliscope", "write_placed_toml"]

NUMBERED = "caliscope"
"""A camera that has no place in the world is there without one, so that the others keep their numbers."""

SEPARATORS = r"[\\/\0]"
"""What the name of a file cannot hold."""

Placed = Mapping[str, tuple[Array, Array]]


def write_placed_toml(
    run: Run, path: PathLike, intrinsics: PathLike | None = None, caliscope: bool = False
) -> list[Path]:
    """Write the cameras as :func:`write_placed` does, for aniposelib or Caliscope.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    EpibarError
        As for :func:`write_placed`.
    """
    return write_placed(run, path, "caliscope" if caliscope else "anipose", intrinsics)


def write_placed_caliscope(run: Run, path: PathLike, intrinsics: PathLike | None = None) -> list[Path]:
    """Write the cameras as :func:`write_placed` does, for Caliscope.

    Caliscope numbers its cameras: a number is the place in the run, and a camera that has no place in the
    world is there without one.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    EpibarError
        As for :func:`write_placed`.
    """
    return write_placed(run, path, "caliscope", intrinsics)


def write_placed(
    run: Run,
    path: PathLike,
    format: str = "anipose",  # noqa: A002
    intrinsics: PathLike | None = None,
) -> list[Path]:
    """Write the cameras with their lenses, rotations and translations: ``X_c = R X + t``.

    The first camera is the world, and the distance between the first two with a pair is the unit of length,
    for the true one cannot be seen. Where the pairs cannot be put into one world, each goes to a file of
    its own, called after ``path`` and the two cameras, with its own unit of length; the metadata of each say
    why.

    Parameters
    ----------
    run : Run
    path : str or path
    format : str
        One of those that hold cameras, :mod:`epibar.camera_export.formats`.
    intrinsics : str or path, optional
        Camera file to take the lenses from; by default that of the run.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    EpibarError
        No camera file, or one that does not fit; no pair has a pose; the format is unknown; a file cannot
        be written.
    """
    check_choice("format", format, CAMERA_FORMATS)
    run, lenses, pixels = _with_lenses(run, intrinsics)
    poses, reasons = run.poses()
    if not poses:
        raise EpibarError(f"no pair has a pose ({'; '.join(reasons)})")
    with_pose = [pair for pair in run.pairs if (pair.a, pair.b) in poses]
    target = Path(path)
    try:
        placed = place_cameras(run, poses)
    except EpibarError as error:
        return _write_pairs(target, with_pose, poses, lenses, format, str(error), pixels)
    notes = (*map(_verdict, with_pose), *reasons, *pixels)
    unit = f"the distance between {' and '.join(next(iter(poses)))}"
    return _write(target, placed, lenses, format, World(unit, notes=notes))


def _with_lenses(run: Run, intrinsics: PathLike | None) -> tuple[Run, dict[str, Intrinsics], tuple[str, ...]]:
    """Lenses of the cameras, and what to say of those of which only the matrix of the recording is known."""
    where = intrinsics or run.intrinsics
    matrices = {one.name: one.matrix for one in run.cameras if one.matrix is not None}
    lenses = {
        one.name: Intrinsics(one.name, one.size, matrices[one.name])
        for one in run.cameras
        if one.name in matrices
    }
    if where is None and not lenses:
        raise EpibarError(
            "a camera file holds intrinsics, and this run has none: give --intrinsics FILE.toml"
        )
    if where is None:
        return run, lenses, tuple(map(_pixels, lenses))
    if intrinsics is None and not Path(where).is_file():
        raise EpibarError(
            f"{where}: the camera file of this run is not there any more: give --intrinsics FILE.toml"
        )
    known = load_cameras(where)
    run = run.with_intrinsics(known, os.fspath(where))
    found = run.some_in(known, os.fspath(where))
    notes = tuple(_pixels(name) for name in lenses if name not in found)
    lenses |= {name: replace(lens, name=name) for name, lens in found.items()}
    return run, {one.name: lenses[one.name] for one in run.cameras if one.name in lenses}, notes


def _pixels(name: str) -> str:
    return f"{name}: in undistorted pixels, not in those of the video: no camera file has its lens"


def _write_pairs(
    target: Path,
    pairs: Sequence[Pair],
    poses: Mapping[tuple[str, str], RelativePose],
    lenses: Mapping[str, Intrinsics],
    chosen: str,
    why: str,
    pixels: tuple[str, ...],
) -> list[Path]:
    """Write a file per pair."""
    written = []
    for pair in pairs:
        pose = poses[pair.a, pair.b]
        names = re.sub(SEPARATORS, "_", f"{pair.a}_{pair.b}")
        path = target.with_name(f"{target.stem}_{names}{target.suffix}")
        while path in written:
            path = path.with_stem(f"{path.stem}_")
        placed = {pair.a: (np.eye(3), np.zeros(3)), pair.b: (pose.R, pose.t)}
        notes = (_verdict(pair), f"one file per pair: {why}", *pixels)
        world = World("the distance between the two cameras", notes=notes)
        written += _write(path, placed, lenses, chosen, world)
    return written


def _verdict(pair: Pair) -> str:
    return f"{pair.name}: {pair.kind}"


def _write(
    path: Path, placed: Placed, lenses: Mapping[str, Intrinsics], chosen: str, world: World
) -> list[Path]:
    cameras = []
    for name, lens in lenses.items():
        if name in placed:
            R, t = placed[name]
            cameras.append(replace(lens, rotation=rotation_vector(R), translation=t))
        elif chosen == NUMBERED:
            cameras.append(replace(lens, rotation=None, translation=None))
    return CAMERA_FORMATS[chosen].write(cameras, path, world)
