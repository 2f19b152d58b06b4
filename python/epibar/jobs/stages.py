"""The stages of a job, and what one of its tasks is about."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import EpibarError
from .inputs import CameraInput, CameraPair
from .shares import PairShare, joining_share

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
    of : CameraInput, CameraPair or str
    rounds : int
        How often the search of a pair is gone through, see :class:`~epibar.jobs.shares.PairShare`.
    share : float
        That is done of its time, as far as what the task tells says.
    frames : int
        Of a camera that is being recorded, those that were taken.
    kept : object, optional
        What it returned, once that is kept for the next run.
    """

    of: CameraInput | CameraPair | str
    rounds: int = 1
    share: float = 0.0
    frames: int = 0
    kept: Any = None
    _search: PairShare = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._search = PairShare(self.rounds)

    @property
    def stage(self) -> str:
        """Which of :data:`STAGES` it is part of."""
        if isinstance(self.of, str):
            return self.of
        return RECORDING if isinstance(self.of, CameraInput) else MATCHING

    def progress(self, at: str, share: float) -> None:
        """Note how far the task is; called in the thread that runs it."""
        if self.stage == RECORDING:
            self.frames, self.share = self.frames + 1, share
        elif self.stage == MATCHING:
            self.share = self._search.tell(at, share)
        else:
            self.share = joining_share(share) if self.stage == NETWORK else share
