"""The stages of a job, and what one of its tasks is about."""

from __future__ import annotations

from dataclasses import dataclass

from .inputs import CameraInput, Pair

__all__ = ["CLOCKS", "MATCHING", "NETWORK", "RECORDING", "STAGES", "Task"]

RECORDING, CLOCKS, MATCHING, NETWORK = STAGES = ("recording", "clocks", "matching", "network")


@dataclass(eq=False)
class Task:
    """What one future stands for: a camera, a pair, or a stage of all cameras."""

    of: CameraInput | Pair | str
    share: float = 0.0

    @property
    def stage(self) -> str:
        """Which of :data:`STAGES` it is part of."""
        if isinstance(self.of, str):
            return self.of
        return RECORDING if isinstance(self.of, CameraInput) else MATCHING

    def progress(self, _: str, share: float) -> None:
        """Note how far the task is; called in the thread that runs it."""
        self.share = share
