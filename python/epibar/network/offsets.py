"""One offset for the clock of each camera: given, or found from the motion barcodes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from .. import _core
from ..arguments import as_positive, core_errors, is_number
from ..clocks import frame_interval
from ..errors import EpibarError
from ..recording import Recording
from .recordings import Recordings, films_of

__all__ = ["ClockOffsets", "as_offsets", "find_offsets", "given_offsets"]

GRID = _core.GRID
"""Seconds. A search starts from a found offset rounded to this, which it sharpens anyway: so the same search
is known again though one more camera moved all offsets by a millisecond."""

TimeOffset = float | Literal["auto", "search"] | Mapping[str, float]


@dataclass(frozen=True)
class ClockOffsets:
    """What is known of the clocks before the geometry is.

    Attributes
    ----------
    seconds : tuple of float
        For each camera: what is at t in the first camera is at t + seconds in this one, both since their own
        first frame. NaN where nothing tells.
    together : bool
        It was found that all started together.
    given : bool
        They were given, and are not solved for.
    """

    seconds: tuple[float, ...]
    together: bool = False
    given: bool = False

    def to_core(self) -> tuple[list[float], bool, bool]:
        """Return it as the compiled module takes it."""
        return list(self.seconds), self.together, self.given

    def between(self, recordings: Sequence[Recording], a: int, b: int) -> float | None:
        """Where A's first frame falls in B, frames of B, to start a search from; None where nothing tells."""
        seconds = self.seconds[b] - self.seconds[a]
        if not math.isfinite(seconds):
            return None
        if self.sharpen:
            seconds = round(seconds / GRID) * GRID
        return seconds / frame_interval(recordings[b])

    @property
    def sharpen(self) -> bool:
        """Whether a pair's search is to sharpen its offset: it is known to a frame or two only."""
        return not (self.given or self.together)


def as_offsets(value: Any, cameras: int) -> ClockOffsets:
    """Return ``value``, the argument ``offsets``, if it is of so many cameras."""
    if not isinstance(value, ClockOffsets):
        raise EpibarError(
            f"offsets is a {type(value).__name__}, expected ClockOffsets, e.g. from "
            "epibar.network.find_offsets"
        )
    if len(value.seconds) != cameras:
        raise EpibarError(f"{len(value.seconds)} clocks for {cameras} cameras")
    return value


def given_offsets(names: Sequence[str], time_offset: Any) -> ClockOffsets | None:
    """Take offsets that are given, in seconds; None where they are to be found.

    Raises
    ------
    EpibarError
        Not a number, not for these cameras.
    """
    if isinstance(time_offset, str):
        if time_offset in ("auto", "search"):
            return None
    elif isinstance(time_offset, Mapping):
        unknown = [str(name) for name in time_offset if name not in names]
        missing = [name for name in names if name not in time_offset]
        if unknown or missing:
            what = f"has no camera {', '.join(missing)}" if missing else f"names {', '.join(unknown)}"
            raise EpibarError(f"time_offset {what}; the cameras are {', '.join(names)}")
        for name in names:
            if not is_number(time_offset[name]):
                raise EpibarError(f"time_offset[{name!r}] = {time_offset[name]!r}: expected finite seconds")
        first = float(time_offset[names[0]])
        return ClockOffsets(tuple(float(time_offset[name]) - first for name in names), given=True)
    elif is_number(time_offset):
        if time_offset != 0 and len(names) != 2:
            raise EpibarError(
                f"time_offset = {time_offset} with {len(names)} cameras does not say whose it is; give "
                "seconds by camera, or 'auto'"
            )
        return ClockOffsets((0.0,) + (float(time_offset),) * (len(names) - 1), given=True)
    raise EpibarError(f"time_offset = {time_offset!r}: expected 'auto', finite seconds, or seconds by camera")


def find_offsets(
    recordings: Recordings,
    search_seconds: float,
    progress: Callable[[str, float], None] | None = None,
) -> ClockOffsets:
    """Find the offsets of all clocks from the motion barcodes, and whether all started together.

    Parameters
    ----------
    recordings : mapping of str to Recording, or sequence of Recording
    search_seconds : float
        How far either way to look.
    progress : callable, optional
        Called with the name of the stage and the share of it that is done.

    Returns
    -------
    ClockOffsets

    Raises
    ------
    EpibarError
        An argument is of the wrong kind or out of its range.
    """
    films = films_of(recordings)
    reach = as_positive("search_seconds", search_seconds, "seconds")
    with core_errors():
        seconds, together, given = _core.clock_offsets([one._core for one in films], reach, progress)
    return ClockOffsets(tuple(seconds), together, given)
