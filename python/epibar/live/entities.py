"""What is logged of one camera and of one pair."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..calibration import Calibration
from ..errors import EpibarError
from ..geometry.lines import clip_lines
from ..geometry.vectors import homogeneous
from ..lens.intrinsics import Intrinsics
from ..lens.undistortion import Undistorter
from ..recording import Recording
from ..show.colours import RGB
from ..sources.colour_frames import ColourFrames
from ..sources.quiet_opencv import opencv
from .timeline import CameraClock

__all__ = ["log_frames", "log_pair", "log_silhouettes"]

COLOURS = np.array(RGB, np.uint8)
GREY = (200, 200, 200)
JPEG_QUALITY = 80
RADIUS = 4.0
"""Of a frontier point, pixels."""


def log_silhouettes(
    rerun: Any, stream: Any, name: str, recording: Recording, clock: CameraClock, every: int
) -> None:
    """Log the outlines of what moves."""
    for frame in range(0, recording.frames, every):
        clock.set(stream, frame)
        closed = [np.vstack([hull, hull[:1]]) for hull in recording.hulls(frame)]
        stream.log(
            rerun.new_entity_path([name, "silhouettes"]),
            rerun.LineStrips2D(closed, colors=[GREY] * len(closed)),
        )


def log_frames(
    rerun: Any,
    stream: Any,
    name: str,
    recording: Recording,
    video: str | os.PathLike[str],
    lens: Intrinsics | None,
    clock: CameraClock,
    every: int,
) -> None:
    """Log the frames of a camera's video, undistorted where its lens is known."""
    cv2 = opencv()
    with ColourFrames(video) as source:
        if source.size != recording.size:
            raise EpibarError(
                f"{os.fspath(video)}: {source.width}x{source.height} frames, but the recording {name!r} "
                f"has {recording.width}x{recording.height}"
            )
        straighten = Undistorter(lens, source.size, name).image if lens is not None else None
        for index, _, image in source:
            frame = index - recording.first_frame
            if frame >= recording.frames:
                break
            if frame < 0 or frame % every:
                continue
            shown = straighten(image) if straighten is not None else image
            data = cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1]
            clock.set(stream, frame)
            picture = rerun.EncodedImage(contents=data.tobytes(), media_type="image/jpeg", draw_order=-10.0)
            stream.log(rerun.new_entity_path([name, "image"]), picture)


def log_pair(
    rerun: Any,
    stream: Any,
    names: tuple[str, str],
    sizes: tuple[tuple[int, int], tuple[int, int]],
    calibration: Calibration,
    clock: CameraClock,
    every: int,
) -> None:
    """Log frontier points and the epipolar lines through them, in colours that are the same in both views."""
    assert calibration.F is not None
    points = calibration.frontier_points
    pixels = points.a, points.b
    lines = homogeneous(points.b) @ calibration.F, homogeneous(points.a) @ calibration.F.T
    for frame in range(0, len(clock.times), every):
        mine = np.flatnonzero(points.frame == frame)
        colours = COLOURS[np.arange(len(mine)) % len(COLOURS)]
        clock.set(stream, frame)
        for view, (name, other) in enumerate((names, names[::-1])):
            segments, hit = clip_lines(lines[view][mine], sizes[view])
            strips = rerun.LineStrips2D(segments[hit], colors=colours[hit])
            stream.log(rerun.new_entity_path([name, "lines", other]), strips)
            dots = rerun.Points2D(pixels[view][mine], colors=colours, radii=[RADIUS] * len(mine))
            stream.log(rerun.new_entity_path([name, "points", other]), dots)
