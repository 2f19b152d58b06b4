"""Runs as one NumPy archive."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import AnyArray
from ..files.archive import write_archive
from ..outcome.run import Run, no_points

__all__ = ["write_pairs_npz"]


def write_pairs_npz(run: Run, path: str | os.PathLike[str]) -> list[Path]:
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
    none = no_points()  # of a run without pairs
    unknown = np.full((3, 3), np.nan)

    def matrices(values: list[Any]) -> AnyArray:
        return np.array([unknown if value is None else value for value in values]).reshape(-1, 3, 3)

    errors = [np.nan if pair.expected_error is None else pair.expected_error for pair in run.pairs]
    write_archive(
        path,
        {
            "cameras": np.array([camera.name for camera in run.cameras]),
            "sizes": np.array([camera.size for camera in run.cameras]).reshape(-1, 2),
            "matrices": matrices([camera.matrix for camera in run.cameras]),
            "pairs": np.array([(places[pair.a], places[pair.b]) for pair in run.pairs], int).reshape(-1, 2),
            "accepted": np.array([pair.accepted for pair in run.pairs]),
            "kind": np.array([pair.kind for pair in run.pairs]),
            "reason": np.array([pair.reason for pair in run.pairs]),
            "expected_error": np.array(errors),
            "time_offset": np.array([pair.time_offset for pair in run.pairs]),
            "F": matrices([pair.F for pair in run.pairs]),
            "E": matrices([None if pose is None else pose.E for pose in by_pair]),
            "R": matrices([None if pose is None else pose.R for pose in by_pair]),
            "t": np.array([unknown[0] if pose is None else pose.t for pose in by_pair]).reshape(-1, 3),
            "point_pair": np.repeat(np.arange(len(points)), np.array([len(group) for group in points], int)),
            "frame_a": np.concatenate([none.frame, *(group.frame for group in points)]),
            "frame_b": np.concatenate([none.frame, *(pair.frames_b for pair in run.pairs)]),
            "points_a": np.concatenate([none.a, *(group.a for group in points)]),
            "points_b": np.concatenate([none.b, *(group.b for group in points)]),
            "residual": np.concatenate([none.residual, *(group.residual for group in points)]),
        },
    )
    return [Path(path)]
