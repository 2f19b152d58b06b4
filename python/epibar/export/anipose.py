"""Runs as camera files of aniposelib and Caliscope, with the poses that F and the intrinsics give."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arguments import Array
from ..errors import EpibarError
from ..geometry.pose import RelativePose
from ..lens.camera_file import load_cameras, write_cameras
from ..lens.intrinsics import Intrinsics
from ..runs.run import Pair, Run
from ..sources.opencv import opencv
from .placing import place_cameras

__all__ = ["write_toml"]


def write_toml(
    run: Run,
    path: str | os.PathLike[str],
    intrinsics: str | os.PathLike[str] | None = None,
    caliscope: bool = False,
) -> list[Path]:
    """Write the cameras with their lenses, rotations and translations: ``X_c = R X + t``.

    The first camera is the world, and the distance between the first two with a pair is the unit of length,
    for the true one cannot be seen. Where the pairs cannot be put into one world, each goes to a file of
    its own, called after ``path`` and the two cameras, with its own unit of length; the table ``metadata``
    of each says why.

    Parameters
    ----------
    run : Run
    path : str or path
    intrinsics : str or path, optional
        Camera file to take the lenses from; by default that of the run.
    caliscope : bool
        Tables as Caliscope reads them rather than aniposelib. Caliscope numbers its cameras: a number is the
        place in the run, and a camera that has no place in the world is there without one.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    EpibarError
        No camera file, or one that does not fit; no pair has a pose; a file cannot be written.
    """
    where = intrinsics or run.intrinsics
    if where is None:
        raise EpibarError(
            "a camera file holds intrinsics, and this run has none: give --intrinsics FILE.toml"
        )
    if intrinsics is None and not Path(where).is_file():
        raise EpibarError(
            f"{where}: the camera file of this run is not there any more: give --intrinsics FILE.toml"
        )
    known = load_cameras(where)
    run = run.with_intrinsics(known, os.fspath(where))
    poses, reasons = run.poses()
    if not poses:
        raise EpibarError(f"no pair has a pose ({'; '.join(reasons)})")
    lenses = {
        camera.name: replace(lens, name=camera.name)
        for camera, lens in zip(run.cameras, run.found_in(known, os.fspath(where)), strict=True)
    }
    with_pose = [pair for pair in run.pairs if (pair.a, pair.b) in poses]
    target = Path(path)
    try:
        placed = place_cameras(run, poses)
    except EpibarError as error:
        return _write_pairs(target, with_pose, poses, lenses, caliscope, str(error))
    notes = [*map(_verdict, with_pose), *reasons]
    unit = f"the distance between {' and '.join(next(iter(poses)))}"
    _write(target, placed, lenses, caliscope, unit, notes)
    return [target]


def _write_pairs(
    target: Path,
    pairs: Sequence[Pair],
    poses: Mapping[tuple[str, str], RelativePose],
    lenses: Mapping[str, Intrinsics],
    caliscope: bool,
    why: str,
) -> list[Path]:
    """Write a file per pair."""
    written = []
    for pair in pairs:
        pose = poses[pair.a, pair.b]
        written.append(target.with_name(f"{target.stem}_{pair.a}_{pair.b}{target.suffix}"))
        placed = {pair.a: (np.eye(3), np.zeros(3)), pair.b: (pose.R, pose.t)}
        notes = [_verdict(pair), f"one file per pair: {why}"]
        _write(written[-1], placed, lenses, caliscope, "the distance between the two cameras", notes)
    return written


def _verdict(pair: Pair) -> str:
    return f"{pair.name}: {pair.kind}"


def _write(
    path: Path,
    placed: Mapping[str, tuple[Array, Array]],
    lenses: Mapping[str, Intrinsics],
    caliscope: bool,
    unit: str,
    notes: list[str],
) -> None:
    cv2 = opencv()
    cameras = []
    for name, lens in lenses.items():
        if name in placed:
            R, t = placed[name]
            rotation = np.asarray(cv2.Rodrigues(R)[0], np.float64).ravel()
            cameras.append(replace(lens, rotation=rotation, translation=t))
        elif caliscope:
            cameras.append(replace(lens, rotation=None, translation=None))
    write_cameras(path, cameras, {"unit": unit, "notes": notes}, caliscope)
