"""The run on one time line in the Rerun viewer: frames, silhouettes, epipolar lines, frontier points.

>>> from epibar import live
>>> live.show([rec_a, rec_b], {(0, 1): cal}, videos=["cam1.mp4", "cam2.mp4"])  # doctest: +SKIP

Needs ``pip install 'epibar[live]'``. Below each camera's name there are ``image`` (where a video is given),
``silhouettes``, and for each other camera of its pairs ``points/<other>``, the frontier points, and
``lines/<other>``, the epipolar lines of the other view's points. One colour is one point in both views. The
time line counts seconds (``time``) or frames (``frame``) of the first camera, by the pairs' clocks: time
offset, frame rates and drift.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arguments import as_whole_number, camera_names, check_pairs
from .calibration import Calibration
from .clocks import clock_rate, frame_interval
from .errors import EpibarError
from .geometry.lines import clip_lines
from .geometry.vectors import homogeneous
from .lens.intrinsics import Intrinsics
from .lens.undistortion import Undistorter
from .recording import Recording
from .report.picture import COLOURS as BGR
from .sources.colour_frames import ColourFrames
from .sources.opencv import opencv

__all__ = ["log", "save", "show"]

Calibrations = Mapping[tuple[int, int], Calibration]
Videos = Sequence[str | os.PathLike[str] | None]

APPLICATION = "epibar"
COLOURS = np.array(BGR, np.uint8)[:, ::-1]
GREY = (200, 200, 200)
JPEG_QUALITY = 80
RADIUS = 4.0
"""Of a frontier point, pixels."""


def log(
    recordings: Sequence[Recording],
    calibrations: Calibrations,
    videos: Videos | None = None,
    intrinsics: Sequence[Intrinsics | None] | None = None,
    *,
    every: int = 1,
    stream: Any = None,
) -> None:
    """Log a run to a Rerun stream.

    Parameters
    ----------
    recordings : sequence of Recording
        One per camera.
    calibrations : mapping of (int, int) to Calibration
        ``{(i, j): epibar.calibrate(recordings[i], recordings[j])}``. Pairs without F have no lines.
    videos : sequence of str or path or None, optional
        What the recordings were made from, for the frames.
    intrinsics : sequence of Intrinsics or None, optional
        With which the frames are undistorted, where the recordings were.
    every : int
        Log only each so many-th frame.
    stream : rerun.RecordingStream, optional
        By default the one that ``rerun.init`` started.

    Raises
    ------
    EpibarError
        ``rerun-sdk`` is missing, a video cannot be read or is not that of its recording, an argument is
        wrong.
    """
    rerun = _rerun()
    every = as_whole_number("every", every, 1)
    names = _names(recordings)
    check_pairs(calibrations, len(names))
    for argument, given in (("videos", videos), ("intrinsics", intrinsics)):
        if given is not None and len(given) != len(names):
            raise EpibarError(
                f"{argument} holds {len(given)}, expected one for each of {len(names)} recordings"
            )
    stream = stream if stream is not None else rerun.get_global_data_recording()
    if stream is None:
        raise EpibarError("there is no Rerun stream: call rerun.init first, or use epibar.live.show or save")
    clocks = _clocks(recordings, calibrations)
    for index, recording in enumerate(recordings):
        _log_silhouettes(rerun, stream, names[index], recording, clocks[index], every)
        video = videos[index] if videos is not None else None
        if video is not None:
            lens = intrinsics[index] if intrinsics is not None else None
            _log_frames(rerun, stream, names[index], recording, video, lens, clocks[index], every)
    for (i, j), calibration in calibrations.items():
        if calibration.F is not None:
            sizes = recordings[i].size, recordings[j].size
            _log_pair(rerun, stream, (names[i], names[j]), sizes, calibration, clocks[i], every)


def save(
    path: str | os.PathLike[str],
    recordings: Sequence[Recording],
    calibrations: Calibrations,
    videos: Videos | None = None,
    intrinsics: Sequence[Intrinsics | None] | None = None,
    *,
    every: int = 1,
) -> None:
    """Write a run to an ``.rrd`` file, which ``rerun FILE.rrd`` opens; see :func:`log` for the arguments.

    Raises
    ------
    EpibarError
        As for :func:`log`, or the file cannot be written.
    """
    rerun = _rerun()
    target = Path(path)
    if not target.parent.is_dir():
        raise EpibarError(f"{target}: there is no folder {target.parent}")
    stream = rerun.RecordingStream(APPLICATION)
    partial = target.with_name(f".{target.name}.part")
    try:
        stream.save(partial, default_blueprint=_blueprint(_names(recordings)))
        log(recordings, calibrations, videos, intrinsics, every=every, stream=stream)
        stream.flush()
        stream.disconnect()
        os.replace(partial, target)
    except (OSError, RuntimeError) as error:
        raise EpibarError(f"{target}: cannot be written ({error})") from error
    finally:
        stream.disconnect()
        partial.unlink(missing_ok=True)


def show(
    recordings: Sequence[Recording],
    calibrations: Calibrations,
    videos: Videos | None = None,
    intrinsics: Sequence[Intrinsics | None] | None = None,
    *,
    every: int = 1,
) -> None:
    """Open the Rerun viewer and log a run to it; the arguments are those of :func:`log`.

    Raises
    ------
    EpibarError
        As for :func:`log`, or the viewer does not start.
    """
    rerun = _rerun()
    stream = rerun.RecordingStream(APPLICATION)
    try:
        stream.spawn(default_blueprint=_blueprint(_names(recordings)))
    except (OSError, RuntimeError) as error:
        raise EpibarError(
            f"the Rerun viewer does not start ({error}); epibar.live.save writes a file"
        ) from error
    log(recordings, calibrations, videos, intrinsics, every=every, stream=stream)
    stream.flush()


def _rerun() -> Any:
    try:
        import rerun
        import rerun.blueprint
    except ImportError as error:
        raise EpibarError("rerun-sdk is missing, the live view: pip install 'epibar[live]'") from error
    return rerun


def _names(recordings: Sequence[Recording]) -> list[str]:
    if not recordings:
        raise EpibarError("recordings is empty: nothing to show")
    return camera_names(recording.name for recording in recordings)


def _blueprint(names: list[str]) -> Any:
    """Lay the cameras out beside each other."""
    rerun = _rerun()
    views = rerun.blueprint
    shown = [views.Spatial2DView(origin=rerun.new_entity_path([name]), name=name) for name in names]
    return views.Blueprint(views.Grid(*shown))


@dataclass(frozen=True, eq=False)
class _Clock:
    """When each frame of a camera is, on the common time line.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Seconds since frame 0 of the first camera.
    step : float
        Seconds between frames of the first camera.
    """

    times: NDArray[np.float64]
    step: float

    def set(self, stream: Any, frame: int) -> None:
        """Make what is logged next belong to a frame."""
        seconds = float(self.times[frame])
        stream.set_time("time", duration=seconds)
        stream.set_time("frame", sequence=round(seconds / self.step))


def _clocks(recordings: Sequence[Recording], calibrations: Calibrations) -> list[_Clock]:
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
        clocks.append(_Clock((recording.times - recording.times[:1] - start) / rate, step))
    return clocks


def _log_silhouettes(
    rerun: Any, stream: Any, name: str, recording: Recording, clock: _Clock, every: int
) -> None:
    for frame in range(0, recording.frames, every):
        clock.set(stream, frame)
        closed = [np.vstack([hull, hull[:1]]) for hull in recording.hulls(frame)]
        stream.log(
            rerun.new_entity_path([name, "silhouettes"]),
            rerun.LineStrips2D(closed, colors=[GREY] * len(closed)),
        )


def _log_frames(
    rerun: Any,
    stream: Any,
    name: str,
    recording: Recording,
    video: str | os.PathLike[str],
    lens: Intrinsics | None,
    clock: _Clock,
    every: int,
) -> None:
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


def _log_pair(
    rerun: Any,
    stream: Any,
    names: tuple[str, str],
    sizes: tuple[tuple[int, int], tuple[int, int]],
    calibration: Calibration,
    clock: _Clock,
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
