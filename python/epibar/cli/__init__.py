"""The command line: ``epibar calibrate``, ``epibar record``, ``epibar evaluate``, ``epibar demo``.

Exit codes: 0 the work was done (a refused pair is a result, not a failure), 2 unusable input, 130
interrupted. Nothing heavy is imported before the arguments are understood, so ``--help`` is instant.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from .interrupt import INTERRUPTED, prompt_interrupt
from .parser import build_parser

__all__ = ["main"]

BAD_INPUT = 2


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
        return stop.code if isinstance(stop.code, int) else BAD_INPUT
    try:
        with prompt_interrupt():
            code: int = import_module(f".{args.command}", __name__).run(args)
            sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("\nepibar: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output, e.g. `head`, has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # what the system says of a file: it may be in a folder that is not ours to read
        if error.filename is None:
            raise
        print(f"epibar: error: {error.filename}: {error.strerror}", file=sys.stderr)
        return BAD_INPUT
    except Exception as error:
        from ..errors import EpibarError

        if not isinstance(error, EpibarError):
            raise
        print(f"epibar: error: {error}", file=sys.stderr)
        return BAD_INPUT
