"""Runs as YAML of OpenCV's FileStorage."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..files.atomic import write_text
from ..files.opencv_text import opencv_text
from ..outcome.run import Run
from ..sources.quiet_opencv import opencv

__all__ = ["write_pairs_opencv"]


def write_pairs_opencv(run: Run, path: str | os.PathLike[str]) -> list[Path]:
    """Write YAML that ``cv2.FileStorage`` reads: nodes ``cameras`` and ``pairs``, each a sequence of maps.

    A pair has ``a``, ``b``, ``accepted`` (0 or 1), ``kind``, ``reason``, ``time_offset``, ``points_a`` and
    ``points_b`` (n × 2), and where they are known ``F``, ``expected_error``, ``E``, ``R``, ``t``
    (``X_b = R X_a + t``).

    Returns
    -------
    list of Path
        The file.
    """
    cv2 = opencv()
    poses = run.poses()[0]
    storage = cv2.FileStorage(".yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    storage.write("convention", "x_b^T F x_a = 0; pixels, pixel centres at integers")
    storage.startWriteStruct("cameras", cv2.FILE_NODE_SEQ)
    for camera in run.cameras:
        _write_map(
            cv2,
            storage,
            name=camera.name,
            width=camera.size[0],
            height=camera.size[1],
            matrix=camera.matrix,
        )
    storage.endWriteStruct()
    storage.startWriteStruct("pairs", cv2.FILE_NODE_SEQ)
    for pair in run.pairs:
        pose = poses.get((pair.a, pair.b))
        _write_map(
            cv2,
            storage,
            a=pair.a,
            b=pair.b,
            accepted=int(pair.accepted),
            kind=pair.kind,
            reason=pair.reason,
            time_offset=pair.time_offset,
            expected_error=pair.expected_error,
            F=pair.F,
            E=None if pose is None else pose.E,
            R=None if pose is None else pose.R,
            t=None if pose is None else pose.t,
            points_a=pair.frontier_points.a,
            points_b=pair.frontier_points.b,
        )
    storage.endWriteStruct()
    write_text(path, storage.releaseAndGetString())
    return [Path(path)]


def _write_map(cv2: Any, storage: Any, **values: Any) -> None:
    storage.startWriteStruct("", cv2.FILE_NODE_MAP)
    for key, value in values.items():
        if isinstance(value, str):
            storage.write(key, opencv_text(value))
        elif value is not None:
            storage.write(key, np.ascontiguousarray(value) if isinstance(value, np.ndarray) else value)
    storage.endWriteStruct()
