"""What a job tells while it runs. By default to the logger ``epibar``; the command line has its own."""

from __future__ import annotations

import logging

from ..calibration import Calibration
from ..network.result import Network
from ..recording import Recording

__all__ = ["Watch", "summary"]

logger = logging.getLogger("epibar")


class Watch:
    """Told what happens in a job. Override what is of interest; the caller's thread calls every method."""

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

    def recorded(self, name: str, recording: Recording, seconds: float | None) -> None:
        """Take a recording and the seconds it took, None where it was kept from an earlier run."""
        for warning in recording.warnings:
            self.warning(warning if name in warning else f"{name}: {warning}")
        if seconds is not None:
            self.note(
                f"{name}: {recording.frames} frames of {recording.width}x{recording.height}, "
                f"{recording.informative} of {len(recording.segments)} lines informative ({seconds:.1f} s)"
            )


def summary(calibration: Calibration) -> str:
    """Say in one line what came out of a pair."""
    verdict = "accepted" if calibration.accepted else f"refused ({calibration.kind})"
    offset = f", time offset {calibration.time_offset:+.2f} frames" if calibration.time_offset else ""
    return f"{verdict}{offset}. {calibration.reason}"
