"""Seconds of each frame, by the stamps of a container as far as these make sense.

Stamps go back where files were joined, stand still where a writer had none, and leap where a camera paused.
What is certain is that frames follow one another: where a stamp makes no sense the step to it is taken to be
a usual one, and stamps count again as soon as they go on. A single one that comes too late looks like a
pause: frames after it are close to one another until their own stamps have caught up.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

__all__ = ["TimeStamps"]

LONGEST = 60.0
"""Seconds between two frames that are believed; ten frames where these are longer apart."""
USUAL = 15
"""Steps of which the median is the usual one."""
SOON = 3.0
"""Usual steps within which a frame follows."""
CATCHING_UP = 0.1
"""Share of the usual step by which time goes on until a stamp that came too early is passed."""


class TimeStamps:
    """Turn stamps into seconds, one frame after the other.

    Parameters
    ----------
    fps : float
        Frames per second where no stamps tell.
    first : float
        Stamp of the first frame, seconds; its time is 0.

    Attributes
    ----------
    time : float
        Seconds of the last frame.
    replaced : int
        Frames whose stamps made no sense.
    span : float
        Seconds by the stamps alone, pauses included that are too long to be believed.
    """

    def __init__(self, fps: float, first: float) -> None:
        self.time, self.replaced, self.span = 0.0, 0, 0.0
        self._interval = 1.0 / fps
        self._base = self._former = -first
        self._last = first
        self._before = 0.0
        self._steps: deque[float] = deque(maxlen=USUAL)

    @property
    def usual(self) -> float:
        """Seconds from one frame to the next, of late."""
        return median(self._steps) if self._steps else self._interval

    def go_on(self, seconds: float, stamp: float) -> None:
        """Let time pass without frames; the next one has this stamp."""
        self.time += seconds
        self._before = self.time
        self._base = self._former = self.time + self.usual - stamp

    def at(self, stamp: float) -> float:
        """Seconds of the next frame, by its stamp in seconds; later than those of the one before."""
        longest = max(LONGEST, 10 * self._interval)
        since = stamp - self._last
        if since > 0 and math.isfinite(since):
            self.span += since
        formerly = stamp + self._former - self.time
        if 0 < formerly < SOON * self.usual:
            self._base = self._former  # those that began anew were the ones that made no sense
        step = stamp + self._base - self.time
        if 0 < step < longest:
            self._before = self.time
            self._steps.append(step)
        elif since != 0 and self._before < stamp + self._base <= self.time:
            # A stamp before was too late, and this one is right.
            step = CATCHING_UP * self.usual
            self.replaced += 1
        else:
            follows = 0 < since < longest
            step = since if follows else self.usual
            self.replaced += not follows
            self._before = self.time
            if follows:
                # The stamps began anew with the frame before.
                self._former, self._base = self._base, self.time + step - stamp
        self.time += step
        if math.isfinite(stamp):
            self._last = stamp
        return self.time
