"""Cameras as a COLMAP model: a folder with a camera, a rig, a frame and an image for each, and points.

A stationary camera is one image, which holds what it saw at all moments. A point is seen by two cameras:
where both see a top or a bottom of a silhouette, or another frontier point. What stands in an image was
measured there, so COLMAP's errors are those of the network. Points that COLMAP's own mapper would filter, by
their error or their angle, are left out.

Pitfall: COLMAP counts pixels from the corner of the image, so that the centre of the first pixel is (0.5,
0.5). Principal points and what was measured are moved accordingly.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import UNPRINTABLE, EpibarError, printable
from ..files.atomic import write_text
from ..files.folders import make_folder, refuse_others_files
from ..lens.intrinsics import Intrinsics
from .losses import plain_names, renamed, tell
from .two_views import TwoViews
from .world import SOFTWARE, World

__all__ = ["write_cameras_colmap"]

HALF = 0.5
MODELS = ((4, "OPENCV"), (8, "FULL_OPENCV"))
"""COLMAP's models that are OpenCV's with so many coefficients."""
MOST_POINTS = 50_000
"""In all. Each two cameras have the same share of them, spread over the time."""

README = "README.txt"
PARTS = ("cameras", "frames", "images", "points3D", "rigs")
MODEL_FILES = tuple(f"{part}.{kind}" for kind in ("txt", "bin") for part in PARTS)
"""A model's, as text and as COLMAP's own, which COLMAP reads first."""

NO_WORD = rf"\s|{UNPRINTABLE.pattern}"
"""What is no part of one word: readers of the files as text end a name at a blank."""


def write_cameras_colmap(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write a model through ``pycolmap``, in its text files, and ``README.txt`` with the metadata.

    Raises
    ------
    EpibarError
        ``pycolmap`` is missing, a lens has no COLMAP model, or the folder cannot be written, or holds the
        model of another program.
    """
    try:
        import pycolmap
    except ImportError as error:
        raise EpibarError(
            "pycolmap is missing, which writes COLMAP models: pip install 'epibar[colmap]'"
        ) from error
    refuse_others_files(path, (README, *MODEL_FILES), README, f"software: {SOFTWARE}")
    model = pycolmap.Reconstruction()
    names = plain_names(cameras, NO_WORD)
    for number, (camera, name) in enumerate(zip(cameras, names, strict=True), 1):
        _add(pycolmap, model, number, name, camera)
    others = renamed(cameras, names)
    tell(path, others)
    world = world.with_notes(others)
    if world.two_views:
        numbers = {camera.name: number for number, camera in enumerate(cameras, 1)}
        world = world.with_notes([_add_points(pycolmap, model, numbers, world.two_views)])
    make_folder(path)
    model.write_text(str(path))
    header = {"software": SOFTWARE, **world.lines()}
    write_text(path / README, "".join(f"{key}: {_line(value)}\n" for key, value in header.items()))
    return [path]


def _add(pycolmap: Any, model: Any, number: int, name: str, camera: Intrinsics) -> None:
    lens, distortions = _lens(camera)
    K = camera.matrix
    found = pycolmap.Camera.create_from_model_name(number, lens, K[0, 0], *camera.size)
    found.params = [K[0, 0], K[1, 1], K[0, 2] + HALF, K[1, 2] + HALF, *distortions]
    found.has_prior_focal_length = True
    model.add_camera_with_trivial_rig(found)
    pose = camera.posed()
    image = pycolmap.Image()
    image.name, image.camera_id, image.image_id = name, number, number
    model.add_image_with_trivial_frame(
        image, pycolmap.Rigid3d(pycolmap.Rotation3d(np.asarray(pose.R)), np.asarray(pose.t))
    )


def _add_points(pycolmap: Any, model: Any, numbers: Mapping[str, int], shared: Sequence[TwoViews]) -> str:
    """Add points with what was measured of them, and say how many."""
    measured: dict[int, list[Any]] = {number: [] for number in numbers.values()}
    tracks = []
    share = max(1, MOST_POINTS // len(shared))
    for both in (one.thinned(share) for one in shared):
        a, b = numbers[both.a], numbers[both.b]
        seen = both.pixels_a + HALF, both.pixels_b + HALF
        for place, *pixels in zip(_triangulated(pycolmap, model, (a, b), seen), *seen, strict=True):
            if place is None:
                continue
            track = pycolmap.Track()
            for number, pixel in zip((a, b), pixels, strict=True):
                track.add_element(number, len(measured[number]))
                measured[number].append(pycolmap.Point2D(pixel))
            tracks.append((place, track))
    for number, pixels in measured.items():
        model.image(number).points2D = pycolmap.Point2DList(pixels)
    for place, track in tracks:
        model.add_point3D(place, track)
    limits = pycolmap.IncrementalMapperOptions()
    every = pycolmap.ObservationManager(model)
    every.filter_all_points3D(limits.filter_max_reproj_error, limits.filter_min_tri_angle)
    model.update_point_3d_errors()
    return f"{model.num_points3D()} points, each seen by two cameras"


def _triangulated(pycolmap: Any, model: Any, numbers: Sequence[int], seen: Sequence[Array]) -> list[Any]:
    """Place of each point, (3,), or None where its rays do not meet."""
    poses = [model.image(number).cam_from_world().matrix() for number in numbers]
    rays = [model.camera(number).cam_from_img(pixels) for number, pixels in zip(numbers, seen, strict=True)]
    return [
        pycolmap.triangulate_point(*poses, p, q) if np.isfinite([p, q]).all() else None
        for p, q in zip(*rays, strict=True)
    ]


def _line(text: str) -> str:
    """Keep a text on its line: the files have one for each image."""
    return re.sub(r"[\n\t]+", " ", printable(text))


def _lens(camera: Intrinsics) -> tuple[str, list[float]]:
    """Name of COLMAP's model, and its coefficients."""
    distortions = camera.distortions.tolist()
    if camera.fisheye:
        return "OPENCV_FISHEYE", [*distortions, 0.0, 0.0, 0.0, 0.0][:4]
    if not camera.distorted:
        return "PINHOLE", []
    if any(distortions[8:]):
        raise EpibarError(
            f"{camera.name}: COLMAP has no model of a lens with {len(distortions)} coefficients"
        )
    for count, name in MODELS:
        if not any(distortions[count:]):
            return name, [*distortions, *(count * [0.0])][:count]
    raise AssertionError("eight coefficients are enough")
