"""Cameras as a COLMAP model: a folder with a camera, a rig, a frame and an image for each, and no points.

Pitfall: COLMAP counts pixels from the corner of the image, so that the centre of the first pixel is (0.5,
0.5). Principal points are moved accordingly.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import EpibarError, printable
from ..files.atomic import write_text
from ..files.folders import make_folder
from ..lens.intrinsics import Intrinsics
from .world import World

__all__ = ["write_colmap"]

HALF = 0.5
MODELS = ((4, "OPENCV"), (8, "FULL_OPENCV"))
"""COLMAP's models that are OpenCV's with so many coefficients."""


def write_colmap(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write a model through ``pycolmap``, in its text files, and ``README.txt`` with the metadata.

    Raises
    ------
    EpibarError
        ``pycolmap`` is missing, a lens has no COLMAP model, or the folder cannot be written.
    """
    try:
        import pycolmap
    except ImportError as error:
        raise EpibarError(
            "pycolmap is missing, which writes COLMAP models: pip install 'epibar[colmap]'"
        ) from error
    model = pycolmap.Reconstruction()
    for number, camera in enumerate(cameras, 1):
        _add(pycolmap, model, number, camera)
    make_folder(path)
    model.write_text(str(path))
    text = "\n".join(f"{key}: {_line(value)}" for key, value in world.lines().items())
    write_text(path / "README.txt", text + "\n")
    return [path]


def _add(pycolmap: Any, model: Any, number: int, camera: Intrinsics) -> None:
    name, distortions = _lens(camera)
    K = camera.matrix
    found = pycolmap.Camera.create_from_model_name(number, name, K[0, 0], *camera.size)
    found.params = [K[0, 0], K[1, 1], K[0, 2] + HALF, K[1, 2] + HALF, *distortions]
    found.has_prior_focal_length = True
    model.add_camera_with_trivial_rig(found)
    pose = camera.posed()
    image = pycolmap.Image()
    image.name, image.camera_id, image.image_id = _line(camera.name), number, number
    model.add_image_with_trivial_frame(
        image, pycolmap.Rigid3d(pycolmap.Rotation3d(np.asarray(pose.R)), np.asarray(pose.t))
    )


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
