"""Options of when cameras were started, which ``calibrate`` and ``check`` have in common."""

from __future__ import annotations

import argparse

from .options import seconds, time_offset

__all__ = ["add_clock_options"]


def add_clock_options(group: argparse._ArgumentGroup, metavar: str, purpose: str, wider: str = "") -> None:
    """Add ``--time-offset`` and ``--search-seconds``; ``wider`` says what a longer search costs."""
    group.add_argument("--time-offset", type=time_offset, default="auto", metavar=metavar, help=purpose)
    group.add_argument(
        "--search-seconds",
        type=seconds,
        default=21.0,
        metavar="S",
        help="how far either way a time offset is looked for: raise it for cameras started further apart"
        f"{wider} (default: %(default)g)",
    )
