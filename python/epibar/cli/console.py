"""What the user sees: bars where somebody watches, lines where a log is written, nothing when asked."""

from __future__ import annotations

import logging
import platform
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from typing import IO

from ..calibration import Calibration
from ..errors import printable, without_secrets
from ..jobs.pace import EARLIEST, JobProgress
from ..jobs.showing import Bars, in_notebook, on_terminal
from ..jobs.watch import Watch
from ..network.check_prose import check_notes, check_table
from ..network.checking import NetworkCheck
from ..network.prose import network_notes, network_table
from ..network.result import Network

__all__ = ["Console"]

SMALL = 0.02
"""Share of a step before which nothing is said of the time left."""


class Console(Watch):
    """Progress, notes and results. Its bars are taken away when it is left as a context manager.

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
        self._bars = Bars()
        self._step, self._began = "", 0.0
        if self.verbose:
            self.note(_versions())

    def __enter__(self) -> Console:
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.close()

    @contextmanager
    def warnings(self) -> Iterator[None]:
        """Print what the package logs as a warning, as one of ours."""
        logger, handler = logging.getLogger("epibar"), _Warnings(self)
        propagate = logger.propagate
        logger.addHandler(handler)
        logger.propagate = False
        try:
            yield
        finally:
            logger.removeHandler(handler)
            logger.propagate = propagate

    @property
    def interactive(self) -> bool:
        """Somebody watches a terminal, or a notebook, and has not asked for silence."""
        return not self.quiet and (on_terminal() or in_notebook())

    def result(self, text: str = "") -> None:
        """Print what the user asked for, on stdout."""
        if not self.quiet:
            self._print(text, sys.stderr if self._stdout_is_taken else sys.stdout)

    def verdict(self, text: str) -> None:
        """Print what came out of a pair."""
        self.result(text)

    def calibrated(self, a: str, b: str, calibration: Calibration, seconds: float | None) -> None:
        """Print the verdict on a pair, and with ``verbose`` what it rests on."""
        super().calibrated(a, b, calibration, seconds)
        self.numbers("counts", calibration.counts)
        self.numbers("evidence", calibration.evidence)

    def joined(self, network: Network | None, reason: str | None) -> None:
        """Print the cameras of the network, and what is wrong with which."""
        if network is None:
            self.note(f"no network of cameras: {reason}")
            return
        self.result()
        for line in network_table(network):
            self.result(line)
        self.result(f"network: {network.reason}")
        for text in network_notes(network):
            self.note(text)
        for name, camera in network.cameras.items():
            self.numbers(f"evidence of {name}", camera.evidence)

    def checked(self, check: NetworkCheck, network: Network) -> None:
        """Print which cameras have moved, and why it is thought so."""
        for line in check_table(check):
            self.result(line)
        self.result(f"check: {check.reason}")
        for text in check_notes(check, network):
            self.note(text)
        said = {name: one.deviate for name, one in check.cameras.items() if one.deviate is not None}
        self.numbers("what speaks for a change, normal deviates", said)

    def numbers(self, of_what: str, found: Mapping[str, float]) -> None:
        """Print numbers by their name, where the user asked for much."""
        if self.verbose and found:
            self.note(f"  {of_what}: " + ", ".join(f"{name} {value:.6g}" for name, value in found.items()))

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

    def pace(self, progress: JobProgress) -> None:
        """Show how far all is: bars where somebody watches, else a line now and then."""
        if self.interactive:
            self._bars.show(progress)
        else:
            super().pace(progress)

    def step(self, what: str, done: float, total: int = 1) -> None:
        """Show how far something is that is no job, of which one part takes as long as another."""
        if what != self._step:
            self._step, self._began = what, time.monotonic()
        share, passed = min(done / total, 1.0), time.monotonic() - self._began
        known = share > SMALL and passed > EARLIEST
        self.pace(JobProgress(share, passed * (1.0 - share) / share if known else None, what))

    def _print(self, text: str, stream: IO[str]) -> None:
        """Print a line above the bars."""
        self._bars.write(printable(without_secrets(text)), stream)


def _versions() -> str:
    """Versions of what results depend on."""
    found = {"python": platform.python_version(), "system": platform.platform()}
    for package in ("epibar", "numpy", "opencv-python-headless"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return ", ".join(f"{name} {number}" for name, number in found.items())


class _Warnings(logging.Handler):
    """Hands on what is logged."""

    def __init__(self, console: Console) -> None:
        super().__init__(logging.WARNING)
        self._console = console

    def emit(self, record: logging.LogRecord) -> None:
        self._console.warning(record.getMessage())
