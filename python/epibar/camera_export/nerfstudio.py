"""Cameras as ``transforms.json`` of nerfstudio, which MultiNeRF and others of its kin read as well.

nerfstudio's reader (``nerfstudio/data/dataparsers/nerfstudio_dataparser.py``) takes ``fl_x``, ``fl_y``,
``cx``, ``cy``, ``w``, ``h``, ``k1``, ``k2``, ``k3``, ``p1`` and ``p2`` from each frame, or from the top where
they stand there; ``camera_model`` from the top alone. MultiNeRF's (``internal/datasets.py``,
``load_blender_posedata``) knows those of the top alone, and no k3, and takes no lens for a fisheye.
``transform_matrix`` is camera to world, x right, y up, z back.

Pitfall: both count pixels from the corner of the image, so that the centre of the first pixel is (0.5, 0.5).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import EpibarError, printable
from ..files.atomic import write_text
from ..geometry.cameras import opengl_pose
from ..lens.intrinsics import Intrinsics
from .losses import fewer_coefficients, loss_in_pixels, plain_names, tell
from .world import World

__all__ = ["write_nerfstudio"]

HALF = 0.5
NO_FILE_NAME = r"[^\w.-]"
COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3")
FISHEYE_COEFFICIENTS = ("k1", "k2", "k3", "k4")


def write_nerfstudio(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write one frame for each camera; its picture is to be ``images/NAME.png`` beside the file.

    A lens that all cameras have stands at the top.

    Raises
    ------
    EpibarError
        Some lenses are fisheyes and some are not, for which the file has no place; or it cannot be written.
    """
    if len({camera.fisheye for camera in cameras}) > 1:
        raise EpibarError("transforms.json has one camera_model: it cannot hold fisheye lenses and others")
    files = [f"images/{name}.png" for name in plain_names(cameras, NO_FILE_NAME)]
    lenses, off = [], {}
    for camera in cameras:
        lens, off[camera.name] = _lens(camera)
        lenses.append(lens)
    losses = loss_in_pixels("nerfstudio has five distortion coefficients, fitted to the lens", off)
    shared = all(lens == lenses[0] for lens in lenses)
    frames = [
        {
            "file_path": file,
            "name": printable(camera.name),
            **({} if shared else lens),
            "transform_matrix": _camera_to_world(camera),
        }
        for file, camera, lens in zip(files, cameras, lenses, strict=True)
    ]
    content = {
        "camera_model": "OPENCV_FISHEYE" if cameras[0].fisheye else "OPENCV",
        **(lenses[0] if shared else {}),
        "frames": frames,
        "metadata": world.with_notes(losses).metadata(),
    }
    text = json.dumps(content, indent=1, allow_nan=False)
    write_text(path, text)
    tell(path, losses)
    return [path]


def _lens(camera: Intrinsics) -> tuple[dict[str, float], float]:
    if camera.fisheye:
        off = 0.0
        distortions = np.pad(camera.distortions, (0, 4 - len(camera.distortions)))
    else:
        distortions, off = fewer_coefficients(camera, len(COEFFICIENTS), "nerfstudio")
    names = FISHEYE_COEFFICIENTS if camera.fisheye else COEFFICIENTS
    K = camera.matrix
    lens = {
        "w": camera.size[0],
        "h": camera.size[1],
        "fl_x": K[0, 0],
        "fl_y": K[1, 1],
        "cx": K[0, 2] + HALF,
        "cy": K[1, 2] + HALF,
        **dict(zip(names, distortions.tolist(), strict=True)),
    }
    return lens, off


def _camera_to_world(camera: Intrinsics) -> list[list[float]]:
    rotation, position = opengl_pose(camera.posed())
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, position
    found: list[list[float]] = matrix.tolist()
    return found
