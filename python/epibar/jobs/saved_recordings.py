"""Recordings that were saved, given in place of videos."""

from __future__ import annotations

import numpy as np

from ..clocks import frame_interval
from ..errors import EpibarError
from ..lens.intrinsics import Intrinsics
from ..recording import DEFAULT_LINES, Recording
from ..sources.frame_range import FrameRange
from .inputs import CameraInput, RecordOptions

__all__ = ["load_saved"]

SAME = 1e-9
"""By how much two camera matrices or lenses may differ and be one, of each number."""


def load_saved(camera: CameraInput, options: RecordOptions) -> Recording:
    """Load a saved recording.

    That it is shorter than what is asked for is told in its warnings, and what can no longer be done to it: a
    background, an ignore mask, a foreground or a number of lines other than the default. So is that its
    distortion is taken on trust, where an older version saved it: then it knows its camera matrix and no
    coefficients.

    Raises
    ------
    EpibarError
        It cannot be read, is of other frames than are asked for, or of another camera matrix or lens than the
        intrinsics say, or of none though the lens bends lines.
    """
    recording = Recording.load(camera.source)
    _check_frames(recording, camera.source, options)
    _tell_of_shorter(recording, camera.source, options.frames)
    if camera.intrinsics is not None:
        _check_lens(recording, camera.source, camera.intrinsics)
        if camera.intrinsics.distorted and recording.lens is None:
            recording.warnings.append(
                f"{camera.source}: recorded already, so its distortion is taken to be that of the intrinsics"
            )
        recording.matrix, recording.lens = camera.intrinsics.matrix, camera.intrinsics
    given = {"background": camera.background, "ignore mask": camera.ignore}
    vain = [what for what, path in given.items() if path is not None]
    if options.foreground != RecordOptions().foreground:
        vain.append(f"foreground {options.foreground!r}")
    if vain:
        what = " and ".join(vain)
        recording.warnings.append(
            f"{camera.source}: recorded already, so its {what} cannot be applied; record the video again"
        )
    there = len(recording.segments)
    if options.lines not in (there, DEFAULT_LINES):
        recording.warnings.append(
            f"{camera.source}: recorded already, with {there} lines; "
            f"for {options.lines} record the video again"
        )
    return recording


def _check_frames(recording: Recording, source: str, options: RecordOptions) -> None:
    frames = options.frames
    first, last = recording.first_frame, recording.first_frame + recording.frames
    fits = frames.first == first and (frames.last is None or last <= frames.last)
    fits = fits and (frames.seconds is None or recording.times[-1] < frames.seconds)
    if frames != FrameRange() and not fits:
        raise EpibarError(
            f"{source}: frames {frames} asked for, but this is recorded already, from the frames "
            f"{first}:{last} of its video; record that again"
        )


def _tell_of_shorter(recording: Recording, source: str, frames: FrameRange) -> None:
    """Say that less is there than was asked for: a recording does not know whether its video goes on."""
    first, last = recording.first_frame, recording.first_frame + recording.frames
    too_few = frames.last is not None and last < frames.last
    too_short = (
        frames.seconds is not None and recording.times[-1] + frame_interval(recording) < frames.seconds
    )
    if too_few or (too_short and frames.last is None):
        asked = f"frames {frames}" if too_few else f"{frames.seconds:g} s"
        recording.warnings.append(
            f"{source}: {asked} asked for, but this is recorded already, from the frames {first}:{last} of "
            "its video; if that is longer, record it again"
        )


def _check_lens(recording: Recording, source: str, lens: Intrinsics) -> None:
    again = "record the video again with these intrinsics"
    lens.check_size(recording.size, source)
    if recording.matrix is None:
        if lens.distorted:
            raise EpibarError(
                f"{source}: recorded without intrinsics, so its lens still bends lines; {again}"
            )
    elif not np.allclose(recording.matrix, lens.matrix, rtol=SAME, atol=SAME):
        raise EpibarError(f"{source}: recorded with another camera matrix; {again}")
    elif recording.lens is not None and not _alike(recording.lens, lens):
        raise EpibarError(f"{source}: recorded with other distortions; {again}")


def _alike(one: Intrinsics, other: Intrinsics) -> bool:
    """Whether two lenses bend lines alike; coefficients that are left out are 0."""
    if not (one.distorted or other.distorted):
        return True
    a, b = (np.pad(lens.distortions, (0, 14 - len(lens.distortions))) for lens in (one, other))
    return one.fisheye == other.fisheye and np.allclose(a, b, rtol=SAME, atol=SAME)
