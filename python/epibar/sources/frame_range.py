"""Which frames of a video to use."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import TypeVar

from ..arguments import as_positive
from ..errors import EpibarError

__all__ = ["FrameRange"]

T = TypeVar("T")


@dataclass(frozen=True)
class FrameRange:
    """The frames from ``first`` up to, but not including, ``last``; to the end where ``last`` is None.

    With ``seconds`` only those less than so long after the first of them.

    Raises
    ------
    EpibarError
        Not whole numbers, or no frame between them; no positive number of seconds.
    """

    first: int = 0
    last: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.seconds is not None:
            as_positive("seconds", self.seconds, "seconds")
        for number in (self.first, self.last):
            if number is not None and (isinstance(number, bool) or not isinstance(number, int)):
                raise EpibarError(f"frames {self}: {number!r} is not a whole number")
        if self.first < 0 or (self.last is not None and self.last <= self.first):
            raise EpibarError(
                f"frames {self}: no frame is in it; they count from 0, and the last is left out"
            )

    @classmethod
    def of(cls, ends: Sequence[int | None] | FrameRange | None, seconds: float | None = None) -> FrameRange:
        """Make a range of what a caller passed: (first, last), either of which may be None."""
        if isinstance(ends, FrameRange):
            return ends
        if ends is None:
            return cls(seconds=seconds)
        try:
            first, last = ends
        except (TypeError, ValueError):
            raise EpibarError(f"frames = {ends!r}: expected two numbers, (first, last)") from None
        return cls(0 if first is None else first, last, seconds)

    def __str__(self) -> str:
        return f"{self.first}:{'' if self.last is None else self.last}"

    def holds(self, number: int) -> bool:
        """Whether a frame at or after the first is used."""
        return self.last is None or number < self.last

    @property
    def has_end(self) -> bool:
        """Whether frames of a source that never ends come to an end."""
        return self.last is not None or self.seconds is not None

    def in_time(
        self, moments: Generator[tuple[int, float, T], None, None]
    ) -> Generator[tuple[int, float, T], None, None]:
        """Let moments (index, time, image) through that are not too late."""
        with closing(moments):
            for moment in moments:
                if self.seconds is not None and moment[1] >= self.seconds:
                    return
                yield moment

    def expected(self, count: int | None, fps: float) -> int | None:
        """How many of so many frames are in time, as far as the frame rate tells."""
        if count is None or self.seconds is None:
            return count
        return min(count, max(1, math.ceil(self.seconds * fps - 1e-6)))

    def count(self, path: str, total: int) -> int:
        """How many of the ``total`` frames of a file are used, however late they are.

        Raises
        ------
        EpibarError
            None is.
        """
        if self.first >= total:
            raise self.beyond(path, total)
        return (total if self.last is None else min(total, self.last)) - self.first

    def beyond(self, path: str, total: int | None = None) -> EpibarError:
        """The error that the file ends before the first frame."""
        found = "it ends before" if total is None else f"it has only {total} frames"
        return EpibarError(f"{path}: frames {self} asked for, but {found}")
