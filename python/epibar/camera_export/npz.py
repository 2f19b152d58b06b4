"""Cameras as one NumPy archive."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..files.archive import write_archive
from ..lens.intrinsics import Intrinsics
from .world import World

__all__ = ["write_cameras_npz"]


def write_cameras_npz(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write arrays without pickle.

    ``names`` (n,), ``sizes`` (n, 2), ``matrices`` (n, 3, 3), ``distortions`` (n, k) filled up with zeros,
    ``fisheye`` (n,), ``rotations`` (n, 3, 3) and ``translations`` (n, 3): ``X_c = R X + t``; ``metadata``, a
    JSON text.
    """
    posed = [camera.posed() for camera in cameras]
    most = max(5, *(len(camera.distortions) for camera in cameras))
    write_archive(
        path,
        {
            "names": np.array([camera.name for camera in cameras]),
            "sizes": np.array([camera.size for camera in cameras]),
            "matrices": np.array([camera.matrix for camera in cameras]),
            "distortions": np.array(
                [np.pad(camera.distortions, (0, most - len(camera.distortions))) for camera in cameras]
            ),
            "fisheye": np.array([camera.fisheye for camera in cameras]),
            "rotations": np.array([pose.R for pose in posed]),
            "translations": np.array([pose.t for pose in posed]),
            "metadata": np.array(json.dumps(world.metadata(), ensure_ascii=False)),
        },
    )
    return [path]
