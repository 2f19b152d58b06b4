"""What a job tells while it runs. By default to the logger ``epibar``; the command line has its own."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import closing, contextmanager

from ..calibration import Calibration
from ..network.result import Network
from ..recording import Recording
from .pace import JobProgress
from .showing import Bars, LogLines, in_notebook, on_terminal

__all__ = ["Watch", "default_watch", "summary"]

logger = logging.getLogger("epibar")


class Watch:
    """Told what happens in a job. Override what is of interest; the caller's thread calls every method."""

    _lines: LogLines | None = None

    def note(self, text: str) -> None:
        """Take what is going on."""
        logger.info(text)

    def warning(self, text: str) -> None:
        """Take what may spoil a result."""
        logger.warning(text)

    def error(self, text: str) -> None:
        """Take why a camera or a pair could not be done."""
        logger.error(text)

    def verdict(self, text: str) -> None:
        """Take what came out of a pair, in one line."""
        logger.info(text)

    def calibrated(self, a: str, b: str, calibration: Calibration, seconds: float | None) -> None:
        """Take a calibration and the seconds it took, None where it was kept from an earlier run."""
        time = "kept" if seconds is None else f"{seconds:.1f} s"
        self.verdict(f"{a} - {b}: {summary(calibration)} ({time})")

    def joined(self, network: Network | None, reason: str | None) -> None:
        """Take the network of all cameras; or None, and why there is none."""
        self.verdict(f"network: {reason if network is None else network.reason}")

    def progress(self, stage: str, done: float, total: int) -> None:
        """Take how many of a stage's tasks are done, fractions included; called several times a second."""

    def pace(self, progress: JobProgress) -> None:
        """Take how far the whole job is, several times a second; here a note of it each half a minute."""
        if self._lines is None:
            self._lines = LogLines()
        line = self._lines.due(progress)
        if line is not None:
            self.note(line)

    def recorded(self, name: str, recording: Recording, seconds: float | None) -> None:
        """Take a recording and the seconds it took, None where it was kept from an earlier run."""
        for warning in recording.warnings:
            self.warning(warning if name in warning else f"{name}: {warning}")
        if seconds is not None:
            self.note(
                f"{name}: {recording.frames} frames of {recording.width}x{recording.height}, "
                f"{recording.informative} of {len(recording.segments)} lines informative ({seconds:.1f} s)"
            )


class _Shown(Watch):
    """Bars for who looks on, and the rest for the logger."""

    def __init__(self) -> None:
        self.bars = Bars()

    def pace(self, progress: JobProgress) -> None:
        """Show it."""
        self.bars.show(progress)

    def note(self, text: str) -> None:
        """Log what is going on, without a bar in the line."""
        with self.bars.aside():
            super().note(text)

    def warning(self, text: str) -> None:
        """Log what may spoil a result, likewise."""
        with self.bars.aside():
            super().warning(text)

    def error(self, text: str) -> None:
        """Log why a camera or a pair could not be done, likewise."""
        with self.bars.aside():
            super().error(text)

    def verdict(self, text: str) -> None:
        """Log what came out of a pair, likewise."""
        with self.bars.aside():
            super().verdict(text)


@contextmanager
def default_watch() -> Iterator[Watch]:
    """Watch of a job whose caller gave none; its bars go when this is left."""
    if not (on_terminal() or in_notebook()):
        yield Watch()
        return
    shown = _Shown()
    with closing(shown.bars):
        yield shown


def summary(calibration: Calibration) -> str:
    """Say in one line what came out of a pair."""
    verdict = "accepted" if calibration.accepted else f"refused ({calibration.kind})"
    offset = f", time offset {calibration.time_offset:+.2f} frames" if calibration.time_offset else ""
    return f"{verdict}{offset}. {calibration.reason}"
