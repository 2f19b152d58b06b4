"""What the user sees: bars where somebody watches, lines where a log is written, nothing when asked."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
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
from .printer import Printer

__all__ = ["Console"]

SMALL = 0.02
"""Share of a step before which nothing is said of the time left."""


class Console(Printer, Watch):
    """Progress beside notes and results. Its bars are taken away when it is left as a context manager."""

    def __init__(self, quiet: bool = False, json: bool = False, verbose: bool = False) -> None:
        self._bars = Bars()
        self._step, self._began = "", 0.0
        super().__init__(quiet, json, verbose)

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


class _Warnings(logging.Handler):
    """Hands on what is logged."""

    def __init__(self, console: Console) -> None:
        super().__init__(logging.WARNING)
        self._console = console

    def emit(self, record: logging.LogRecord) -> None:
        self._console.warning(record.getMessage())
