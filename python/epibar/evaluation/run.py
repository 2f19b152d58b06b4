"""A whole run against cameras whose pose is known: :func:`evaluate`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..arguments import Array, PathLike
from ..errors import EpibarError
from ..files.json_values import plain
from ..geometry.cameras import (
    Pose,
    fundamental_from_cameras,
    project,
    projection_matrix,
    triangulate,
    volume_correspondences,
)
from ..geometry.epipolar import symmetric_epipolar_distance
from ..lens.cameras_toml import load_cameras
from ..lens.intrinsics import Intrinsics
from ..outcome.run import Pair, Run, RunCamera
from .points import compare, image_correspondences, moving_volume

__all__ = ["Evaluation", "PairEvaluation", "evaluate"]

RADIUS = 6.0
"""Pixels: a frontier point that is farther from the true epipolar lines is a wrong match."""

LEAST_POINTS = 20


@dataclass(frozen=True)
class PairEvaluation:
    """How good the F of one pair is.

    Attributes
    ----------
    a, b : str
        Names of its cameras.
    accepted : bool
    kind : str
        The verdict as one word.
    expected_error : float or None
        What the verdict states, pixels.
    volume_error, image_error : float or None
        Mean symmetric epipolar distance under F of true correspondences, pixels: over the volume where things
        moved, and over the whole image. None where there is no F, or nothing to measure it on.
    """

    a: str
    b: str
    accepted: bool
    kind: str
    expected_error: float | None
    volume_error: float | None
    image_error: float | None

    @property
    def name(self) -> str:
        """Both names, for messages."""
        return f"{self.a} - {self.b}"


@dataclass(frozen=True)
class Evaluation:
    """How good the pairs of a run are.

    Attributes
    ----------
    pairs : list of PairEvaluation
        In the order of the run.
    volume_known : bool
        Enough frontier points agree with the known cameras to tell where things moved.
    warnings : list of str
        What the errors include, and which pairs have none, in plain English.
    """

    pairs: list[PairEvaluation]
    volume_known: bool
    warnings: list[str]

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, lists and strings; what is not finite becomes None."""
        content: dict[str, Any] = plain(asdict(self))
        return content


def evaluate(calibration: Run | PathLike, cameras: Sequence[Intrinsics] | PathLike) -> Evaluation:
    """Measure the F of every pair of a run against cameras whose pose is known.

    Parameters
    ----------
    calibration : Run or path
        What ``epibar calibrate`` wrote: its folder, or the calibration.json in it.
    cameras : sequence of Intrinsics or path
        The known cameras with rotation and translation, or the file they are in; found by name, or else by
        place.

    Returns
    -------
    Evaluation

    Raises
    ------
    EpibarError
        A file cannot be read or does not fit the other; a camera has no pose.

    Examples
    --------
    >>> import epibar
    >>> found = epibar.evaluate("calibrated", "cameras.toml")
    >>> errors = {pair.name: pair.volume_error for pair in found.pairs}
    """
    run, of_what = (calibration, "the run") if isinstance(calibration, Run) else _loaded(calibration)
    known, where = (
        (load_cameras(cameras), cameras) if isinstance(cameras, (str, os.PathLike)) else (cameras, "cameras")
    )
    found = zip(run.cameras, run.found_in(known, os.fspath(where)), strict=True)
    poses = {camera.name: given.posed() for camera, given in found}
    warnings = []
    if not run.intrinsics and any(camera.distorted for camera in known):
        warnings.append(
            f"{of_what} was made without --intrinsics, but the cameras have lens distortion; "
            "the errors below include it"
        )
    truths = {pair.name: _truth(pair, poses, warnings) for pair in run.pairs}
    points = np.concatenate(
        [np.empty((0, 3)), *(_world_points(pair, poses, truths[pair.name]) for pair in run.pairs)]
    )
    volume = moving_volume(points) if len(points) >= LEAST_POINTS else None
    pairs = [_evaluated(pair, run.by_name, poses, truths[pair.name], volume) for pair in run.pairs]
    return Evaluation(pairs, volume is not None, warnings)


def _loaded(path: PathLike) -> tuple[Run, str]:
    return Run.load(path), os.fspath(path)


def _truth(pair: Pair, poses: dict[str, Pose], warnings: list[str]) -> Array | None:
    """Fundamental matrix of the known cameras of a pair, where they have one that shows."""
    a, b = poses[pair.a], poses[pair.b]
    try:
        truth = fundamental_from_cameras(a, b)
        image_correspondences(truth, a.size, b.size)
    except EpibarError as error:
        warnings.append(f"{pair.name}: no errors are given, {error}")
        return None
    return truth


def _world_points(pair: Pair, poses: dict[str, Pose], truth: Array | None) -> Array:
    """Triangulate the frontier points of a pair with the known cameras: where things moved, (n, 3)."""
    if truth is None:
        return np.empty((0, 3))
    a, b = pair.frontier_points.a, pair.frontier_points.b
    pose_a, pose_b = poses[pair.a], poses[pair.b]
    right = symmetric_epipolar_distance(truth, a, b) < RADIUS
    a, b = a[right], b[right]
    if not len(a):
        return np.empty((0, 3))
    points = triangulate(projection_matrix(pose_a), projection_matrix(pose_b), a, b)
    points = points[np.isfinite(points).all(axis=1)]
    in_front = (project(pose_a, points)[1] > 0) & (project(pose_b, points)[1] > 0)
    return points[in_front]


def _evaluated(
    pair: Pair,
    recorded: dict[str, RunCamera],
    poses: dict[str, Pose],
    truth: Array | None,
    volume: Array | None,
) -> PairEvaluation:
    verdict = pair.a, pair.b, pair.accepted, pair.kind, pair.expected_error
    if pair.F is None or truth is None:
        return PairEvaluation(*verdict, None, None)
    seen = None if volume is None else volume_correspondences(poses[pair.a], poses[pair.b], volume)
    figures = compare(pair.F, truth, recorded[pair.a].size, recorded[pair.b].size, seen)
    volume_error = figures.volume_error if figures.volume_points else None
    return PairEvaluation(*verdict, volume_error, figures.image_error)
