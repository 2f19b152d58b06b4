"""Frames and ready-made masks, streamed from whatever a user has.

A source is a video file, a folder of images, a stream or numbered-image pattern that OpenCV opens, or (masks
only) an ``.npz`` or ``.npy`` array. Every source is read from start to end in bounded memory and may be read
again: each ``iter()`` starts at frame 0. Frames count from 0; times are seconds since frame 0.

What is wrong but bearable (a truncated file, no frame rate, dropped frames) goes to ``warnings``; what is not
raises :class:`~epibar.errors.EpibarError`.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from .errors import EpibarError
from .frame_range import FrameRange
from .images import IMAGE_SUFFIXES, as_bgr, natural_order, opencv, read_image
from .mask_array import ARRAY_SUFFIXES, MaskArray
from .prefetch import prefetched

__all__ = ["DEFAULT_FPS", "Frames", "MaskFrames", "prefetched", "read_frame"]

DEFAULT_FPS = 25.0

# A container may announce a frame or two more than it holds without anything being wrong with it.
TRUNCATION_FRAMES = 2
TRUNCATION_SHARE = 0.02

T = TypeVar("T")


def _is_stream_or_pattern(source: str) -> bool:
    return "://" in source or re.search(r"%0?\d*d", source) is not None


class _Source(Generic[T]):
    """What every source has: a name, a size, a rate, warnings and a way to be read from the start."""

    def __init__(
        self, path: str | os.PathLike[str], fps: float | None, frames: FrameRange | None = None
    ) -> None:
        if fps is not None and not (math.isfinite(fps) and fps > 0):
            raise EpibarError(f"{path}: fps is {fps}; give a positive number of frames per second")
        self.path = os.fspath(path)
        self.name = Path(self.path).stem
        self.warnings: list[str] = []
        self.truncated = False
        self.width = 0
        self.height = 0
        self.frame_count: int | None = None
        self.fps = DEFAULT_FPS
        self._given_fps = fps
        self._range = frames or FrameRange()

    @property
    def first(self) -> int:
        """Number in the file of the frame that is frame 0 here."""
        return self._range.first

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.width, self.height

    def _warn(self, message: str) -> None:
        if message not in self.warnings:
            self.warnings.append(message)

    def _choose_fps(self, announced: float | None) -> None:
        if self._given_fps is not None:
            self.fps = float(self._given_fps)
        elif announced is not None and 0 < announced < 1e4:  # also false for NaN
            self.fps = float(announced)
        else:
            self.fps = DEFAULT_FPS
            self._warn(f"{self.path}: no frame rate given, {DEFAULT_FPS:g} frames per second assumed")

    def _check_size(self, shape: tuple[int, ...], where: str) -> None:
        height, width = shape[:2]
        if (width, height) != self.size:
            raise EpibarError(
                f"{where}: {width}x{height}, but the frames before it are {self.width}x{self.height}; "
                "all frames of one camera must have one size"
            )

    def close(self) -> None:
        """Release the file."""

    def __enter__(self: Any) -> Any:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[tuple[int, float, T]]:
        raise NotImplementedError


class Frames(_Source[np.ndarray]):
    """Colour frames of a video, a folder of images, or anything ``cv2.VideoCapture`` opens.

    Iterating yields ``(index, time, frame)``: the frame number from 0, seconds since frame 0, and an
    (H, W, 3) uint8 BGR image. Each new iteration starts at frame 0.

    Parameters
    ----------
    path : str or path
        Video file; folder of png, jpg, tif or bmp images, in natural order; one image; URL or
        ``image_%04d.png`` pattern.
    fps : float, optional
        Frames per second. Overrides what the file says, and its time stamps.
    frames : FrameRange, optional
        Which of them to use; all by default. Numbers and times then count from the first of these.

    Attributes
    ----------
    name : str
        File name without its suffix, or the folder's name.
    width, height : int
        Pixels, of the decoded frames.
    fps : float
        Frames per second; 25, with a warning, where nothing says otherwise.
    frame_count : int or None
        What the container announces until the end was reached, then what was decoded; None if unknown.
    truncated : bool
        The container announced clearly more frames than could be decoded. Known once the end was reached.
    warnings : list of str
        Plain-English remarks for the user.

    Raises
    ------
    EpibarError
        Missing, unreadable or empty source; while iterating, a frame of another size.

    Examples
    --------
    >>> with Frames("hall.mp4") as frames:  # doctest: +SKIP
    ...     times = [time for index, time, frame in frames]
    """

    def __init__(
        self, path: str | os.PathLike[str], *, fps: float | None = None, frames: FrameRange | None = None
    ) -> None:
        super().__init__(path, fps, frames)
        self._images: list[Path] | None = None
        self._started: tuple[Any, np.ndarray] | None = None
        file = Path(self.path)
        if file.is_dir():
            self.name = file.resolve().name
            self._open_folder(file)
            return
        if not _is_stream_or_pattern(self.path):
            if not file.exists():
                raise EpibarError(f"{self.path}: no such file or folder")
            if file.stat().st_size == 0:
                raise EpibarError(f"{self.path}: the file is empty; copy or record it again")
            if file.suffix.lower() in ARRAY_SUFFIXES:
                raise EpibarError(f"{self.path}: an array of masks, not a video; open it as ready-made masks")
            if (
                file.suffix.lower() in IMAGE_SUFFIXES
            ):  # OpenCV would take scene1.png for the start of a sequence
                self._open_images([file])
                return
        self._open_video()

    def _open_folder(self, folder: Path) -> None:
        images = (f for f in folder.iterdir() if f.suffix.lower() in IMAGE_SUFFIXES)
        files = sorted((f for f in images if not f.name.startswith(".")), key=natural_order)
        if not files:
            raise EpibarError(f"{self.path}: no png, jpg, tif or bmp images in this folder")
        self._open_images(files)

    def _open_images(self, files: list[Path]) -> None:
        files = files[self.first : self.first + self._range.count(self.path, len(files))]
        self._images = files
        self.height, self.width = read_image(files[0]).shape[:2]
        self.frame_count = len(files)
        self._choose_fps(None)

    def _capture(self) -> Any:
        cv2 = opencv()
        try:
            capture = cv2.VideoCapture(self.path)
        except cv2.error:
            capture = None
        if capture is None or not capture.isOpened():
            reason = "it may be another kind of file, or a recording cut off before its index was written"
            raise EpibarError(f"{self.path}: not a video that OpenCV can open; {reason}")
        return capture

    def _open_video(self) -> None:
        cv2 = opencv()
        capture = self._capture()
        ok, first = capture.read()
        if not ok or first is None:
            capture.release()
            raise EpibarError(
                f"{self.path}: not one frame can be decoded; convert it to H.264 mp4 and try again"
            )
        self.height, self.width = first.shape[:2]
        announced = capture.get(cv2.CAP_PROP_FRAME_COUNT)
        if math.isfinite(announced) and 0 < announced < 1e12:
            self.frame_count = self._range.count(self.path, int(announced))
        self._announced = self.frame_count
        self._choose_fps(capture.get(cv2.CAP_PROP_FPS))
        self._started = (capture, first)

    def __iter__(self) -> Iterator[tuple[int, float, np.ndarray]]:
        return self._iterate_video() if self._images is None else self._iterate_folder(self._images)

    def _iterate_folder(self, images: list[Path]) -> Iterator[tuple[int, float, np.ndarray]]:
        for index, file in enumerate(images):
            image = read_image(file)
            self._check_size(image.shape, str(file))
            yield index, index / self.fps, image

    def _iterate_video(self) -> Iterator[tuple[int, float, np.ndarray]]:
        cv2 = opencv()
        started, self._started = self._started, None
        capture = started[0] if started else self._capture()
        ok, frame = (True, started[1]) if started else capture.read()
        try:
            if self.first:
                ok = all(capture.grab() for _ in range(self.first))
                ok, frame = capture.retrieve() if ok else (False, None)
                if not ok:
                    raise self._range.beyond(self.path)
            index, time, start, gaps = 0, 0.0, float(capture.get(cv2.CAP_PROP_POS_MSEC)), 0
            while ok and frame is not None:
                self._check_size(frame.shape, f"{self.path}: frame {self.first + index}")
                if index:
                    previous, time = time, self._time(index, time, capture.get(cv2.CAP_PROP_POS_MSEC) - start)
                    gaps += time - previous > 1.5 / self.fps
                yield index, time, as_bgr(frame)
                index += 1
                ok, frame = capture.read() if self._range.holds(self.first + index) else (False, None)
            self._finish(index, gaps)
        finally:
            capture.release()

    def _time(self, index: int, previous: float, stamp_ms: float) -> float:
        """Seconds of a frame: its time stamp where that makes sense, else one frame after the last."""
        if self._given_fps is not None:
            return index / self.fps
        stamp = stamp_ms / 1000.0
        sane = math.isfinite(stamp) and previous < stamp < previous + max(60.0, 10.0 / self.fps)
        return stamp if sane else previous + 1.0 / self.fps

    def _finish(self, decoded: int, gaps: int) -> None:
        self.frame_count = decoded
        if self._announced is not None:
            missing = self._announced - decoded
            self.truncated = missing > max(TRUNCATION_FRAMES, TRUNCATION_SHARE * self._announced)
            if self.truncated:
                found = f"decoded {decoded} of {self._announced} frames"
                self._warn(f"{self.path}: truncated, {found}; those are used")
        if gaps:
            self._warn(
                f"{self.path}: {gaps} gaps between frames are longer than 1.5 frame times; frames were "
                "dropped or the rate varies, and frames of two cameras may not belong together"
            )

    def sample(self, count: int) -> Iterator[np.ndarray]:
        """About ``count`` frames spread over the whole source, found by seeking, so good for statistics only.

        Where seeking does not work, or the length is unknown, all frames come.
        """
        if self._images is not None:
            for number in np.unique(np.linspace(0, len(self._images) - 1, count).astype(int)):
                image = read_image(self._images[number])
                self._check_size(image.shape, str(self._images[number]))
                yield image
            return
        total = self.frame_count or 0
        if total <= 4 * count or "://" in self.path:
            keep = max(1, total // count)
            yield from (frame for index, _, frame in self if index % keep == 0)
            return
        cv2 = opencv()
        capture, found = self._capture(), 0
        try:
            for number in np.linspace(self.first, self.first + total - 1, count).astype(int):
                capture.set(cv2.CAP_PROP_POS_FRAMES, float(number))
                ok, frame = capture.read()
                if ok and frame is not None and (frame.shape[1], frame.shape[0]) == self.size:
                    found += 1
                    yield as_bgr(frame)
        finally:
            capture.release()
        if not found:
            yield from (frame for _, _, frame in self)

    def close(self) -> None:
        """Release the file."""
        if self._started is not None:
            self._started[0].release()
            self._started = None


class MaskFrames(_Source[np.ndarray]):
    """Ready-made masks, with the same iteration as :class:`Frames`.

    Iterating yields ``(index, time, mask)`` with an (H, W) uint8 mask, 1 where something moves.

    Parameters
    ----------
    path : str or path
        ``.npz`` with key ``masks``, a (T, H, W) bool or uint8 array, non-zero = moving, and optionally
        ``fps``; ``.npy`` with that array; a video of silhouettes, moving where brighter than 127; or a folder
        of images, likewise, except that images of only 0 and 1 are taken as they are.
    fps : float, optional
        Frames per second. Overrides what the file says.
    frames : FrameRange, optional
        As for :class:`Frames`.

    Raises
    ------
    EpibarError
        As for :class:`Frames`; a missing key, a wrong rank or dtype, no frames.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, fps: float | None = None, frames: FrameRange | None = None
    ) -> None:
        super().__init__(path, fps, frames)
        self._frames: Frames | None = None
        if Path(self.path).suffix.lower() in ARRAY_SUFFIXES and not Path(self.path).is_dir():
            self._open_array()
        else:
            self._frames = Frames(path, fps=fps, frames=frames)
            self.name, self.fps = self._frames.name, self._frames.fps
            self.width, self.height = self._frames.size
            self.frame_count = self._frames.frame_count
            self.warnings = self._frames.warnings

    def _open_array(self) -> None:
        self._array = MaskArray(self.path)
        total, self.height, self.width = self._array.shape
        self.frame_count = self._range.count(self.path, total)
        self._choose_fps(self._array.fps)

    def __iter__(self) -> Iterator[tuple[int, float, np.ndarray]]:
        if self._frames is not None:
            return self._iterate_frames(self._frames)
        return self._iterate_array(self._array)

    def _iterate_array(self, array: MaskArray) -> Iterator[tuple[int, float, np.ndarray]]:
        expected = self._range.count(self.path, array.shape[0])
        found = 0
        for found, mask in enumerate(islice(array, self.first, self.first + expected), 1):
            yield found - 1, (found - 1) / self.fps, mask
        if found < expected:
            self.truncated = True
            self._warn(f"{self.path}: truncated, read {found} of {expected} frames; those are used")
        self.frame_count = found

    def _iterate_frames(self, frames: Frames) -> Iterator[tuple[int, float, np.ndarray]]:
        brightest, moving = 0, False
        for index, time, frame in frames:
            grey = frame.max(axis=2)
            peak = int(grey.max())
            binary = peak <= 1 and frames._images is not None
            mask = (grey > (0 if binary else 127)).astype(np.uint8)
            brightest, moving = max(brightest, peak), moving or bool(mask.any())
            yield index, time, mask
        self.frame_count, self.truncated = frames.frame_count, frames.truncated
        if brightest and not moving:
            found = f"no pixel is brighter than 127 (the brightest is {brightest})"
            self._warn(f"{self.path}: {found}; save masks as 0 and 255")

    def close(self) -> None:
        """Release the file."""
        if self._frames is not None:
            self._frames.close()


def read_frame(path: str | os.PathLike[str], index: int = 0) -> np.ndarray:
    """One frame, for a picture.

    Parameters
    ----------
    path : str or path
        As for :class:`Frames`, or an ``.npz`` or ``.npy`` array of masks, which comes back black and white.
    index : int
        Frame number from 0, reached by decoding from the start: not every container seeks exactly.

    Returns
    -------
    ndarray, shape (H, W, 3), uint8
        BGR.

    Raises
    ------
    EpibarError
        The source cannot be read, or has no such frame.
    """
    path = os.fspath(path)
    if index < 0:
        raise EpibarError(f"{path}: frame {index} asked for; frames count from 0")
    if Path(path).suffix.lower() in ARRAY_SUFFIXES:
        with MaskFrames(path) as masks:
            for number, _, mask in masks:
                if number == index:
                    return np.repeat(mask[:, :, None] * np.uint8(255), 3, axis=2)
            raise EpibarError(f"{path}: frame {index} asked for, but it has {masks.frame_count} frames")
    with Frames(path) as frames:
        if frames._images is not None:
            if index < len(frames._images):
                return read_image(frames._images[index])
        elif frames._started is not None:
            (capture, frame), frames._started = frames._started, None
            try:
                ok = all(capture.grab() for _ in range(index))
                if index:
                    ok, frame = capture.retrieve() if ok else (False, None)
            finally:
                capture.release()
            if ok and frame is not None:
                return as_bgr(frame)
        raise EpibarError(f"{path}: frame {index} asked for, but it has {frames.frame_count} frames")
