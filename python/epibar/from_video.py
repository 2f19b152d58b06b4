"""A :class:`~epibar.Recording` made from the video of one camera, streamed: :func:`record`.

decode -> foreground -> health check, undistort, pack: three threads, which overlap because OpenCV and the
compiled recorder release the interpreter. A few frames are in the queues; the recorder keeps one block of
packed bits.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import NoneType

import numpy as np

from .arguments import AnyArray, Image, Mask, as_text, core_errors
from .errors import EpibarError
from .foreground import Foreground
from .foreground.options import ForegroundMethod, ForegroundOptions
from .health.camera_health import CameraHealth
from .lens.cameras_toml import intrinsics_of
from .lens.intrinsics import Intrinsics
from .lens.undistortion import Undistorter
from .recording import DEFAULT_LINES, MIN_COMPONENT_AREA, Recording, new_recorder
from .sources.chapters import colour_frames
from .sources.colour_frames import ColourFrames
from .sources.frame_range import FrameRange
from .sources.images import read_image
from .sources.mask_frames import MaskFrames
from .sources.picture_taking import PictureTaker
from .sources.prefetch import prefetched

__all__ = ["record"]

Moment = tuple[float, Mask, Image]
"""Seconds, what moves, and the frame itself, which for ready masks is the mask."""
Stream = Generator[Moment, None, None]

EDGE = 5
"""Pixels; the square that the visible area is eroded by, since outlines at its edge are those of the view."""


def record(
    path: str | os.PathLike[str],
    lines: int = DEFAULT_LINES,
    seed: int = 0,
    *,
    name: str | None = None,
    masks: bool = False,
    foreground: ForegroundMethod | ForegroundOptions = "auto",
    background: str | os.PathLike[str] | None = None,
    ignore: str | os.PathLike[str] | AnyArray | None = None,
    intrinsics: Intrinsics | str | os.PathLike[str] | None = None,
    fps: float | None = None,
    frames: Sequence[int | None] | None = None,
    seconds: float | None = None,
    chapters: bool = False,
    pictures: bool = False,
    progress: bool | Callable[[str, float], None] | None = None,
) -> Recording:
    """Turn the video of one stationary camera into a recording.

    Parameters
    ----------
    path : str or path
        A video, a folder of images, or whatever OpenCV opens.
    lines : int
        How many random lines to draw.
    seed : int
        Of the lines.
    name : str, optional
        Of the camera; the file's stem by default. Its intrinsics are looked up under it.
    masks : bool
        The input is black and white already, white = moving, or an ``.npz`` with key ``masks``.
    foreground : {"auto", "mog2", "mixture", "knn", "median"} or ForegroundOptions
        How to tell what moves.
    background : str or path, optional
        Video or picture of the empty scene by the same camera.
    ignore : str or path or ndarray, shape (H, W), optional
        Image or array, non-zero where motion does not count: a clock in the picture, a screen, trees. In
        pixels of the video, also where intrinsics are given.
    intrinsics : Intrinsics or str or path, optional
        Camera matrix and distortion, or the ``.toml`` file to look them up in. Lens distortion bends lines:
        with it everything in the recording is in undistorted pixels of the same matrix.
    fps : float, optional
        Frames per second, instead of the times in the file.
    frames : (int or None, int or None), optional
        First frame to use and the one after the last, each None for the end of the video: a part in which
        the camera stood still. Frames of the recording, and their times, count from the first of them, so
        give the same part to cameras that were started together.
    seconds : float, optional
        Use only so much of the video, from the first frame used on. A live stream needs this, or a last
        frame.
    chapters : bool
        A folder of videos, or a pattern such as ``GX*0123.MP4``, is one camera whose files follow one
        another, in the order of their numbers.
    pictures : bool
        Keep small pictures of a few hundred frames, for a report, as :attr:`Recording.pictures`.
    progress : bool or callable, optional
        Show a progress bar on stderr; by default where that is a terminal. Or called after each frame with
        the name of the stage and the share of the announced frames that is done, 0 to 1.

    Returns
    -------
    Recording
        What was bearable but wrong (a camera that moved, a light that was switched) is in its ``warnings``.

    Raises
    ------
    EpibarError
        The video cannot be read, or does not fit its intrinsics, background or ignore mask.

    Examples
    --------
    >>> import epibar
    >>> rec = epibar.record("cam1.mp4", lines=20000, seed=0)
    """
    if name is not None:
        as_text("name", name)
    options = _options(foreground, background)
    part = FrameRange.of(frames, seconds)
    with (
        MaskFrames(path, fps=fps, frames=part, chapters=chapters)
        if masks
        else colour_frames(path, fps, part, chapters) as source
    ):
        name = name or source.name
        if isinstance(intrinsics, (str, os.PathLike)):
            intrinsics = intrinsics_of(intrinsics, name)
        if not isinstance(intrinsics, (Intrinsics, NoneType)):
            raise EpibarError(f"intrinsics is a {type(intrinsics).__name__}, expected Intrinsics or a path")
        if ignore is None and isinstance(foreground, ForegroundOptions) and not masks:
            ignore = foreground.ignore
        hidden = _ignore_mask(ignore, source.size)
        undistort = None
        if intrinsics is not None:
            undistort = Undistorter(intrinsics, source.size, name)
        visible = _visible_area(undistort, hidden)
        recorder = new_recorder(source.width, source.height, lines, seed, MIN_COMPONENT_AREA, visible)
        health = CameraHealth(name, ignore=hidden)
        if masks:
            stream = _ready_masks(source, hidden)
            if options.background is not None or options.method != ForegroundOptions().method:
                source.warnings.append("the masks are ready: what was given to find them with is not used")
        else:
            stream = _moving(source, options if hidden is None else replace(options, ignore=hidden), health)
        taker = PictureTaker(source.frame_count, source.fps) if pictures else None
        with closing(stream):
            watched = _watched(stream, source.frame_count, name, progress)
            for index, (time, mask, frame) in enumerate(watched):
                straight = np.ascontiguousarray(undistort(mask) if undistort else mask)
                with core_errors():
                    recorder.push(straight, time)
                if taker is not None:
                    taker.look(index, time, straight, partial(_straight_image, frame, undistort))
        with core_errors():
            core = recorder.finish()
        return Recording(
            core,
            name=name,
            warnings=[*source.warnings, *health.warnings],
            matrix=None if intrinsics is None else intrinsics.matrix,
            health=health.numbers,
            first_frame=source.first,
            pixel_aspect=source.pixel_aspect,
            pictures=None if taker is None else taker.pictures(),
            lens=intrinsics,
        )


def _options(
    foreground: ForegroundMethod | ForegroundOptions, background: str | os.PathLike[str] | None
) -> ForegroundOptions:
    options = (
        foreground if isinstance(foreground, ForegroundOptions) else ForegroundOptions(method=foreground)
    )
    return options if background is None else replace(options, background=background)


def _moving(frames: ColourFrames, options: ForegroundOptions, health: CameraHealth) -> Stream:
    """Time and mask of each frame of a colour video."""
    foreground = Foreground.for_frames(frames, options)
    health.count(foreground.counted)

    def masked() -> Generator[tuple[int, float, Image, Mask], None, None]:
        with closing(prefetched(frames, depth=1)) as ahead:
            for index, time, frame in ahead:
                yield index, time, frame, foreground.apply(frame)

    with closing(prefetched(masked(), depth=1)) as ahead:
        for index, time, frame, mask in ahead:
            yield time, health.update(frames.first + index, frame, mask), frame


def _ready_masks(frames: MaskFrames, hidden: Mask | None) -> Stream:
    """Time and mask of each frame that already is a mask."""
    with closing(prefetched(frames)) as ahead:
        for _, time, mask in ahead:
            counted = mask if hidden is None else np.where(hidden, np.uint8(0), mask)
            yield time, counted, mask


def _straight_image(frame: Image, undistort: Undistorter | None) -> Image:
    """Frame or mask as an image for people, undistorted where the recording is."""
    image = np.repeat(frame[:, :, None] * np.uint8(255), 3, axis=2) if frame.ndim == 2 else frame
    return image if undistort is None else undistort.image(image)


def _watched(
    stream: Iterable[Moment],
    total: int | None,
    name: str,
    progress: bool | Callable[[str, float], None] | None,
) -> Iterable[Moment]:
    """Put a progress bar around a stream where somebody watches."""
    if callable(progress):
        return _reported(stream, total, progress)
    if progress is None:
        progress = sys.stderr is not None and sys.stderr.isatty()
    if not progress:
        return stream
    from tqdm import tqdm

    bar: Iterable[Moment] = tqdm(stream, total=total, desc=name, unit=" frames", file=sys.stderr, leave=False)
    return bar


def _reported(
    stream: Iterable[Moment], total: int | None, progress: Callable[[str, float], None]
) -> Iterator[Moment]:
    for count, moment in enumerate(stream, 1):
        yield moment
        progress("recording", min(count / total, 1.0) if total else 0.0)


def _ignore_mask(ignore: str | os.PathLike[str] | AnyArray | None, size: tuple[int, int]) -> Mask | None:
    """Load an ignore mask and check its size; 1 where motion does not count."""
    if ignore is None:
        return None
    where = "ignore mask"
    if isinstance(ignore, (str, os.PathLike)):
        where = os.fspath(ignore)
        image = read_image(Path(ignore)).max(axis=2)
    else:
        image = np.asarray(ignore)
    if image.shape != size[::-1]:
        found = "x".join(map(str, image.shape[::-1]))
        raise EpibarError(f"{where}: {found} pixels, but the frames are {size[0]}x{size[1]}")
    result: Mask | None = (image != 0).astype(np.uint8)
    return result


def _visible_area(undistort: Undistorter | None, hidden: Mask | None) -> Mask | None:
    """Where motion is seen and counted, in pixels of the recording, without its edge; None if everywhere."""
    import cv2

    seen = None if hidden is None else 1 - hidden
    if undistort is not None:
        seen = undistort.valid if seen is None else undistort.valid & undistort(seen)
    if seen is None or seen.all():
        return None
    visible: Mask = cv2.erode(seen, np.ones((EDGE, EDGE), np.uint8))  # type: ignore[assignment]
    return visible
