"""``epibar evaluate``: errors of a calibration against cameras whose pose is known."""

from __future__ import annotations

import math
from argparse import Namespace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import EpibarError
from ..evaluation import (
    compare,
    fundamental_from_cameras,
    moving_volume,
    project,
    projection_matrix,
    symmetric_epipolar_distance,
    triangulate,
    volume_correspondences,
)
from ..intrinsics import Pose, find_camera, load_cameras
from ..report.files import read_frontier_points, read_json
from .console import Console

__all__ = ["run"]

Array = NDArray[np.float64]

RADIUS = 6.0
"""Pixels: a frontier point that is farther from the true epipolar lines is a wrong match."""

LEAST_POINTS = 20


def run(args: Namespace) -> int:
    """Run the command."""
    console = Console()
    path = Path(args.calibration)
    result = read_json(path)
    known = load_cameras(args.cameras)
    try:
        cameras = {
            camera["name"]: find_camera(known, camera["name"], camera["index"]).posed()
            for camera in result["cameras"]
        }
        sizes = {camera["name"]: (camera["width"], camera["height"]) for camera in result["cameras"]}
        pairs = [pair for pair in result["pairs"] if {pair["a"], pair["b"]} <= cameras.keys()]
    except (KeyError, TypeError) as error:
        raise EpibarError(f"{path}: damaged: {error} is missing or of the wrong kind") from error
    if not result.get("intrinsics") and any(camera.distorted for camera in known):
        console.warning(
            f"{path} was made without --intrinsics, but the cameras have lens distortion; "
            "the errors below include it"
        )
    points = list(chain.from_iterable(_world_points(path, pair, cameras) for pair in pairs))
    volume = moving_volume(np.array(points)) if len(points) >= LEAST_POINTS else None

    rows: list[tuple[str, ...]] = [("pair", "verdict", "error over the volume", "over the image", "expected")]
    rows += [_row(pair, cameras, sizes, volume) for pair in pairs]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        console.result("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    if volume is None:
        console.note("too few frontier points agree with the known cameras to tell where things moved")
    return 0


def _world_points(path: Path, pair: dict[str, Any], cameras: dict[str, Pose]) -> Array:
    """Triangulate the frontier points of a pair with the known cameras: where things moved, (n, 3)."""
    if not pair.get("frontier_points"):
        return np.empty((0, 3))
    touched = read_frontier_points(path.parent / pair["frontier_points"])
    a, b = touched.a, touched.b
    camera_a, camera_b = cameras[pair["a"]], cameras[pair["b"]]
    if len(a):
        right = symmetric_epipolar_distance(fundamental_from_cameras(camera_a, camera_b), a, b) < RADIUS
        a, b = a[right], b[right]
    if not len(a):
        return np.empty((0, 3))
    points = triangulate(projection_matrix(camera_a), projection_matrix(camera_b), a, b)
    points = points[np.isfinite(points).all(axis=1)]
    in_front = (project(camera_a, points)[1] > 0) & (project(camera_b, points)[1] > 0)
    return points[in_front]


def _row(
    pair: dict[str, Any],
    cameras: dict[str, Pose],
    sizes: dict[str, tuple[int, int]],
    volume: Array | None,
) -> tuple[str, ...]:
    """One line of the table."""
    name, verdict = (
        f"{pair['a']} - {pair['b']}",
        "accepted" if pair["accepted"] else f"refused ({pair['kind']})",
    )
    expected = "-" if pair["expected_error"] is None else _pixels(pair["expected_error"])
    if pair["F"] is None:
        return name, verdict, "-", "-", expected
    camera_a, camera_b = cameras[pair["a"]], cameras[pair["b"]]
    seen = None if volume is None else volume_correspondences(camera_a, camera_b, volume)
    figures = compare(
        pair["F"], fundamental_from_cameras(camera_a, camera_b), sizes[pair["a"]], sizes[pair["b"]], seen
    )
    return name, verdict, _pixels(figures.volume_error), _pixels(figures.image_error), expected


def _pixels(value: float) -> str:
    return f"{value:.2f} px" if math.isfinite(value) else "-"
