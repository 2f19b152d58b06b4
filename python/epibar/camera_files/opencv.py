"""Cameras as YAML of OpenCV's FileStorage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..files.atomic import write_atomically
from ..lens.intrinsics import Intrinsics
from ..sources.opencv import opencv

__all__ = ["write_opencv"]


def write_opencv(
    cameras: Sequence[Intrinsics], path: Path, metadata: Mapping[str, str | list[str]]
) -> list[Path]:
    """Write YAML that ``cv2.FileStorage`` reads: the metadata, and a node ``cameras``, a sequence of maps.

    A camera has ``name``, ``width``, ``height``, ``camera_matrix``, ``distortion_coefficients`` (1 × n),
    ``fisheye`` (0 or 1), ``R`` (3 × 3) and ``t`` (3 × 1): ``X_c = R X + t``.
    """
    cv2 = opencv()
    storage = cv2.FileStorage(".yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    for key, value in metadata.items():
        storage.write(key, value if isinstance(value, str) else "; ".join(value))
    storage.startWriteStruct("cameras", cv2.FILE_NODE_SEQ)
    for camera in cameras:
        pose = camera.posed()
        storage.startWriteStruct("", cv2.FILE_NODE_MAP)
        storage.write("name", camera.name)
        storage.write("width", camera.size[0])
        storage.write("height", camera.size[1])
        storage.write("camera_matrix", np.ascontiguousarray(camera.matrix))
        storage.write("distortion_coefficients", camera.distortions.reshape(1, -1))
        storage.write("fisheye", int(camera.fisheye))
        storage.write("R", np.ascontiguousarray(pose.R))
        storage.write("t", pose.t.reshape(3, 1))
        storage.endWriteStruct()
    storage.endWriteStruct()
    text = storage.releaseAndGetString()
    write_atomically(path, lambda stream: stream.write(text.encode()))
    return [path]
