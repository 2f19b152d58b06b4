"""When each camera was started, and what to keep of each video so that all begin and end together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _core
from ..arguments import Array, is_number
from ..clocks import frame_interval
from ..errors import EpibarError
from ..recording import Recording
from .parts import NetworkClock, NetworkParts
from .recordings import Recordings, named_recordings

__all__ = ["StartTime", "start_times"]

LONGEST_OFFSET = 1e8
"""Seconds, three years: no two videos of one scene are further apart."""

MOST_DRIFT = _core.MOST_DRIFT
"""Parts per million. No clock is wrong by a tenth."""


@dataclass(frozen=True)
class StartTime:
    """When a camera was started, and what to keep of its video.

    Attributes
    ----------
    offset : float
        Seconds: what is at t in the first camera is at ``t + offset + 1e-6 drift t`` in this one, each since
        the first frame that was recorded of it.
    offset_frames : float
        The same in frames of this camera.
    drift : float
        Parts per million.
    error : float or None
        Standard error of the offset, seconds.
    fps : float
        Frames per second.
    first_frame : int
        The frame, numbered from 0 in the video, nearest to the moment at which the last camera starts.
    first_second : float
        Its time in the video.
    last_frame : int or None
        The one nearest to the moment at which the first camera stops; None where lengths are not known.
    last_second : float or None
        Its time in the video.
    """

    offset: float
    offset_frames: float
    drift: float
    error: float | None
    fps: float
    first_frame: int
    first_second: float
    last_frame: int | None = None
    last_second: float | None = None


@dataclass(frozen=True)
class _Film:
    """The frames of one camera by its own clock; without ``times`` of unknown length."""

    fps: float
    skipped: int
    """Frames of the video before the first that was recorded."""
    times: Array | None = None

    def frame(self, seconds: float) -> tuple[int, float]:
        """Return the number of the frame nearest to some seconds, and its time, both in the video."""
        if self.times is None:
            index = max(round(seconds * self.fps), 0)
            own = index / self.fps
        else:
            index = int(np.abs(self.times - seconds).argmin())
            own = float(self.times[index])
        return self.skipped + index, self.skipped / self.fps + own


def start_times(network: NetworkParts, recordings: Recordings | Mapping[str, float]) -> dict[str, StartTime]:
    """Tell what to keep of each video; see :meth:`epibar.Network.start_times`."""
    films = _films(recordings)
    network.refuse_unknown(films)
    names = [name for name, camera in network.cameras.items() if camera.accepted and name in films]
    clocks = {name: network.clocks[name] for name in names if network.clocks[name].offset is not None}
    for name, clock in clocks.items():
        if abs(clock.offset or 0.0) > LONGEST_OFFSET or abs(clock.drift or 0.0) > MOST_DRIFT:
            raise EpibarError(f"{name}: no clock runs as {clock} says; calibrate again")
    if len(clocks) < 2:
        raise EpibarError(
            "start times are those of accepted cameras against each other: two are needed, and there are "
            f"{len(clocks)}"
        )
    start = max(clock.time_of(0.0) for clock in clocks.values())
    end = None
    if all(films[name].times is not None for name in clocks):
        ends = {name: clock.time_of(_length(films[name])) for name, clock in clocks.items()}
        end = min(ends.values())
        if end <= start:
            stops = min(ends, key=lambda name: ends[name])
            begins = max(clocks, key=lambda name: clocks[name].time_of(0.0))
            raise EpibarError(
                f"no moment is common to all cameras: {stops} stops {start - end:.1f} s before {begins} "
                "starts"
            )
    return {name: _start_time(films[name], clock, start, end) for name, clock in clocks.items()}


def _start_time(film: _Film, clock: NetworkClock, start: float, end: float | None) -> StartTime:
    assert clock.offset is not None
    first = film.frame(clock.at(start))
    last = (None, None) if end is None else film.frame(clock.at(end))
    return StartTime(
        clock.offset,
        clock.offset * film.fps,
        clock.drift or 0.0,
        clock.offset_error,
        film.fps,
        *first,
        *last,
    )


def _length(film: _Film) -> float:
    assert film.times is not None
    return float(film.times[-1])


def _films(given: Any) -> dict[str, _Film]:
    if isinstance(given, Mapping) and given and not any(isinstance(one, Recording) for one in given.values()):
        for name, fps in given.items():
            if not (is_number(fps) and fps > 0):
                raise EpibarError(f"{name}: {fps!r} is neither a recording nor positive frames per second")
        return {str(name): _Film(float(fps), 0) for name, fps in given.items()}
    return {
        name: _Film(1 / frame_interval(one), one.first_frame, np.asarray(one.times) - one.times[0])
        for name, one in named_recordings(given).items()
    }
