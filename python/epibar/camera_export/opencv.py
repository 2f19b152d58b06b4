"""Cameras as YAML of OpenCV's FileStorage."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..files.atomic import write_text
from ..files.opencv_text import opencv_text
from ..lens.intrinsics import Intrinsics
from ..sources.quiet_opencv import opencv
from .world import World

__all__ = ["write_cameras_opencv", "write_metadata"]


def write_cameras_opencv(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write YAML that ``cv2.FileStorage`` reads: the metadata, and a node ``cameras``, a sequence of maps.

    A camera has ``name``, ``width``, ``height``, ``camera_matrix``, ``distortion_coefficients`` (1 × n),
    ``fisheye`` (0 or 1), ``R`` (3 × 3) and ``t`` (3 × 1): ``X_c = R X + t``.
    """
    cv2 = opencv()
    storage = cv2.FileStorage(".yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    write_metadata(storage, world)
    storage.startWriteStruct("cameras", cv2.FILE_NODE_SEQ)
    for camera in cameras:
        pose = camera.posed()
        storage.startWriteStruct("", cv2.FILE_NODE_MAP)
        storage.write("name", opencv_text(camera.name))
        storage.write("width", camera.size[0])
        storage.write("height", camera.size[1])
        storage.write("camera_matrix", np.ascontiguousarray(camera.matrix))
        storage.write("distortion_coefficients", camera.distortions.reshape(1, -1))
        storage.write("fisheye", int(camera.fisheye))
        storage.write("R", np.ascontiguousarray(pose.R))
        storage.write("t", pose.t.reshape(3, 1))
        storage.endWriteStruct()
    storage.endWriteStruct()
    write_text(path, storage.releaseAndGetString())
    return [path]


def write_metadata(storage: Any, world: World) -> None:
    """Write what a file says of itself as texts."""
    for key, value in world.lines().items():
        storage.write(key, opencv_text(value))
