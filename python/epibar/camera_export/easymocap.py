"""Cameras as ``intri.yml`` and ``extri.yml`` of EasyMocap.

Its ``read_camera`` (``easymocap/mytools/camera_utils.py``) reads the list ``names``, and of each camera
``K_NAME``, ``dist_NAME`` (1 × 5), ``H_NAME``, ``W_NAME``; ``R_NAME`` (Rodrigues) and ``T_NAME``; others read
``Rot_NAME``, the matrix: ``X_c = R X + T``. A name is that of a camera's folder of images, and part of a key
of OpenCV's FileStorage, so it is letters, digits, hyphens and underscores.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..files.atomic import write_text
from ..files.folders import make_folder
from ..lens.intrinsics import Intrinsics
from ..sources.quiet_opencv import opencv
from .losses import fewer_coefficients, loss_in_pixels, plain_names, renamed, tell
from .opencv import write_metadata
from .world import World

__all__ = ["write_easymocap"]

NO_PART_OF_A_KEY = r"[^A-Za-z0-9_-]"
NO_CAMERA = ("none",)
"""What the reader leaves out of the list of names."""


def write_easymocap(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write both files into a folder.

    Raises
    ------
    EpibarError
        A camera has a fisheye lens, or a file cannot be written.
    """
    cv2 = opencv()
    names = plain_names(cameras, NO_PART_OF_A_KEY, NO_CAMERA)
    losses = renamed(cameras, names)
    lenses, off = [], {}
    for camera in cameras:
        distortions, off[camera.name] = fewer_coefficients(camera, 5, "EasyMocap")
        lenses.append(distortions)
    losses += loss_in_pixels("EasyMocap has five distortion coefficients, fitted to the lens", off)
    intri, extri = (_started(cv2, names, world.with_notes(losses)) for _ in range(2))
    for name, camera, distortions in zip(names, cameras, lenses, strict=True):
        pose = camera.posed()
        intri.write(f"K_{name}", np.ascontiguousarray(camera.matrix))
        intri.write(f"dist_{name}", distortions.reshape(1, -1))
        intri.write(f"H_{name}", camera.size[1])
        intri.write(f"W_{name}", camera.size[0])
        extri.write(f"R_{name}", np.asarray(camera.rotation, np.float64).reshape(3, 1))
        extri.write(f"Rot_{name}", np.ascontiguousarray(pose.R))
        extri.write(f"T_{name}", pose.t.reshape(3, 1))
    make_folder(path)
    written = [path / "intri.yml", path / "extri.yml"]
    for file, storage in zip(written, (intri, extri), strict=True):
        write_text(file, storage.releaseAndGetString())
    tell(path, losses)
    return written


def _started(cv2: Any, names: list[str], world: World) -> Any:
    storage = cv2.FileStorage(".yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    write_metadata(storage, world)
    storage.startWriteStruct("names", cv2.FILE_NODE_SEQ)
    for name in names:
        storage.write("", f'"{name}"')  # else 01 would be a number
    storage.endWriteStruct()
    return storage
