"""Runs as CSV: the frontier points of all pairs."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import printable
from ..files.atomic import write_atomically
from ..runs.run import Pair, Run

__all__ = ["write_csv"]

COLUMNS = ("a", "b", "verdict", "frame_a", "frame_b", "x_a", "y_a", "x_b", "y_b", "residual")
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
"""What a spreadsheet takes for the start of one."""


def write_csv(run: Run, path: str | os.PathLike[str]) -> list[Path]:
    """Write the frontier points of all pairs in one table: frames, pixels, and the pair's verdict.

    A name that a spreadsheet would take for a formula has an apostrophe before it.

    Returns
    -------
    list of Path
        The file.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for pair in run.pairs:
        table.writerows(_rows(pair))
    write_atomically(path, lambda stream: stream.write(text.getvalue().encode()))
    return [Path(path)]


def _text(name: str) -> str:
    name = printable(name)  # a bare carriage return would end the row
    return f"'{name}" if name[:1] in FORMULA else name


def _rows(pair: Pair) -> list[list[Any]]:
    points = pair.frontier_points
    frames = np.column_stack([points.frame, pair.frames_b]).tolist()
    figures = np.column_stack([points.a, points.b, points.residual]).tolist()
    return [
        [*map(_text, (pair.a, pair.b, pair.kind)), *moment, *(f"{figure:.4f}" for figure in row)]
        for moment, row in zip(frames, figures, strict=True)
    ]
