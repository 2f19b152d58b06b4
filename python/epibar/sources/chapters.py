"""Several files of one camera as one: action cameras begin a new file every few gigabytes.

The frames of each chapter follow those of the one before at the usual interval, as such cameras film on
without a break. Whether one is missing is told from the numbers in the names.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Generator, Iterator
from contextlib import closing
from glob import glob
from itertools import pairwise
from pathlib import Path

from ..arguments import Image
from ..errors import EpibarError, is_address
from .colour_frames import ColourFrames
from .frame_range import FrameRange
from .images import IMAGE_SUFFIXES, natural_order, numbers_of
from .source import FrameSource, is_pattern

__all__ = ["ChapterFrames", "chapter_files", "colour_frames", "has_chapters"]

VIDEO_SUFFIXES = {
    *(".mp4", ".mov", ".m4v", ".3gp", ".avi", ".mkv", ".webm", ".wmv"),
    *(".mts", ".m2ts", ".ts", ".mpg", ".mpeg"),
}
RATES_APART = 0.01
"""Share by which announced frame rates of chapters may differ."""
GOPRO = re.compile(r"(?i)G[HXPLS](\d{2})(\d{4})")
"""Chapter and number of the film."""


def has_chapters(path: str | os.PathLike[str]) -> bool:
    """Whether a path is one of several files: a pattern with ``*`` or ``?``, or a folder of videos."""
    path = os.fspath(path)
    if is_address(path) or os.path.isfile(path):
        return False
    return is_pattern(path) or bool(_videos_in(path))


def _videos_in(path: str) -> list[Path]:
    """Videos in a folder, unless it holds images, which are a source by themselves."""
    if not os.path.isdir(path):
        return []
    files = [file for file in Path(path).iterdir() if file.is_file() and not file.name.startswith(".")]
    if any(file.suffix.lower() in IMAGE_SUFFIXES for file in files):
        return []
    return [file for file in files if file.suffix.lower() in VIDEO_SUFFIXES]


def chapter_files(path: str | os.PathLike[str]) -> list[Path]:
    """Files of one camera in the order in which they were filmed.

    Parameters
    ----------
    path : str or path
        A folder of videos, or a pattern with ``*`` or ``?``.

    Raises
    ------
    EpibarError
        There are none, their names tell no order, or a number is missing in between.
    """
    path = os.fspath(path)
    files = _videos_in(path)
    if not files and not os.path.isdir(path):
        found = (Path(name) for name in glob(path.replace("[", "[[]")))
        files = [file for file in found if file.is_file() and file.suffix.lower() in VIDEO_SUFFIXES]
    if not files:
        raise EpibarError(f"{path}: no videos of these names, so there is nothing to join as chapters")
    numbered = sorted((_number(file, files), natural_order(file), file) for file in files)
    for (before, _, first), (after, _, second) in pairwise(numbered):
        if before == after:
            raise EpibarError(
                f"{path}: {first.name} and {second.name} have the same number, so their order is not known"
            )
        if after != before + 1:
            raise EpibarError(
                f"{path}: between {first.name} and {second.name} numbers are missing; chapters must follow "
                "one another without a gap: add what is missing, or number them 1, 2, 3 if nothing is"
            )
    return [file for *_, file in numbered]


def _number(file: Path, files: list[Path]) -> int:
    """Number of a chapter: what differs between the names of all."""
    if len(files) == 1:
        return 1
    names = ", ".join(sorted(other.name for other in files)[:4])
    gopro = {other: found for other in files if (found := GOPRO.match(other.stem))}
    if len(gopro) == len(files):
        if len({found[2] for found in gopro.values()}) > 1:
            raise EpibarError(
                f"{file.parent}: {names}: different films, with a break between them; give the chapters of "
                "one, as in 'GX*0123.MP4'"
            )
        return int(gopro[file][1])
    numbers = numbers_of(files)
    if numbers is None:
        raise EpibarError(
            f"{file.parent}: {names}: their names tell no order; name chapters alike but for one number, "
            "such as cam1_1.mp4, cam1_2.mp4"
        )
    return numbers[files.index(file)]


class ChapterFrames(ColourFrames):
    """Colour frames of several files, one after the other; all else is as for :class:`ColourFrames`.

    Parameters
    ----------
    path : str or path
        As for :func:`chapter_files`.
    fps : float, optional
        Frames per second of all of them.
    frames : FrameRange, optional
        Which frames to use, counted over all files.

    Raises
    ------
    EpibarError
        As for :func:`chapter_files`; files of different sizes or frame rates; while iterating, one that
        is cut off, so that nobody knows when the next begins.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, fps: float | None = None, frames: FrameRange | None = None
    ) -> None:
        FrameSource.__init__(self, path, fps, frames)
        self.live = False
        self._images = None
        self._started = None
        self.files = chapter_files(self.path)
        counts: list[int | None] = []
        for file in self.files:
            # One at a time: decoders of large video are large.
            with ColourFrames(file, fps=fps) as chapter:
                if not counts:
                    (self.width, self.height), self.fps = chapter.size, chapter.fps
                    self.pixel_aspect = chapter.pixel_aspect
                self._check_chapter(chapter, file)
                counts.append(chapter.frame_count)
                for text in chapter.warnings:
                    self._warn(text)
        self._lengths = [count or 0 for count in counts]
        total = None if None in counts else sum(self._lengths)
        if total is not None:
            total = self._range.count(self.shown, total)
        self.frame_count = self._range.expected(total, self.fps)

    def _check_chapter(self, chapter: ColourFrames, file: Path) -> None:
        if chapter.size != self.size:
            raise EpibarError(
                f"{file}: {chapter.width}x{chapter.height}, but {self.files[0].name} is "
                f"{self.width}x{self.height}; chapters of one camera have one size"
            )
        if abs(chapter.fps / self.fps - 1) > RATES_APART:
            raise EpibarError(
                f"{file}: {chapter.fps:g} frames per second, but {self.files[0].name} has {self.fps:g}; "
                "chapters of one camera have one frame rate"
            )

    def __iter__(self) -> Iterator[tuple[int, float, Image]]:
        return self._range.in_time(self._iterate_chapters())

    def _iterate_chapters(self) -> Generator[tuple[int, float, Image], None, None]:
        number, start, used = 0, 0.0, 0
        zero: float | None = None
        for file in self.files:
            last = 0.0
            with ColourFrames(file, fps=self._given_fps) as chapter, closing(iter(chapter)) as moments:
                for _, seconds, frame in moments:
                    last = seconds
                    if number >= self.first:
                        self._check_size(frame.shape, f"{file}: frame {used}")
                        zero = start + seconds if zero is None else zero
                        yield used, start + seconds - zero, frame
                        used += 1
                    number += 1
                    if not self._range.holds(number):
                        self.frame_count = used
                        return
                for text in chapter.warnings:
                    self._warn(text)
                if chapter.truncated and file != self.files[-1]:
                    raise EpibarError(
                        f"{file}: it breaks off, so that nobody knows when the next chapter begins; copy it "
                        "again, or use the chapters before or after it alone"
                    )
                self.truncated = chapter.truncated
            start += last + 1.0 / self.fps
        if not used:
            raise self._range.beyond(self.shown, number)
        self.frame_count = used

    def sample(self, count: int) -> Iterator[Image]:
        """About ``count`` frames, from each chapter as many as it has a share of the frames that are used."""
        if self.frame_count is None:
            if self._range != FrameRange():  # nobody knows in which of them the part lies
                yield from (frame for _, _, frame in self)
                return
            end = math.inf
        else:
            end = self.first + self.frame_count
        used = []
        before = 0
        for file, length in zip(self.files, self._lengths, strict=True):
            first = max(0, self.first - before)
            last = int(min(length, end - before))
            before += length
            if not length:
                used.append((file, FrameRange(), 1))
            elif (first, last) == (0, length):
                used.append((file, FrameRange(), length))
            elif last > first:
                used.append((file, FrameRange(first, last), last - first))
        total = sum(frames for *_, frames in used)
        for file, part, frames in used:
            with ColourFrames(file, fps=self._given_fps, frames=part) as chapter:
                yield from chapter.sample(max(1, round(count * frames / total)))


def colour_frames(
    path: str | os.PathLike[str],
    fps: float | None = None,
    frames: FrameRange | None = None,
    chapters: bool = False,
) -> ColourFrames:
    """Open a source; with ``chapters`` a folder of videos or a pattern is one camera.

    Raises
    ------
    EpibarError
        As for :class:`ColourFrames`, or :class:`ChapterFrames`.
    """
    if has_chapters(path):
        if chapters:
            return ChapterFrames(path, fps=fps, frames=frames)
        raise EpibarError(
            f"{os.fspath(path)}: several videos; give --chapters (chapters=True) if they are one camera's, "
            "one after the other"
        )
    return ColourFrames(path, fps=fps, frames=frames)
