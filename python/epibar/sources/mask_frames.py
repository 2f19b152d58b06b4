"""Masks that are ready, from an array, a video or images."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from ..arguments import Mask
from .chapters import colour_frames
from .colour_frames import ColourFrames
from .frame_range import FrameRange
from .mask_array_file import ARRAY_SUFFIXES, MaskArrayFile
from .source import FrameSource

__all__ = ["MaskFrames"]

LOOKED_AT = 10
"""First frames that tell whether a video is one of masks."""
MOST_BETWEEN = 0.4
"""Share of pixels that may be neither dark nor bright: outlines, after compression, and shadows are."""


class MaskFrames(FrameSource[Mask]):
    """Ready-made masks, with the same iteration as :class:`ColourFrames`.

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
        As for :class:`ColourFrames`.
    chapters : bool
        A folder of videos, or a pattern, is one camera, see :func:`~epibar.sources.chapters.colour_frames`.

    Raises
    ------
    EpibarError
        As for :class:`ColourFrames`; a missing key, a wrong rank or dtype, no frames.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        fps: float | None = None,
        frames: FrameRange | None = None,
        chapters: bool = False,
    ) -> None:
        super().__init__(path, fps, frames)
        self._frames: ColourFrames | None = None
        if Path(self.path).suffix.lower() in ARRAY_SUFFIXES and not Path(self.path).is_dir():
            self._open_array()
        else:
            self._frames = colour_frames(path, fps, frames, chapters)
            self.name, self.fps = self._frames.name, self._frames.fps
            self.width, self.height = self._frames.size
            self.frame_count = self._frames.frame_count
            self.pixel_aspect = self._frames.pixel_aspect
            self.warnings = self._frames.warnings

    def _open_array(self) -> None:
        self._array = MaskArrayFile(self.path)
        total, self.height, self.width = self._array.shape
        self.frame_count = self._range.count(self.shown, total)
        self._choose_fps(self._array.fps)
        self.frame_count = self._range.expected(self.frame_count, self.fps)

    def __iter__(self) -> Iterator[tuple[int, float, Mask]]:
        if self._frames is not None:
            return self._iterate_frames(self._frames)
        return self._range.in_time(self._iterate_array(self._array))

    def _iterate_array(self, array: MaskArrayFile) -> Generator[tuple[int, float, Mask], None, None]:
        expected = self._range.count(self.shown, array.shape[0])
        found = 0
        for found, mask in enumerate(islice(array, self.first, self.first + expected), 1):
            yield found - 1, (found - 1) / self.fps, mask
        if found < expected:
            self.truncated = True
            self._warn(f"{self.shown}: truncated, read {found} of {expected} frames; those are used")
        self.frame_count = found

    def _iterate_frames(self, frames: ColourFrames) -> Iterator[tuple[int, float, Mask]]:
        brightest, moving = 0, False
        between: list[float] = []
        for index, time, frame in frames:
            grey = frame.max(axis=2)
            if index < LOOKED_AT:
                between.append(float(np.mean((grey > 64) & (grey < 192))))
            peak = int(grey.max())
            binary = peak <= 1 and frames.of_images
            mask = (grey > (0 if binary else 127)).astype(np.uint8)
            brightest, moving = max(brightest, peak), moving or bool(mask.any())
            yield index, time, mask
        self.frame_count, self.truncated = frames.frame_count, frames.truncated
        if between and np.mean(between) > MOST_BETWEEN:
            self._warn(
                f"{self.shown}: not black and white, {100 * np.mean(between):.0f} % of its pixels are "
                "neither dark nor bright; if it is a colour video, give it without --masks (masks=True)"
            )
        if brightest and not moving:
            found = f"no pixel is brighter than 127 (the brightest is {brightest})"
            self._warn(f"{self.shown}: {found}; save masks as 0 and 255")

    def close(self) -> None:
        """Release the file."""
        if self._frames is not None:
            self._frames.close()
