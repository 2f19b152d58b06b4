"""Frontier points of a pair as CSV: written, and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import EpibarError
from ..geometry.correspondences import FrontierPoints
from .atomic import write_atomically

__all__ = ["COLUMNS", "read_frontier_points", "write_frontier_points"]

COLUMNS = "frame_a,x_a,y_a,x_b,y_b,residual"


def write_frontier_points(path: Path, points: FrontierPoints) -> Path:
    """Write the frontier points of a pair as CSV, one per line."""
    table = np.column_stack([points.frame, points.a, points.b, points.residual])
    write_atomically(
        path,
        lambda stream: np.savetxt(
            stream,
            table,
            fmt=["%d"] + 5 * ["%.4f"],
            delimiter=",",
            header=COLUMNS,
            comments="",
            encoding="utf-8",
        ),
    )
    return path


def read_frontier_points(path: Path) -> FrontierPoints:
    """Read the frontier points of a pair.

    Raises
    ------
    EpibarError
        Missing, or not what :func:`write_frontier_points` writes.
    """
    try:
        if path.exists() and not path.is_file():
            raise ValueError("not a file")
        lines = path.read_text(encoding="utf-8").splitlines()
        if not lines or lines[0] != COLUMNS:
            raise ValueError(f"the first line is not {COLUMNS}")
        rows = [[float(number) for number in line.split(",")] for line in lines[1:]]
        if any(len(row) != 6 for row in rows):
            raise ValueError("a line does not have six numbers")
        table = np.array(rows).reshape(-1, 6)
        frames = table[:, 0]
        if not np.isfinite(table).all() or not ((frames >= 0) & (frames < 2**32) & (frames % 1 == 0)).all():
            raise ValueError("a number is not finite, or a frame is no whole number")
    except (OSError, ValueError) as error:
        raise EpibarError(f"{path}: the frontier points cannot be read ({error})") from error
    return FrontierPoints(table[:, 0].astype(np.int64), table[:, 1:3], table[:, 3:5], table[:, 5])
