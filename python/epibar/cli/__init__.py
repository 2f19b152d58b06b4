"""The command line, ``epibar COMMAND``: one file a command.

Nothing heavy is imported before the arguments are understood, so ``--help`` is instant.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from ..errors import EpibarError, printable, without_secrets
from .exit_codes import BUG, DONE, INTERRUPTED, UNUSABLE
from .interrupt import prompt_interrupt
from .parser import build_parser

__all__ = ["main", "run_process"]


def run_process() -> NoReturn:
    """Run the command of this process and end it, without waiting for threads whose result nobody takes."""
    code = main()
    if code == INTERRUPTED:  # every line that was printed is flushed
        os._exit(code)
    sys.exit(code)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process by default.

    Returns
    -------
    int
        Exit code.
    """
    try:
        args = build_parser().parse_args(argv)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else UNUSABLE
    try:
        with prompt_interrupt():
            code: int = args.run(args)
            sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("\nepibar: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output, e.g. `head`, has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:  # what the system says of a file: it may be in a folder that is not ours to read
        if error.filename is None:
            raise
        _print_error(f"{error.filename}: {error.strerror}")
        return UNUSABLE
    except EpibarError as error:
        _print_error(str(error))
        return UNUSABLE
    except Exception as error:
        if str(error) == without_secrets(str(error)):
            raise
        import traceback

        print(without_secrets(traceback.format_exc()), file=sys.stderr)
        return BUG


def _print_error(text: str) -> None:
    print(f"epibar: error: {printable(without_secrets(text))}", file=sys.stderr)
