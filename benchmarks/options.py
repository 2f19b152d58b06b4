"""Options of the measuring programs: what each reads, and those that several have."""

from __future__ import annotations

import os
from argparse import ArgumentParser, ArgumentTypeError
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal

Method = Literal["frontier", "lines"]
METHODS: dict[str, tuple[Method, ...]] = {
    "frontier": ("frontier",),
    "lines": ("lines",),
    "both": ("lines", "frontier"),
}

NETWORKS = (
    *("network", "network_plain", "network_off_centre", "network_fisheye", "network_large"),
    *("network_stranger", "network_reversed", "network_shifted", "network_knocked", "network_split"),
    *("network_false_pair", "network_unrelated", "network_no_baseline", "network_one_path"),
    *("network_one_path_strays", "network_one_plane", "network_pure_floor", "network_one_mover_standing"),
)
"""Families of made-up networks of unknown cameras."""


def numbers(text: str) -> list[int]:
    """Read ``1-5``, ``1,4,7`` or a mixture as a list of whole numbers."""
    found: list[int] = []
    try:
        for part in text.split(","):
            low, _, high = part.partition("-")
            found += range(int(low), int(high or low) + 1)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: expected numbers such as 1-5 or 1,4,7") from None
    if not found:
        raise ArgumentTypeError(f"{text!r}: no number in it")
    return found


def names_of(known: Iterable[str]) -> Callable[[str], list[str]]:
    """Make a reader of a list of names, each of which must be known."""
    allowed = list(known)

    def read(text: str) -> list[str]:
        found = [name.strip() for name in text.split(",") if name.strip()]
        for name in found:
            if name not in allowed:
                raise ArgumentTypeError(f"{name!r}: choose from {', '.join(allowed)}")
        if not found:
            raise ArgumentTypeError(f"{text!r}: no name in it; choose from {', '.join(allowed)}")
        return found

    return read


def natural(text: str) -> int:
    """Read a whole number of at least 1."""
    if not text.isdigit() or int(text) < 1:
        raise ArgumentTypeError(f"{text!r}: expected a whole number of at least 1")
    return int(text)


def add_common(parser: ArgumentParser, lines: int) -> None:
    """Add the options that every program has."""
    parser.add_argument(
        "--lines", type=natural, default=lines, help="random lines per camera (default %(default)s)"
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="write every outcome and the summary there too"
    )
    parser.add_argument("--verbose", action="store_true", help="print every pair as it is done")


def add_names(
    parser: ArgumentParser, option: str, known: Iterable[str], default: list[str] | None = None, how: str = ""
) -> None:
    """Add an option that takes some of the known names, all by default."""
    names = list(known)
    parser.add_argument(
        option, type=names_of(names), default=default or names, help=f"{how}some of: " + ",".join(names)
    )


def add_seeds(parser: ArgumentParser, last: int) -> None:
    """Add ``--seeds``, by default from 1 to the last."""
    seeds = list(range(1, last + 1))
    default = "1" if last == 1 else f"1-{last}"
    parser.add_argument(
        "--seeds", type=numbers, default=seeds, help=f"such as 1,4 or 1-5 (default {default})"
    )


def add_frames(parser: ArgumentParser, default: int, of: str = "per camera") -> None:
    """Add ``--frames``."""
    parser.add_argument("--frames", type=natural, default=default, help=f"{of} (default %(default)s)")


def add_first_pairs(parser: ArgumentParser) -> None:
    """Add ``--pairs``, for a trial."""
    parser.add_argument("--pairs", type=natural, help="only the first so many pairs of each scene and seed")


def add_method(parser: ArgumentParser) -> None:
    """Add ``--method``, which may be both."""
    parser.add_argument("--method", choices=METHODS, default="frontier", help="default: %(default)s")


def add_networks(parser: ArgumentParser, families: str, networks: int) -> None:
    """Add the options of programs that draw networks, as ``fresh_seeds.networks_asked_for`` reads them."""
    parser.add_argument(
        "--families", default=families, help="some of: " + ",".join(NETWORKS) + " (default %(default)s)"
    )
    parser.add_argument("--networks", type=natural, default=networks, help="of each (default %(default)s)")
    parser.add_argument("--seeds", type=numbers, help="such as 1-5: for a trial, instead of the commit's")
    parser.add_argument("--lines", type=natural, default=20_000, help="per camera (default %(default)s)")
    parser.add_argument("--workers", type=natural, default=os.cpu_count() or 1)
