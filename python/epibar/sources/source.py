"""What every source of frames or masks has in common."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Generic, TypeVar

from ..arguments import is_number
from ..errors import EpibarError, address_without_secrets, is_address
from .frame_range import FrameRange

__all__ = ["DEFAULT_FPS", "FrameSource", "is_pattern", "source_name"]

DEFAULT_FPS = 25.0

T = TypeVar("T")


def is_pattern(source: str) -> bool:
    """Whether a path stands for several files: it holds ``*`` or ``?``, and there is no file of that name."""
    return re.search(r"[*?]", source) is not None and not is_address(source) and not os.path.exists(source)


def source_name(source: str) -> str:
    """Name of a camera that was given none: the file's without its suffix, or the folder's.

    Of a pattern it is what all names begin with, or else the folder's.
    Of an address it is the last part of the path, or else the host: never a user, a password or a key.
    """
    if not is_address(source):
        path = Path(source)
        if is_pattern(source):
            begin = re.split(r"[*?]", path.name)[0].strip("_-. ")
            return begin or Path(os.path.realpath(path)).parent.name
        return Path(os.path.realpath(path)).name if os.path.isdir(path) else path.stem
    place = address_without_secrets(source).partition("://")[2].rpartition("@")[2].partition("?")[0]
    host, _, rest = place.partition("/")
    last = Path(rest).stem if "=" not in rest else ""
    return re.sub(r"[^\w.-]+", "_", last or host.partition(":")[0]).strip("._") or "stream"


class FrameSource(Generic[T]):
    """What every source has: a name, a size, a rate, warnings and a way to be read from the start."""

    def __init__(
        self, path: str | os.PathLike[str], fps: float | None, frames: FrameRange | None = None
    ) -> None:
        if fps is not None and not (is_number(fps) and fps > 0):
            shown = address_without_secrets(os.fspath(path))
            raise EpibarError(f"{shown}: fps is {fps}; give a positive number of frames per second")
        self.path = os.fspath(path)
        self.shown = address_without_secrets(self.path)
        self.name = source_name(self.path)
        self.warnings: list[str] = []
        self.truncated = False
        self.pixel_aspect: float | None = None
        self.width = 0
        self.height = 0
        self.frame_count: int | None = None
        self.fps = DEFAULT_FPS
        self._given_fps = fps
        self._stated_fps: float | None = None
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
        stated = math.nan if announced is None else float(announced)
        self._stated_fps = stated if 0 < stated < 1e4 else None  # also None for NaN
        if self._given_fps is not None:
            self.fps = float(self._given_fps)
        elif self._stated_fps is not None:
            self.fps = self._stated_fps
        else:
            self.fps = DEFAULT_FPS
            self._warn(
                f"{self.shown}: no frame rate given, {DEFAULT_FPS:g} frames per second assumed; if it is "
                "another one clocks cannot agree: give --fps (fps=), or fps to the .npz of masks"
            )

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
