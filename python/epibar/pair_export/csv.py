"""Runs as CSV: the frontier points of all pairs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..files.csv_table import csv_text, write_csv_table
from ..outcome.run import Pair, Run

__all__ = ["write_pairs_csv"]

COLUMNS = ("a", "b", "verdict", "frame_a", "frame_b", "x_a", "y_a", "x_b", "y_b", "residual")


def write_pairs_csv(run: Run, path: str | os.PathLike[str]) -> list[Path]:
    """Write the frontier points of all pairs in one table: frames, pixels, and the pair's verdict.

    A name that a spreadsheet would take for a formula has an apostrophe before it.

    Returns
    -------
    list of Path
        The file.
    """
    write_csv_table(path, COLUMNS, (row for pair in run.pairs for row in _rows(pair)))
    return [Path(path)]


def _rows(pair: Pair) -> list[list[Any]]:
    points = pair.frontier_points
    frames = np.column_stack([points.frame, pair.frames_b]).tolist()
    figures = np.column_stack([points.a, points.b, points.residual]).tolist()
    return [
        [*map(csv_text, (pair.a, pair.b, pair.kind)), *moment, *(f"{figure:.4f}" for figure in row)]
        for moment, row in zip(frames, figures, strict=True)
    ]
