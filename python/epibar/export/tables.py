"""Runs as OpenCV FileStorage YAML, as NumPy archive and as CSV."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..files.archive import write_archive
from ..files.atomic import write_atomically
from ..sources.opencv import opencv
from .run import Pair, Run

__all__ = ["write_csv", "write_npz", "write_opencv"]

CSV_COLUMNS = ("a", "b", "verdict", "frame_a", "frame_b", "x_a", "y_a", "x_b", "y_b", "residual")


def write_opencv(run: Run, path: str | os.PathLike[str]) -> list[Path]:
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
    text = storage.releaseAndGetString()
    write_atomically(path, lambda stream: stream.write(text.encode()))
    return [Path(path)]


def _write_map(cv2: Any, storage: Any, **values: Any) -> None:
    storage.startWriteStruct("", cv2.FILE_NODE_MAP)
    for key, value in values.items():
        if value is not None:
            storage.write(key, np.ascontiguousarray(value) if isinstance(value, np.ndarray) else value)
    storage.endWriteStruct()


def write_npz(run: Run, path: str | os.PathLike[str]) -> list[Path]:
    """Write one NumPy archive, without pickle.

    Keys by camera: ``cameras`` (names), ``sizes`` (n, 2), ``matrices`` (n, 3, 3). By pair: ``pairs`` (m, 2)
    places in ``cameras``, ``accepted``, ``kind``, ``reason``, ``expected_error``, ``time_offset``, ``F``,
    ``E``, ``R`` (m, 3, 3), ``t`` (m, 3). By frontier point: ``point_pair`` (place in ``pairs``),
    ``frame_a``, ``frame_b``, ``points_a``, ``points_b`` (k, 2), ``residual``. NaN where something is not
    known.

    Returns
    -------
    list of Path
        The file.
    """
    poses = run.poses()[0]
    by_pair = [poses.get((pair.a, pair.b)) for pair in run.pairs]
    places = {camera.name: place for place, camera in enumerate(run.cameras)}
    points = [pair.frontier_points for pair in run.pairs]
    unknown = np.full((3, 3), np.nan)

    def matrices(values: list[Any]) -> np.ndarray:
        return np.array([unknown if value is None else value for value in values])

    errors = [np.nan if pair.expected_error is None else pair.expected_error for pair in run.pairs]
    write_archive(
        path,
        {
            "cameras": np.array([camera.name for camera in run.cameras]),
            "sizes": np.array([camera.size for camera in run.cameras]),
            "matrices": matrices([camera.matrix for camera in run.cameras]),
            "pairs": np.array([(places[pair.a], places[pair.b]) for pair in run.pairs]),
            "accepted": np.array([pair.accepted for pair in run.pairs]),
            "kind": np.array([pair.kind for pair in run.pairs]),
            "reason": np.array([pair.reason for pair in run.pairs]),
            "expected_error": np.array(errors),
            "time_offset": np.array([pair.time_offset for pair in run.pairs]),
            "F": matrices([pair.F for pair in run.pairs]),
            "E": matrices([None if pose is None else pose.E for pose in by_pair]),
            "R": matrices([None if pose is None else pose.R for pose in by_pair]),
            "t": np.array([unknown[0] if pose is None else pose.t for pose in by_pair]),
            "point_pair": np.repeat(np.arange(len(points)), [len(group) for group in points]),
            "frame_a": np.concatenate([group.frame for group in points]),
            "frame_b": np.concatenate([pair.frames_b for pair in run.pairs]),
            "points_a": np.concatenate([group.a for group in points]),
            "points_b": np.concatenate([group.b for group in points]),
            "residual": np.concatenate([group.residual for group in points]),
        },
    )
    return [Path(path)]


def write_csv(run: Run, path: str | os.PathLike[str]) -> list[Path]:
    """Write the frontier points of all pairs in one table: frames, pixels, and the pair's verdict.

    Returns
    -------
    list of Path
        The file.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(CSV_COLUMNS)
    for pair in run.pairs:
        table.writerows(_rows(pair))
    write_atomically(path, lambda stream: stream.write(text.getvalue().encode()))
    return [Path(path)]


def _rows(pair: Pair) -> list[list[Any]]:
    points = pair.frontier_points
    frames = np.column_stack([points.frame, pair.frames_b]).tolist()
    figures = np.column_stack([points.a, points.b, points.residual]).tolist()
    return [
        [pair.a, pair.b, pair.kind, *moment, *(f"{figure:.4f}" for figure in row)]
        for moment, row in zip(frames, figures, strict=True)
    ]
