"""Which frames of a camera pictures are taken of, while nobody knows yet which moments others will show.

A report shows both cameras of a pair at one moment, and by how much one was started later than the other is
found long after the frames have gone. So pictures are taken as a vernier reads a length: of one frame every
``step`` seconds, and of every frame during a few *runs* of that length. Whatever the offset of two cameras,
some sparse frame of the one falls into each run of the other, and both pictures of that moment are there.
Runs begin where most moves. The step is a power of two, counted from the first frame, so that cameras that
were started together have all their sparse frames in common.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from ..arguments import Image, Mask
from .pictures import Pictures, jpeg_within
from .quiet_opencv import opencv

__all__ = ["MOST", "PicturePlan", "PictureTaker"]

MOST = 320
"""Pictures of a camera, as planned; half as many again where a source is longer than it said."""
RUNS = 6
"""Of consecutive frames: two cameras then show at least twice as many moments together."""
LONGEST_SIDE = 640
BUDGET = 48_000
"""Bytes of a picture; those of usual footage have half of that."""
UNKNOWN_SECONDS = 60.0
"""Taken for the length of a source that announces none."""


@dataclass(frozen=True)
class PicturePlan:
    """How pictures are spread.

    Attributes
    ----------
    step : float
        Seconds from one sparse frame to the next.
    run : float
        Seconds of a run; as long as the step, unless the pictures would be too many.
    runs : int
        How many there are, one in each of as many equal parts.
    part : float
        Seconds of a part.
    """

    step: float
    run: float
    runs: int
    part: float

    @classmethod
    def of(cls, seconds: float | None, fps: float) -> PicturePlan:
        """Plan for a length and a frame rate: as many runs as pictures allow, at the step with the fewest."""
        seconds = seconds or UNKNOWN_SECONDS
        for runs in range(RUNS, 0, -1):
            step = _power_of_two(math.sqrt(seconds / (runs * fps)))
            if runs * step * fps + seconds / step <= MOST:
                return cls(step, step, runs, seconds / runs)
        step = _power_of_two(2 * seconds / MOST)
        return cls(step, min(step, MOST / 2 / fps), 1, seconds)


def _power_of_two(seconds: float) -> float:
    return 2.0 ** round(math.log2(seconds))


@dataclass
class _Run:
    """Consecutive frames from one that moves so much."""

    motion: int
    until: float
    jpegs: dict[int, bytes] = field(default_factory=dict)


class PictureTaker:
    """Takes pictures of some of the frames it is shown.

    Parameters
    ----------
    frames : int or None
        How many are expected.
    fps : float
        Frames per second.
    """

    def __init__(self, frames: int | None, fps: float) -> None:
        self._plan = PicturePlan.of(frames / fps if frames else None, fps)
        self._early = 0.25 / fps
        self._sparse: dict[int, tuple[int, bytes]] = {}
        self._runs: dict[int, _Run] = {}
        self._running: tuple[int, _Run] | None = None
        self._step = self._plan.step
        self._last = -1

    def look(self, index: int, time: float, mask: Mask, image: Callable[[], Image]) -> None:
        """Look at the next frame.

        Parameters
        ----------
        index : int
            Its number.
        time : float
            Its seconds since frame 0.
        mask : ndarray, shape (H, W), uint8
            Non-zero where something moves.
        image : callable
            Returns it, (H, W, 3) uint8 BGR; called where a picture is taken.
        """
        if self._running is not None and time > self._running[1].until:
            self._end_run()
        # Rounded time stamps may be a little early.
        place = math.floor((time + self._early) / self._step)
        sparse, self._last = place > self._last, place
        if sparse and self._running is None:
            self._begin_run(time, opencv().countNonZero(mask))
        if not sparse and self._running is None:
            return
        jpeg = jpeg_within(image(), BUDGET, LONGEST_SIDE)
        if sparse:
            self._sparse[place] = index, jpeg
            if len(self._sparse) > MOST:
                self._thin_out()
        if self._running is not None:
            self._running[1].jpegs[index] = jpeg

    def pictures(self) -> Pictures:
        """Return those of all frames so far."""
        if self._running is not None and self._running[0] not in self._runs:
            self._end_run()  # one that the end cut short is better than none
        found = dict(self._sparse.values())
        for run in self._runs.values():
            found |= run.jpegs
        return Pictures(found)

    def _begin_run(self, time: float, motion: int) -> None:
        """Begin a run where more moves than where the one of this part began."""
        part = min(int(time / self._plan.part), self._plan.runs - 1)
        known = self._runs.get(part)
        if motion and (known is None or motion > known.motion):
            self._running = part, _Run(motion, time + self._plan.run)

    def _end_run(self) -> None:
        """Put a whole run in the place of the one before."""
        if self._running is not None:
            part, run = self._running
            self._runs[part] = run
            self._running = None

    def _thin_out(self) -> None:
        """Keep every second sparse frame, of a source that is longer than it said."""
        self._step *= 2
        self._last //= 2
        self._sparse = {place // 2: kept for place, kept in self._sparse.items() if place % 2 == 0}
