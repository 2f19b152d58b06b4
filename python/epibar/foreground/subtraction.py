"""Background subtraction, streamed: a model of the empty scene, and the cleaning of the mask it gives.

Models: MOG2's mixture (Zivkovic 2004) in the compiled core, the default; MOG2 and KNN (Zivkovic and van der
Heijden 2006) from OpenCV with their shadow test; and a selective temporal median with the HSV shadow test of
Cucchiara et al. 2003.

A model must know the empty scene before frame 0, or the first seconds are lost. So it is *primed* with frames
spread over the whole video, or with a background clip, in which everything far from
:func:`steady_background` is painted over: nobody is learnt who does not stand still for most of the video.
Afterwards it learns slowly.

Pitfalls: who never moves during the whole video is background, and a clip of the empty scene is the cure.
Frames are not smoothed first: it makes every silhouette 1-2 pixels fatter, and the median filter removes the
noise as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from .. import _core
from ..arguments import AnyArray, Image, Mask, core_errors
from ..errors import EpibarError
from ..sources.colour_frames import ColourFrames
from .background_models import FLOOD_LEARNING_RATE, BackgroundModel, MixtureModel, new_model
from .empty_scene import DARK, collect, samples_in_memory, seen_to_be_dark, steady_background
from .flooding import FLOOD_SHARE, moving_share
from .options import ForegroundOptions

__all__ = ["Foreground"]

REFERENCE_HEIGHT = 480.0
FLOOD_PATIENCE = 3  # flooded frames in a row before the model learns anew
FLICKER = 30
"""Grey levels by which a sample may differ from the background where nobody is."""
LEAST_LEARNED = 20
"""Samples that a model learns from; fewer ones come again."""
LEAST_DARK = 0.02
"""Share of the image that is always dark below which nothing stands beside a picture."""
LEAST_COUNTED, LIT = 0.25, 0.8
"""Share of the image that a picture beside dark parts fills at least, and of it whose background is lit."""


class Foreground:
    """Masks of what moves in the frames of one stationary camera, one frame at a time.

    Parameters
    ----------
    options : ForegroundOptions, optional

    Attributes
    ----------
    counted : ndarray, shape (H, W), bool, or None
        Where something can be seen to move: not ignored, and not always dark. None is everywhere.

    Examples
    --------
    >>> with ColourFrames("cam1.mp4") as frames:
    ...     foreground = Foreground.for_frames(frames)
    ...     for index, time, frame in frames:
    ...         mask = foreground.apply(frame)
    """

    def __init__(self, options: ForegroundOptions | None = None) -> None:
        self.options = options or ForegroundOptions()
        self.background: Image | None = None
        self._model: BackgroundModel | None = None
        self._hidden: Mask | None = None
        self.counted: Mask | None = None
        self._size: tuple[int, int] | None = None
        self._learned = 0
        self._primed = False
        self._flooded = 0
        slow = 10 if self.options.background is not None else 1
        self._rate = 1.0 / (slow * self.options.memory)

    @classmethod
    def for_frames(cls, frames: ColourFrames, options: ForegroundOptions | None = None) -> Foreground:
        """Return a model primed from the background clip if there is one, or else from all of ``frames``."""
        foreground = cls(options)
        clip = foreground.options.background
        count = samples_in_memory(foreground.options.warm_up, 3 * frames.width * frames.height)
        if clip is None:
            foreground.prime(frames.sample(count))
            return foreground
        with ColourFrames(clip) as empty:
            if empty.size != frames.size:
                raise EpibarError(
                    f"{empty.path}: {empty.width}x{empty.height}, but {frames.path} is "
                    f"{frames.width}x{frames.height}; film the background with the same camera and settings"
                )
            foreground.prime(empty.sample(count))
        return foreground

    def prime(self, frames: Iterable[Image]) -> None:
        """Learn the empty scene before the first frame.

        Parameters
        ----------
        frames : iterable of ndarray, shape (H, W, 3), uint8
            BGR frames spread over time; people in them are painted over.

        Raises
        ------
        EpibarError
            No frames, or frames of two sizes.
        """
        samples = collect((self._checked(frame) for frame in frames), self.options.warm_up)
        size = self._set_size(samples[0])
        self.background = steady_background(samples)
        self._leave_out(samples, self.background)
        self._paint(samples, self.background)
        self._model = model = new_model(self.options, size)
        # MOG2 weighs late samples a little more, so their order must not be that of time.
        order = np.random.default_rng(0).permutation(len(samples)).tolist()
        order = [order[number % len(order)] for number in range(max(len(order), LEAST_LEARNED))]
        if isinstance(model, MixtureModel):
            model.prime(samples, order)
        else:
            for number, sample in enumerate(order):
                model.learn(samples[sample], number)
        self._primed = True

    def _leave_out(self, samples: AnyArray, background: Image) -> None:
        """Count no pixels that are always dark, as those beside a round or a narrow picture are.

        Before a dark background all count: what is not always dark there is where something moves.
        """
        import cv2

        # What is always dark has a dark background, so few of those say enough, and are quickly counted.
        of_dark = cv2.inRange(background, (0, 0, 0), (DARK - 1, DARK - 1, DARK - 1))
        if cv2.countNonZero(of_dark) <= LEAST_DARK * of_dark.size:
            return
        dark = seen_to_be_dark(samples)
        counted = ~dark if self.counted is None else self.counted & ~dark
        left = np.count_nonzero(counted)
        lit = np.count_nonzero(counted & (background.max(axis=2) >= DARK))
        if (
            np.count_nonzero(dark) > LEAST_DARK * dark.size
            and left > LEAST_COUNTED * dark.size
            and lit > LIT * left
        ):
            self.counted = counted

    def _paint(self, samples: AnyArray, background: Image) -> None:
        """Replace people in samples by background; flicker, which is small, stays to be learnt."""
        with core_errors():
            _core.paint_over(
                samples,
                np.ascontiguousarray(background),
                FLICKER,
                self._cleaning(background[..., 0].size),
                2 * self._odd(2.0) + 1,
            )

    def apply(self, frame: Image) -> Mask:
        """Return the mask of the next frame.

        Parameters
        ----------
        frame : ndarray, shape (H, W, 3), uint8
            BGR.

        Returns
        -------
        ndarray, shape (H, W), uint8
            1 where something moves, 0 elsewhere.

        Raises
        ------
        EpibarError
            The frame's size or type differs from what came before, or from the ignore mask.
        """
        return self._cleaned(self.moving(frame))

    def moving(self, frame: Image) -> Mask:
        """Return the mask of the next frame before it is cleaned; all else is as for :meth:`apply`."""
        size = self._set_size(self._checked(frame))
        if self._model is None:
            self._model = new_model(self.options, size)
        if not self._primed and self._learned < self.options.warm_up:
            self._model.learn(frame, self._learned)
            self._learned += 1
            return np.zeros(frame.shape[:2], np.uint8)
        rate = FLOOD_LEARNING_RATE if self._flooded >= FLOOD_PATIENCE else self._rate
        moving = self._model.moving(frame, rate)
        self._flooded = self._flooded + 1 if moving_share(moving, self.counted) > FLOOD_SHARE else 0
        return moving

    def clean(self, mask: Mask) -> Mask:
        """Clean a ready mask as the model's own are: median filter, closing, area filter, ignore mask.

        Parameters
        ----------
        mask : ndarray, shape (H, W), bool or uint8
            Non-zero where something moves.

        Returns
        -------
        ndarray, shape (H, W), uint8
            1 where something moves, 0 elsewhere.

        Raises
        ------
        EpibarError
            The mask is of another kind, or of another size than what came before.
        """
        if mask.ndim != 2 or mask.dtype not in (np.bool_, np.uint8):
            raise EpibarError(
                f"a mask must be a (height, width) bool or uint8 image, not {mask.dtype} {mask.shape}"
            )
        self._set_size(mask)
        return self._cleaned((mask != 0).astype(np.uint8))

    def _set_size(self, frame: Image) -> tuple[int, int]:
        height, width = frame.shape[:2]
        if self._size is None:
            self._size = width, height
            ignore = self.options.ignore
            if ignore is not None and ignore.shape != (height, width):
                raise EpibarError(
                    f"ignore mask: {ignore.shape[1]}x{ignore.shape[0]}, but the frames are {width}x{height}"
                )
            self._hidden = None if ignore is None else np.ascontiguousarray(ignore != 0, np.uint8)
            self.counted = None if ignore is None else np.asarray(ignore) == 0
        elif self._size != (width, height):
            raise EpibarError(f"a frame of {width}x{height} after frames of {self._size[0]}x{self._size[1]}")
        return width, height

    def _odd(self, size: float) -> int:
        """Convert a size at 480 lines to an odd number of pixels of this image; 1 does nothing."""
        lines = self._size[1] if self._size else REFERENCE_HEIGHT
        return max(1, 2 * round((size * lines / REFERENCE_HEIGHT - 1) / 2) + 1) if size else 1

    @staticmethod
    def _checked(frame: Any) -> Image:
        if (
            not isinstance(frame, np.ndarray)
            or frame.dtype != np.uint8
            or frame.ndim != 3
            or frame.shape[2] != 3
        ):
            found = f"{frame.dtype} {frame.shape}" if isinstance(frame, np.ndarray) else type(frame).__name__
            raise EpibarError(f"a frame must be a (height, width, 3) uint8 BGR image, not {found}")
        return frame

    def _cleaned(self, mask: Mask) -> Mask:
        with core_errors():
            return _core.clean_mask(np.ascontiguousarray(mask), *self._cleaning(mask.size), self._hidden)

    def _cleaning(self, pixels: int) -> tuple[int, int, int]:
        """Diameters of median filter and closing, and the least area, in an image of so many pixels."""
        least = math.ceil(self.options.min_area * pixels)
        return self._odd(self.options.median_filter), self._odd(self.options.closing), least
