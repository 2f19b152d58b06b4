"""Frontier points of a pair as CSV: written, and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..arguments import Array, Index
from ..errors import EpibarError
from ..geometry.correspondences import FrontierPoints
from .atomic import write_atomically

__all__ = ["COLUMNS", "read_frames_b", "read_frontier_points", "write_frontier_points"]

COLUMNS = "frame_a,x_a,y_a,x_b,y_b,residual"
FRAMES_B = ",frame_b"


def write_frontier_points(path: Path, points: FrontierPoints, frames_b: Index | None = None) -> Path:
    """Write the frontier points of a pair as CSV, one per line, with the frame of B where it is known."""
    table = np.column_stack([points.frame, points.a, points.b, points.residual])
    formats = ["%d"] + 5 * ["%.4f"]
    if frames_b is not None:
        table, formats = np.column_stack([table, frames_b]), [*formats, "%d"]
    write_atomically(
        path,
        lambda stream: np.savetxt(
            stream,
            table,
            fmt=formats,
            delimiter=",",
            header=COLUMNS if frames_b is None else COLUMNS + FRAMES_B,
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
    table = _table(path)
    return FrontierPoints(table[:, 0].astype(np.int64), table[:, 1:3], table[:, 3:5], table[:, 5])


def read_frames_b(path: Path) -> Index | None:
    """Read the frame of B of each frontier point of a pair; None where the file does not have it.

    Raises
    ------
    EpibarError
        As of :func:`read_frontier_points`.
    """
    table = _table(path)
    return table[:, 6].astype(np.int64) if table.shape[1] > 6 else None


def _table(path: Path) -> Array:
    """All numbers of the file, a row for each point."""
    try:
        if path.exists() and not path.is_file():
            raise ValueError("not a file")
        lines = path.read_text(encoding="utf-8").splitlines()
        if not lines or lines[0] not in (COLUMNS, COLUMNS + FRAMES_B):
            raise ValueError(f"the first line is not {COLUMNS}")
        count = lines[0].count(",") + 1
        rows = [[float(number) for number in line.split(",")] for line in lines[1:]]
        if any(len(row) != count for row in rows):
            raise ValueError(f"a line does not have {'six' if count == 6 else 'seven'} numbers")
        table = np.array(rows, dtype=np.float64).reshape(-1, count)
        frames = table[:, [0, *range(6, count)]]
        if not np.isfinite(table).all() or not ((frames >= 0) & (frames < 2**32) & (frames % 1 == 0)).all():
            raise ValueError("a number is not finite, or a frame is no whole number")
    except (OSError, ValueError) as error:
        raise EpibarError(f"{path}: the frontier points cannot be read ({error})") from error
    return table
