"""Colour frames, decoded from a video or read from images."""

from __future__ import annotations

import math
import os
import re
import time as clock
from collections.abc import Generator, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Image, Index
from ..errors import EpibarError, is_address
from .frame_range import FrameRange
from .images import IMAGE_SUFFIXES, as_bgr, missing_numbers, natural_order, read_image
from .mask_array_file import ARRAY_SUFFIXES
from .quiet_opencv import opencv
from .source import FrameSource
from .time_stamps import TimeStamps

__all__ = ["ColourFrames"]

# A container may announce a frame or two more than it holds without anything being wrong with it.
TRUNCATION_FRAMES = 2
TRUNCATION_SHARE = 0.02

RECONNECT_AFTER = (1.0, 3.0, 10.0)
"""Seconds before each new try to open a live stream that broke off."""
NEAR = 32
"""Frames ahead that are reached faster by decoding than by seeking, which goes back to a key frame."""
LEAST_ASPECT, MOST_ASPECT = math.log(1.002), math.log(3.0)
"""Logarithms: pixels that are as good as square, and such as no camera has."""
LIVE_PRIMING = 10.0
"""Seconds of a live stream from which the empty scene is learned, before those that are recorded."""


def _stamp(capture: Any) -> float:
    """Seconds that the container has for the frame just read."""
    return float(capture.get(opencv().CAP_PROP_POS_MSEC)) / 1000.0


def _pixel_aspect(capture: Any) -> float | None:
    """How wide a pixel of the frames as they come is for its height; None for square ones or nothing said."""
    cv2 = opencv()
    wide, high = (float(capture.get(key)) for key in (cv2.CAP_PROP_SAR_NUM, cv2.CAP_PROP_SAR_DEN))
    if not (wide > 0 and high > 0 and abs(math.log(wide / high)) < MOST_ASPECT):
        return None
    quarter = capture.get(cv2.CAP_PROP_ORIENTATION_META) % 180 == 90
    turned = quarter and capture.get(cv2.CAP_PROP_ORIENTATION_AUTO)
    aspect = high / wide if turned else wide / high
    return None if abs(math.log(aspect)) < LEAST_ASPECT else aspect


def _is_stream_or_pattern(source: str) -> bool:
    return is_address(source) or re.search(r"%0?\d*d", source) is not None


class ColourFrames(FrameSource[Image]):
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
    live : bool
        A stream that announces no end. It must be given one: ``frames`` with a last frame, or with seconds.
    frame_count : int or None
        What the container announces until the end was reached, then what was decoded; None if unknown.
    pixel_aspect : float or None
        Width of a pixel over its height, as the file says; None where pixels are square or nothing is said.
    truncated : bool
        The container announced clearly more frames than could be decoded, and a longer time than their stamps
        span. Known once the end was reached.
    warnings : list of str
        Plain-English remarks for the user.

    Raises
    ------
    EpibarError
        Missing, unreadable or empty source; a live stream without an end; while iterating, a frame of another
        size.

    Examples
    --------
    >>> with ColourFrames("cam1.mp4") as frames:
    ...     times = [time for index, time, frame in frames]
    """

    def __init__(
        self, path: str | os.PathLike[str], *, fps: float | None = None, frames: FrameRange | None = None
    ) -> None:
        super().__init__(path, fps, frames)
        self.live = False
        self._images: list[Path] | None = None
        self._started: tuple[Any, Image] | None = None
        file = Path(self.path)
        if file.is_dir():
            self._open_folder(file)
            return
        if not _is_stream_or_pattern(self.path):
            if not file.exists():
                raise EpibarError(f"{self.shown}: no such file or folder")
            if file.stat().st_size == 0:
                raise EpibarError(f"{self.shown}: the file is empty; copy or record it again")
            if file.suffix.lower() in ARRAY_SUFFIXES:
                raise EpibarError(
                    f"{self.shown}: an array of masks, not a video; open it as ready-made masks"
                )
            if (
                file.suffix.lower() in IMAGE_SUFFIXES
            ):  # OpenCV would take scene1.png for the start of a sequence
                self._open_images([file])
                return
        self._open_video()

    def _open_folder(self, folder: Path) -> None:
        images = (f for f in folder.iterdir() if f.suffix.lower() in IMAGE_SUFFIXES)
        found = (f for f in images if not f.name.startswith(".") and f.is_file())
        files = sorted(found, key=natural_order)
        if not files:
            raise EpibarError(f"{self.shown}: no png, jpg, tif or bmp images in this folder")
        self._open_images(files)

    def _open_images(self, files: list[Path]) -> None:
        files = files[self.first : self.first + self._range.count(self.shown, len(files))]
        self._images = files
        self.height, self.width = read_image(files[0]).shape[:2]
        self._choose_fps(None)
        if missing := missing_numbers(files):
            self._warn(
                f"{self.shown}: the numbers of {missing} images are missing between the others, so those "
                "after them come too early; add them, black ones where nothing moves in masks"
            )
        self.frame_count = self._range.expected(len(files), self.fps)

    def _capture(self) -> Any:
        cv2 = opencv()
        try:
            capture = cv2.VideoCapture(self.path)
        except cv2.error:
            capture = None
        if capture is None or not capture.isOpened():
            reason = "it may be another kind of file, or a recording cut off before its index was written"
            raise EpibarError(f"{self.shown}: not a video that OpenCV can open; {reason}")
        return capture

    def _open_video(self) -> None:
        cv2 = opencv()
        capture = self._capture()
        ok, first = capture.read()
        if not ok or first is None:
            capture.release()
            raise EpibarError(
                f"{self.shown}: not one frame can be decoded; convert it to H.264 mp4 and try again"
            )
        self.height, self.width = first.shape[:2]
        self._note_pixels(_pixel_aspect(capture))
        announced = capture.get(cv2.CAP_PROP_FRAME_COUNT)
        self._started = (capture, first)
        if math.isfinite(announced) and 0 < announced < 1e12:
            self.frame_count = self._range.count(self.shown, int(announced))
        elif is_address(self.path):
            self.live = True
            if not self._range.has_end:
                self.close()
                raise EpibarError(
                    f"{self.shown}: a live stream has no end; say how much of it to use, with --seconds 60 "
                    "or --frames :1500 (seconds=60, frames=(0, 1500))"
                )
        self._choose_fps(capture.get(cv2.CAP_PROP_FPS))
        self.frame_count = self._range.expected(self.frame_count, self.fps)
        if self.live and self._range.last is not None and self.frame_count is None:
            self.frame_count = self._range.last - self.first
        self._announced = self.frame_count

    def _note_pixels(self, aspect: float | None) -> None:
        """Keep how wide pixels are, and say so where they are not square."""
        self.pixel_aspect = aspect
        if aspect is not None:
            self._warn(
                f"{self.shown}: its pixels are {aspect:.3g} times as wide as high by what the file says: "
                "networks count with that, and pairs take pixels for square; for pairs give the camera "
                "matrix, or make pixels square: ffmpeg -i IN -vf scale=iw*sar:ih,setsar=1 OUT"
            )

    @property
    def of_images(self) -> bool:
        """Whether the source is one image or a folder of them."""
        return self._images is not None

    def __iter__(self) -> Iterator[tuple[int, float, Image]]:
        moments = self._iterate_video() if self._images is None else self._iterate_folder(self._images)
        return self._range.in_time(moments)

    def _iterate_folder(self, images: list[Path]) -> Generator[tuple[int, float, Image], None, None]:
        for index, file in enumerate(images):
            image = read_image(file)
            self._check_size(image.shape, str(file))
            yield index, index / self.fps, image

    def _at(self, number: int) -> tuple[Any, Image | None]:
        """A capture that has read so far, and that frame of the file; None where it ends before."""
        if self._started is not None:
            (capture, frame), self._started = self._started, None
        else:
            capture = self._capture()
            frame = capture.read()[1]
        if number and all(capture.grab() for _ in range(number)):
            return capture, capture.retrieve()[1]
        return capture, None if number else frame

    def _iterate_video(self) -> Generator[tuple[int, float, Image], None, None]:
        capture, frame = self._at(self.first)
        try:
            if self.first and frame is None:
                raise self._range.beyond(self.shown)
            index, time, gaps = 0, 0.0, 0
            stamps = TimeStamps(self.fps, _stamp(capture))
            while frame is not None:
                self._check_size(frame.shape, f"{self.shown}: frame {self.first + index}")
                if index:
                    previous = time
                    by_stamps = stamps.at(_stamp(capture))
                    time = by_stamps if self._given_fps is None else index / self.fps
                    gaps += time - previous > 1.5 / self.fps
                yield index, time, as_bgr(frame)
                index += 1
                frame = capture.read()[1] if self._range.holds(self.first + index) else None
                if frame is None and self.live and self._range.holds(self.first + index):
                    lost = clock.monotonic()
                    capture.release()
                    capture, frame = self._reconnected()
                    # Time goes on while nothing comes; the stamps of a new connection begin anew.
                    stamps.go_on(clock.monotonic() - lost, _stamp(capture))
                    gaps += 1
                    if frame is None:
                        self._warn(f"{self.shown}: the stream ended after {index} frames, too early")
            self._finish(index, gaps, stamps)
        finally:
            capture.release()

    def _reconnected(self) -> tuple[Any, Image | None]:
        """A new connection to a live stream and its first frame; None where there is none to be had."""
        capture = opencv().VideoCapture()
        for pause in RECONNECT_AFTER:
            clock.sleep(pause)
            try:
                capture = self._capture()
            except EpibarError:
                continue
            frame = capture.read()[1]
            if frame is not None:
                self._warn(f"{self.shown}: the stream broke off and was taken up again; frames are missing")
                return capture, frame
            capture.release()
        return capture, None

    def _finish(self, decoded: int, gaps: int, stamps: TimeStamps) -> None:
        self.frame_count = decoded
        if self._announced is not None:
            missing = self._announced - decoded
            self.truncated = missing > max(TRUNCATION_FRAMES, TRUNCATION_SHARE * self._announced)
            # Some containers have a length, and a number of frames worked out by a rate that may vary.
            length = self._announced / (self._stated_fps or self.fps)
            self.truncated &= length - stamps.span - stamps.usual > TRUNCATION_SHARE * length
            if self.truncated:
                found = f"decoded {decoded} of {self._announced} frames"
                self._warn(f"{self.shown}: truncated, {found}; those are used")
        if self._given_fps is None and 0 < stamps.replaced < decoded - 1:  # else it has none at all
            self._warn(
                f"{self.shown}: time stamps of {stamps.replaced} frames go back, stand still or leap by more "
                "than a minute; each is taken to follow the frame before at the usual interval"
            )
        if gaps:
            self._warn(
                f"{self.shown}: {gaps} gaps between frames are longer than 1.5 frame times; frames were "
                "dropped or the rate varies. The times in the file are used, and longer gaps left out"
            )

    def sample(self, count: int) -> Iterator[Image]:
        """About ``count`` frames spread over the whole source, found by seeking, so good for statistics only.

        Where seeking does not work, or the length is unknown, all frames come.
        """
        if self._images is not None:
            for number in np.unique(np.linspace(0, len(self._images) - 1, count).astype(int)):
                image = read_image(self._images[number])
                self._check_size(image.shape, str(self._images[number]))
                yield image
            return
        if self.live:
            with closing(self._iterate_video()) as moments:
                for _, time, frame in moments:
                    if time > LIVE_PRIMING:
                        break
                    yield frame
            return
        total = self.frame_count or 0
        if total <= 4 * count or is_address(self.path):
            keep = max(1, total // count)
            yield from (frame for index, _, frame in self if index % keep == 0)
            return
        found = 0
        numbers = np.linspace(self.first, self.first + total - 1, count).astype(int)
        with closing(self._picked(numbers)) as picked:
            for frame in picked:
                if (frame.shape[1], frame.shape[0]) == self.size:
                    found += 1
                    yield as_bgr(frame)
        if 2 * found < len(numbers):
            yield from (frame for _, _, frame in self)

    def _picked(self, numbers: Index) -> Generator[Image, None, None]:
        """Yield frames by their numbers in the file, which increase, as far as they can be had.

        Of a part of the file frames are counted: a seek goes by the mean rate, which may vary.
        """
        cv2 = opencv()
        capture, at = self._capture(), 0
        of_part = self.first > 0 or self._range.last is not None
        last: tuple[float, Image] | None = None
        try:
            for number in map(int, numbers):
                if number - at > NEAR and not of_part:
                    capture.set(cv2.CAP_PROP_POS_FRAMES, float(number))
                    ok, frame = capture.read()
                else:  # a seek would decode as many from the key frame before
                    ok = all(capture.grab() for _ in range(number + 1 - at))
                    ok, frame = capture.retrieve() if ok else (False, None)
                at = number + 1
                if not ok or frame is None:
                    continue
                # Beyond the end of a file that breaks off the last frame comes again and again.
                stamp = _stamp(capture)
                if last is not None and stamp <= last[0] and np.array_equal(frame, last[1]):
                    continue
                last = stamp, frame
                yield frame
        finally:
            capture.release()

    def close(self) -> None:
        """Release the file."""
        if self._started is not None:
            self._started[0].release()
            self._started = None
