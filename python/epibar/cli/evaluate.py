"""``epibar evaluate``: errors of a calibration against cameras whose pose is known."""

from __future__ import annotations

import math
from argparse import Namespace
from pathlib import Path

import numpy as np

from ..arguments import Array
from ..errors import EpibarError
from ..evaluation import compare, image_correspondences, moving_volume, volume_correspondences
from ..geometry.cameras import Pose, fundamental_from_cameras, project, projection_matrix, triangulate
from ..geometry.epipolar import symmetric_epipolar_distance
from ..lens.camera_file import load_cameras
from ..runs.run import Camera, Pair, Run
from .console import Console

__all__ = ["run"]


RADIUS = 6.0
"""Pixels: a frontier point that is farther from the true epipolar lines is a wrong match."""

LEAST_POINTS = 20


def run(args: Namespace) -> int:
    """Run the command."""
    console = Console()
    path = Path(args.calibration)
    result = Run.load(path)
    known = load_cameras(args.cameras)
    found = zip(result.cameras, result.found_in(known, args.cameras), strict=True)
    cameras = {camera.name: given.posed() for camera, given in found}
    if not result.intrinsics and any(camera.distorted for camera in known):
        console.warning(
            f"{path} was made without --intrinsics, but the cameras have lens distortion; "
            "the errors below include it"
        )
    truths = {pair.name: _truth(pair, cameras, console) for pair in result.pairs}
    points = np.concatenate(
        [np.empty((0, 3)), *(_world_points(pair, cameras, truths[pair.name]) for pair in result.pairs)]
    )
    volume = moving_volume(points) if len(points) >= LEAST_POINTS else None

    rows: list[tuple[str, ...]] = [("pair", "verdict", "error over the volume", "over the image", "expected")]
    rows += [_row(pair, result.by_name, cameras, truths[pair.name], volume) for pair in result.pairs]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        console.result("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    if volume is None:
        console.note("too few frontier points agree with the known cameras to tell where things moved")
    return 0


def _truth(pair: Pair, cameras: dict[str, Pose], console: Console) -> Array | None:
    """Fundamental matrix of the known cameras of a pair, where they have one that shows."""
    a, b = cameras[pair.a], cameras[pair.b]
    try:
        truth = fundamental_from_cameras(a, b)
        image_correspondences(truth, a.size, b.size)
    except EpibarError as error:
        console.warning(f"{pair.name}: no errors are given, {error}")
        return None
    return truth


def _world_points(pair: Pair, cameras: dict[str, Pose], truth: Array | None) -> Array:
    """Triangulate the frontier points of a pair with the known cameras: where things moved, (n, 3)."""
    if truth is None:
        return np.empty((0, 3))
    a, b = pair.frontier_points.a, pair.frontier_points.b
    camera_a, camera_b = cameras[pair.a], cameras[pair.b]
    right = symmetric_epipolar_distance(truth, a, b) < RADIUS
    a, b = a[right], b[right]
    if not len(a):
        return np.empty((0, 3))
    points = triangulate(projection_matrix(camera_a), projection_matrix(camera_b), a, b)
    points = points[np.isfinite(points).all(axis=1)]
    in_front = (project(camera_a, points)[1] > 0) & (project(camera_b, points)[1] > 0)
    return points[in_front]


def _row(
    pair: Pair,
    recorded: dict[str, Camera],
    cameras: dict[str, Pose],
    truth: Array | None,
    volume: Array | None,
) -> tuple[str, ...]:
    """One line of the table."""
    verdict = "accepted" if pair.accepted else f"refused ({pair.kind})"
    expected = "-" if pair.expected_error is None else _pixels(pair.expected_error)
    if pair.F is None or truth is None:
        return pair.name, verdict, "-", "-", expected
    seen = None if volume is None else volume_correspondences(cameras[pair.a], cameras[pair.b], volume)
    figures = compare(pair.F, truth, recorded[pair.a].size, recorded[pair.b].size, seen)
    return pair.name, verdict, _pixels(figures.volume_error), _pixels(figures.image_error), expected


def _pixels(value: float) -> str:
    return f"{value:.2f} px" if math.isfinite(value) else "-"
