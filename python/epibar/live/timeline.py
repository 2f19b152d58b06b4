"""When each frame of a camera is, on the time line that all cameras of a run share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..arguments import Array
from ..calibration import Calibration
from ..clocks import clock_rate, frame_interval
from ..recording import Recording

__all__ = ["CameraClock", "camera_clocks"]


@dataclass(frozen=True, eq=False)
class CameraClock:
    """When each frame of a camera is, on the common time line.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Seconds since frame 0 of the first camera.
    step : float
        Seconds between frames of the first camera.
    """

    times: Array
    step: float

    def set(self, stream: Any, frame: int) -> None:
        """Make what is logged next belong to a frame."""
        seconds = float(self.times[frame])
        stream.set_time("time", duration=seconds)
        stream.set_time("frame", sequence=round(seconds / self.step))


def camera_clocks(
    recordings: Sequence[Recording], calibrations: Mapping[tuple[int, int], Calibration]
) -> list[CameraClock]:
    """Clock of each camera, through as few pairs as possible, accepted ones first.

    A camera that no pair leads to is taken to have started with the first.
    """
    step = frame_interval(recordings[0])
    # Of each camera its seconds for each second of the first camera's, and its time at that one's frame 0.
    found = {0: (1.0, 0.0)}
    for accepted in (True, False):
        pairs = {key: c for key, c in calibrations.items() if c.accepted or not accepted}
        for _ in recordings:
            reached = dict(found)
            for (i, j), calibration in pairs.items():
                rate = clock_rate(recordings[i], recordings[j], calibration.timing.frames_per_frame)
                start = calibration.time_offset * frame_interval(recordings[j])
                if i in reached:
                    of_i, at_i = reached[i]
                    found.setdefault(j, (rate * of_i, rate * at_i + start))
                if j in reached:
                    of_j, at_j = reached[j]
                    found.setdefault(i, (of_j / rate, (at_j - start) / rate))
    clocks = []
    for index, recording in enumerate(recordings):
        rate, start = found.get(index, (1.0, 0.0))
        clocks.append(CameraClock((recording.times - recording.times[:1] - start) / rate, step))
    return clocks
