"""The parser of all commands. Standard library only: this is what ``--help`` waits for."""

from __future__ import annotations

import argparse

from . import (
    calibrate,
    check,
    completion,
    demo,
    evaluate,
    export,
    formats,
    inspect,
    record,
    scale,
    sync,
)
from .exit_codes import explanation
from .options import CommandParser

__all__ = ["build_parser"]

COMMANDS = (calibrate, record, inspect, scale, sync, check, evaluate, export, formats, demo, completion)
"""A command is a module with a name, its help, its options, and what it runs."""


def build_parser() -> argparse.ArgumentParser:
    """Make the parser of the command line; ``run`` of what it returns is the command's function."""
    parser = CommandParser(
        prog="epibar",
        description="Epipolar geometry of stationary cameras from what moves in front of them.",
        epilog=explanation(
            partly="one of several inputs could not be done, the others are",
            moved="'check' alone: a camera has moved",
        ),
    )
    parser.add_argument("--version", action=_Version)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in COMMANDS:
        command = commands.add_parser(module.NAME, help=module.HELP, description=module.DESCRIPTION)
        module.add_options(command)
        command.set_defaults(run=module.run, whole=parser)
    return parser


class _Version(argparse.Action):
    """``--version``, which looks the version up only when asked."""

    def __init__(self, option_strings: list[str], dest: str, **_: object) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, nargs=0, help="show the version and exit")

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"epibar {version('epibar')}")
        parser.exit()
