"""Results and notes as lines of text, for commands that show no progress too. Standard library only."""

from __future__ import annotations

import sys
from typing import IO

from ..errors import printable, without_secrets

__all__ = ["Printer"]


class Printer:
    """Results and notes.

    Parameters
    ----------
    quiet : bool
        Errors only.
    json : bool
        Stdout is for the JSON result alone: what would be printed there goes to stderr.
    verbose : bool
        Also versions, and the numbers that results rest on, on stderr.
    """

    def __init__(self, quiet: bool = False, json: bool = False, verbose: bool = False) -> None:
        self.quiet = quiet
        self.verbose = verbose and not quiet
        self._stdout_is_taken = json
        if self.verbose:
            self.note(_versions())

    def result(self, text: str = "") -> None:
        """Print what the user asked for, on stdout."""
        if not self.quiet:
            self._print(text, sys.stderr if self._stdout_is_taken else sys.stdout)

    def json(self, text: str) -> None:
        """Print a JSON result, on stdout, however quiet."""
        print(text, flush=True)

    def note(self, text: str) -> None:
        """Print what is going on, on stderr."""
        if not self.quiet:
            self._print(text, sys.stderr)

    def warning(self, text: str) -> None:
        """Print what may spoil the result, on stderr."""
        self.note(f"epibar: warning: {text}")

    def error(self, text: str) -> None:
        """Print what went wrong, on stderr, always."""
        self._print(f"epibar: error: {text}", sys.stderr)

    def _print(self, text: str, stream: IO[str]) -> None:
        """Print a line."""
        print(printable(without_secrets(text)), file=stream, flush=True)


def _versions() -> str:
    """Versions of what results depend on."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version(), "system": platform.platform()}
    for package in ("epibar", "numpy", "opencv-python-headless"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return ", ".join(f"{name} {number}" for name, number in found.items())
