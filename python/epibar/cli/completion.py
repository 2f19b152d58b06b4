"""``epibar completion``: the script that lets a shell complete commands, options and file names."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator

from .exit_codes import DONE
from .options import CommandParser, add_output_options
from .printer import Printer

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "completion"
HELP = "print a script that lets your shell complete commands and options"
DESCRIPTION = (
    "Print a completion script. bash: epibar completion bash > "
    "~/.local/share/bash-completion/completions/epibar. zsh: epibar completion zsh > _epibar, in a folder of "
    "$fpath. tcsh: source it."
)

FOLDER = "DIR"
FILES = re.compile(r"VIDEO|PATH|\w+\.\w+")
"""What options call a file that they take: these words, and all with a suffix, such as FILE.toml."""


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.add_argument(
        "shell", choices=("bash", "zsh", "tcsh"), help="the one that is to complete what is typed"
    )
    add_output_options(command)


def run(args: argparse.Namespace) -> int:
    """Run the command."""
    from ..errors import EpibarError

    try:
        import shtab
    except ImportError as error:
        raise EpibarError(
            "shtab is missing, which writes the script: pip install 'epibar[completion]'"
        ) from error
    for action in _actions(args.whole):
        if takes_folder(action) or takes_file(action):
            kind = shtab.DIRECTORY if takes_folder(action) else shtab.FILE
            setattr(action, "complete", kind)  # noqa: B010 - shtab looks for it
    Printer(args.quiet, verbose=args.verbose)  # says versions where they are asked for
    print(shtab.complete(args.whole, args.shell), flush=True)
    return DONE


def takes_folder(action: argparse.Action) -> bool:
    """Whether an argument or option takes a folder."""
    return action.metavar == FOLDER


def takes_file(action: argparse.Action) -> bool:
    """Whether an argument or option takes a file, or a folder of images in the place of one."""
    return isinstance(action.metavar, str) and FILES.fullmatch(action.metavar) is not None


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Every argument and option of every command."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
        else:
            yield action
