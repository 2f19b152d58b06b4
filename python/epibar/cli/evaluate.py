"""``epibar evaluate``: errors of a calibration against cameras whose pose is known."""

from __future__ import annotations

import math
from argparse import Namespace

from ..evaluation.run import PairEvaluation, evaluate
from .console import Console

__all__ = ["run"]

HEADER = ("pair", "verdict", "error over the volume", "over the image", "expected")


def run(args: Namespace) -> int:
    """Run the command."""
    console = Console()
    found = evaluate(args.calibration, args.cameras)
    for warning in found.warnings:
        console.warning(warning)
    rows = [HEADER, *map(_row, found.pairs)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADER))]
    for row in rows:
        console.result("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    if not found.volume_known:
        console.note("too few frontier points agree with the known cameras to tell where things moved")
    return 0


def _row(pair: PairEvaluation) -> tuple[str, ...]:
    """One line of the table."""
    verdict = "accepted" if pair.accepted else f"refused ({pair.kind})"
    figures = (pair.volume_error, pair.image_error, pair.expected_error)
    return (pair.name, verdict, *map(_pixels, figures))


def _pixels(value: float | None) -> str:
    return "-" if value is None or not math.isfinite(value) else f"{value:.2f} px"
