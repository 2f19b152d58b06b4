"""``epibar evaluate``: errors of a calibration against cameras whose pose is known."""

from __future__ import annotations

import math
from argparse import Namespace
from typing import TYPE_CHECKING

from .exit_codes import DONE
from .options import CommandParser, add_output_options

if TYPE_CHECKING:
    from ..evaluation.run import PairEvaluation

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "evaluate"
HELP = "compare a calibration with known cameras"
DESCRIPTION = (
    "Print for every pair the symmetric epipolar distance over the volume where things moved and over the "
    "image, against cameras whose pose is known."
)
HEADER = ("pair", "verdict", "error over the volume", "over the image", "expected")


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.add_argument(
        "calibration",
        metavar="calibration.json",
        help="what 'epibar calibrate' wrote, or the folder it is in",
    )
    command.add_argument(
        "--cameras",
        required=True,
        metavar="FILE.toml",
        help="the known cameras with their poses, by the same names: from a calibration that is to be "
        "believed more, such as one with a board, or of a made-up scene",
    )
    add_output_options(
        command, json="print the errors as JSON on stdout, and warnings on stderr; for programs"
    )


def run(args: Namespace) -> int:
    """Run the command."""
    import json

    from ..evaluation.run import evaluate
    from ..files.text_table import aligned
    from .console import Console

    console = Console(args.quiet, json=args.json, verbose=args.verbose)
    found = evaluate(args.calibration, args.cameras)
    for warning in found.warnings:
        console.warning(warning)
    if args.json:
        console.json(json.dumps(found.as_dict(), indent=1, allow_nan=False))
        return DONE
    for line in aligned([HEADER, *map(_row, found.pairs)]):
        console.result(line)
    if not found.volume_known:
        console.note("too few frontier points agree with the known cameras to tell where things moved")
    return DONE


def _row(pair: PairEvaluation) -> tuple[str, ...]:
    """One line of the table."""
    verdict = "accepted" if pair.accepted else f"refused ({pair.kind})"
    figures = (pair.volume_error, pair.image_error, pair.expected_error)
    return (pair.name, verdict, *map(_pixels, figures))


def _pixels(value: float | None) -> str:
    return "-" if value is None or not math.isfinite(value) else f"{value:.2f} px"
