"""Cameras whose offset is given, and a part of each from one frame on: one moment only at one frame rate."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import EpibarError
from .camera_sizes import frame_rate
from .inputs import CameraInput, RecordOptions

__all__ = ["refuse_first_frames"]

APART = 0.5
"""Frames of the faster camera by which the first frames used may be apart."""


def refuse_first_frames(cameras: Sequence[CameraInput], options: RecordOptions, time_offset: object) -> None:
    """Refuse an offset that is given of videos of several frame rates of which not all frames are used.

    An offset is that of the first frames used, and frame 100 is at other moments of videos of 25 and of 30
    frames a second.

    Raises
    ------
    EpibarError
        It is so of two of the cameras.
    """
    if options.frames.first == 0 or isinstance(time_offset, str):
        return
    announced = ((frame_rate(camera, options), camera.name) for camera in cameras)
    rates = sorted((rate, name) for rate, name in announced if rate is not None)
    begins = [options.frames.first / rate for rate, _ in rates]
    if begins and begins[0] - begins[-1] > APART / rates[-1][0]:
        late, early = (
            f"{begins[index]:.3f} s of {name} ({rate:g} frames a second)"
            for index, (rate, name) in ((0, rates[0]), (-1, rates[-1]))
        )
        raise EpibarError(
            f"--frames {options.frames} (frames=) begins at {late} and at {early}, so that a given "
            "--time-offset (time_offset=) does not say when these were filmed; use all frames, cut the "
            "videos at one moment, or let the offset be found: --time-offset search"
        )
