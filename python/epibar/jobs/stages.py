"""The stages of a job, and what one of its tasks is about."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..errors import EpibarError
from .inputs import CameraInput, Pair

__all__ = ["CLOCKS", "MATCHING", "NETWORK", "RECORDING", "STAGES", "Stopped", "Task"]

RECORDING, CLOCKS, MATCHING, NETWORK = STAGES = ("recording", "clocks", "matching", "network")


class Stopped(EpibarError):
    """No task runs any more."""

    def __init__(self, error: Exception, out: Path) -> None:
        super().__init__(
            f"what runs the tasks has stopped ({str(error) or type(error).__name__}); what was finished is "
            f"kept in {out}, and the same run started again goes on from there"
        )


@dataclass(eq=False)
class Task:
    """What one future stands for: a camera, a pair, or a stage of all cameras.

    Attributes
    ----------
    of : CameraInput, Pair or str
    share : float
        That is done, as the task tells.
    kept : bool
        What it returned is kept for the next run.
    """

    of: CameraInput | Pair | str
    share: float = 0.0
    kept: bool = False

    @property
    def stage(self) -> str:
        """Which of :data:`STAGES` it is part of."""
        if isinstance(self.of, str):
            return self.of
        return RECORDING if isinstance(self.of, CameraInput) else MATCHING

    def progress(self, _: str, share: float) -> None:
        """Note how far the task is; called in the thread that runs it."""
        self.share = share
