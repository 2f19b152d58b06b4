"""Options of lengths that give a network its scale, such as ``--person-height``. Standard library only."""

from __future__ import annotations

import argparse
import math
from typing import Any

from .options import NAME, any_number

__all__ = ["add_length_options", "length", "lengths"]


def length(text: str) -> float | tuple[float, float]:
    """Read a length in metres, with its standard error where that is said: 4.20, 4.20±0.01 or 4.20+-0.01."""
    metres, says, error = text.replace("+-", "±").partition("±")
    numbers = [any_number(metres), any_number(error)] if says else [any_number(metres)]
    if not all(math.isfinite(number) and number > 0 for number in numbers):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a positive number of metres, such as 4.20, or 4.20+-0.01 where its standard "
            "error is known"
        )
    return (numbers[0], numbers[1]) if says else numbers[0]


def add_length_options(command: argparse.ArgumentParser) -> None:
    """Add the lengths that give a network its scale."""
    group = command.add_argument_group(
        "metres: what is known of the scale, any number of them",
        # In ASCII, which every terminal can print.
        "M is metres, 4.20, or metres with their standard error, 4.20+-0.01, where it is another than that "
        "below",
    )
    group.add_argument(
        "--person-height",
        type=length,
        metavar="M",
        help="how tall those who walk are in the median, as they walk: when nothing was measured, for it is "
        "good to some 3 %%",
    )
    group.add_argument(
        "--distance",
        nargs=3,
        action="append",
        default=[],
        metavar=("A", "B", "M"),
        help="between two cameras, by their names: when one can be measured, to 1 %% or 1 cm, which is best; "
        "may be given again for others",
    )
    group.add_argument(
        "--camera-height",
        nargs=2,
        action="append",
        default=[],
        metavar=("A", "M"),
        help="of a camera above the floor: when that is easier to measure, to 1 %% or 1 cm; may be given "
        "again for others",
    )


def lengths(args: argparse.Namespace) -> dict[str, Any]:
    """Take the lengths that were given."""
    return {
        "distance": [
            (a.removeprefix(NAME), b.removeprefix(NAME), _length("--distance", given))
            for a, b, given in args.distance
        ],
        "person_height": args.person_height,
        "camera_height": [
            (a.removeprefix(NAME), _length("--camera-height", given)) for a, given in args.camera_height
        ],
    }


def _length(option: str, text: str) -> float | tuple[float, float]:
    """Read the length among the words of an option of which the others are names."""
    try:
        return length(text)
    except argparse.ArgumentTypeError as error:
        from ..errors import EpibarError

        raise EpibarError(f"{option}: {error}") from error
