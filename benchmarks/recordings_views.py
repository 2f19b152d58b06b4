"""Real recordings whose cameras are known: which there are, and the views that are made of them."""

from __future__ import annotations

import hashlib
import time
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common import Array
from options import add_common, add_names
from tables import progress

import epibar
from epibar import EpibarError, Recording
from epibar.evaluation import matched_tangent_points, moving_volume, volume_correspondences
from epibar.foreground.options import ForegroundOptions
from epibar.geometry.cameras import PosedCamera, project, projection_matrix, triangulate
from epibar.lens.cameras_toml import find_camera
from epibar.lens.intrinsics import Intrinsics

ROOT = Path(__file__).resolve().parents[1]
LEAST_POINTS = 20
MADE_BY = (
    "recording.py",
    "from_video.py",
    "sources/*.py",
    "lens/*.py",
    "foreground/*.py",
    "health/camera_*.py",
)
"""Modules that decide what a recording holds: a cached one made by others is made anew."""


@dataclass(frozen=True)
class Data:
    """One recording of several cameras: the files, by the name of the camera in ``cameras.toml``."""

    folder: str
    files: dict[str, str]
    masks: bool
    radius: float = 6.0
    """Pixels between a tangent and its partner under the known F, when looking for where things moved."""


def _numbered(pattern: str, name: str, numbers: range) -> dict[str, str]:
    return {name.format(number): pattern.format(number) for number in numbers}


DATA = {
    "four_people": Data("four_people", _numbered("cam{}.avi", "cam{}", range(1, 4)), masks=True),
    "hand_over_desk": Data("hand_over_desk", _numbered("cam{}.mp4", "cam{}", range(2)), masks=False),
    "man_at_desk": Data("man_at_desk", _numbered("cam_{}.mp4", "cam_{}", range(4)), masks=False),
    # The views of these are inconsistent by 3-8 px.
    "walking": Data("room_of_people", _numbered("walking_cam{}.npz", "cam{}", range(1, 5)), True, 10.0),
    "jumping": Data("room_of_people", _numbered("jumping_cam{}.npz", "cam{}", range(1, 5)), True, 10.0),
    "pets_cameras": Data("pets_cameras", _numbered("cam{}.npz", "cam{}", range(1, 9)), masks=True),
    "wildtrack": Data("wildtrack", _numbered("cam{}.npz", "cam{}", range(1, 8)), masks=True),
}
NETWORKS = ("pets_cameras", "wildtrack")
"""Those with many pairs, which are measured on request."""


@dataclass(frozen=True)
class View:
    """A recorded camera whose pose is known."""

    name: str
    recording: Recording
    posed: PosedCamera
    hulls: list[list[Array]]


def _cache_name(path: Path, camera: Intrinsics, *options: object) -> str:
    """Name the cached recording after everything in Python that it depends on."""
    package = Path(epibar.__file__).parent
    digest = hashlib.sha256()
    made_by = (module for pattern in MADE_BY for module in sorted(package.glob(pattern)))
    for part in (path, path.parent / "cameras.toml", *made_by):
        digest.update(part.read_bytes())
    digest.update(repr((camera.name, *options)).encode())
    return f"{path.parent.name}_{path.stem}_{digest.hexdigest()[:16]}.npz"


def record(
    path: Path,
    masks: bool,
    camera: Intrinsics,
    lines: int,
    seed: int,
    foreground: ForegroundOptions,
    cache: Path | None,
    first: int = 0,
) -> Recording:
    """Record a camera in undistorted pixels from a frame on, or load it from the cache."""
    cached = None if cache is None else cache / _cache_name(path, camera, lines, seed, foreground, first)
    if cached is not None and cached.exists():
        try:
            return Recording.load(cached)
        except EpibarError as error:
            progress(f"recorded anew: {error}")
    recording = epibar.record(
        path,
        lines=lines,
        seed=seed,
        name=path.stem,
        masks=masks,
        foreground=foreground,
        intrinsics=camera,
        frames=(first, None),
        progress=False,
    )
    for warning in recording.warnings:
        progress(f"{path.name}: {warning}")
    if cached is not None:
        cached.parent.mkdir(parents=True, exist_ok=True)
        recording.save(cached)
    return recording


def foreground_of(args: Namespace) -> ForegroundOptions:
    """Return the foreground that was asked for."""
    return ForegroundOptions(method=args.foreground, threshold=args.threshold)


def view(
    path: Path, name: str, index: int, known: list[Intrinsics], data: Data, args: Namespace, first: int = 0
) -> View:
    """Record a camera from a frame on."""
    camera = find_camera(known, name, index)
    started = time.perf_counter()
    recording = record(path, data.masks, camera, args.lines, index, foreground_of(args), args.cache, first)
    progress(
        f"{path.parent.name}/{path.name}: {recording.frames} frames, {time.perf_counter() - started:.1f} s"
    )
    hulls = [recording.hulls(frame) for frame in range(recording.frames)]
    return View(name, recording, camera.posed(), hulls)


def matched(a: View, b: View, F: Array, radius: float) -> tuple[Array, Array]:
    """Match the tangents of two views under an F: (n, 2) pixels in each."""
    frames = min(len(a.hulls), len(b.hulls))
    points_a, points_b, _ = matched_tangent_points(
        a.hulls[:frames], b.hulls[:frames], F, radius, a.recording.size, b.recording.size
    )
    return points_a, points_b


def volume_of(a: View, b: View, points: tuple[Array, Array]) -> tuple[Array, Array] | None:
    """Correspondences over the box in which the matched tangents of known cameras lie."""
    if len(points[0]) < LEAST_POINTS:
        return None
    world = triangulate(projection_matrix(a.posed), projection_matrix(b.posed), *points)
    world = world[np.isfinite(world).all(axis=1)]
    world = world[(project(a.posed, world)[1] > 0) & (project(b.posed, world)[1] > 0)]
    if len(world) < LEAST_POINTS:
        return None
    return volume_correspondences(a.posed, b.posed, moving_volume(world))


def parser_of(description: str) -> ArgumentParser:
    """Make a parser of the options of every program that measures on the recordings."""
    parser = ArgumentParser(description=description)
    parser.add_argument("data_dir", nargs="?", type=Path, default=ROOT.parent / "shared" / "data")
    add_common(parser, lines=20_000)
    usual = [name for name in DATA if name not in NETWORKS]
    add_names(parser, "--only", DATA, usual, "default: all but the last two; ")
    parser.add_argument("--foreground", choices=("auto", "mog2", "mixture", "knn", "median"), default="auto")
    parser.add_argument("--threshold", type=float, default=0.0, help="of the foreground (default: its own)")
    parser.add_argument("--cache", type=Path, metavar="DIR", help="keep the recordings there")
    return parser


def present(args: Namespace) -> list[str]:
    """Those of the recordings asked for that are there; says so where none is."""
    found = [name for name in args.only if (args.data_dir / DATA[name].folder / "cameras.toml").exists()]
    if not found:
        print(f"{args.data_dir}: none of {', '.join(args.only)} is there, so there is nothing to measure")
    return found
