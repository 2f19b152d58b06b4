"""The run on one time line in the Rerun viewer: frames, silhouettes, epipolar lines, frontier points.

>>> import epibar
>>> recordings = [epibar.Recording.load("cam1.npz"), epibar.Recording.load("cam2.npz")]
>>> calibrations = {(0, 1): epibar.Calibration.load("cam1_cam2.npz")}
>>> videos = ["cam1.mp4", "cam2.mp4"]
>>> epibar.live.save("run.rrd", recordings, calibrations, videos)  # or epibar.live.show, without a file

Needs ``pip install 'epibar[live]'``. Below each camera's name there are ``image`` (where a video is given),
``silhouettes``, and for each other camera of its pairs ``points/<other>``, the frontier points, and
``lines/<other>``, the epipolar lines of the other view's points. One colour is one point in both views. The
time line counts seconds (``time``) or frames (``frame``) of the first camera, by the pairs' clocks: time
offset, frame rates and drift.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..arguments import as_whole_number, camera_names, check_pairs
from ..calibration import Calibration
from ..errors import EpibarError
from ..lens.intrinsics import Intrinsics
from ..recording import Recording
from .entities import log_frames, log_pair, log_silhouettes
from .timeline import camera_clocks

__all__ = ["log", "save", "show"]

Calibrations = Mapping[tuple[int, int], Calibration]
Videos = Sequence[str | os.PathLike[str] | None]

APPLICATION = "epibar"


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
    clocks = camera_clocks(recordings, calibrations)
    for index, recording in enumerate(recordings):
        log_silhouettes(rerun, stream, names[index], recording, clocks[index], every)
        video = videos[index] if videos is not None else None
        if video is not None:
            lens = intrinsics[index] if intrinsics is not None else None
            log_frames(rerun, stream, names[index], recording, video, lens, clocks[index], every)
    for (i, j), calibration in calibrations.items():
        if calibration.F is not None:
            sizes = recordings[i].size, recordings[j].size
            log_pair(rerun, stream, (names[i], names[j]), sizes, calibration, clocks[i], every)


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
