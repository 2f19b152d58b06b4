"""Background models: MOG2 and KNN of OpenCV, a mixture of our own, and a selective temporal median.

MOG2: Zivkovic 2004. KNN: Zivkovic and van der Heijden 2006. The mixture has MOG2's equations, and rows that
learn in turn. The median has the HSV shadow test of Cucchiara et al. 2003.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from .. import _core
from ..arguments import AnyArray, Image, Mask, core_errors
from .empty_scene import median_background
from .options import ForegroundOptions

__all__ = ["FLOOD_LEARNING_RATE", "BackgroundModel", "largest_difference", "new_model"]

FLOOD_LEARNING_RATE = 0.05
"""At this rate or above what is seen is taken for a new background."""

MOG2_THRESHOLD = 80.0
"""Squared distance in variances. At OpenCV's 16, and up to 40, noise frays the outlines: more of them meet
in the other view at 80, of real videos, and at 140 those of some are lost again."""


class BackgroundModel(Protocol):
    """What tells moving pixels from background, one (H, W, 3) uint8 BGR frame at a time."""

    def learn(self, frame: Image, number: int) -> None:
        """Take a frame of the empty scene; ``number`` counts them from 0."""

    def moving(self, frame: Image, rate: float) -> Mask:
        """Mask of the next frame, (H, W) uint8 of 0 and 1; learn from it at a rate between 0 and 1."""


class OpenCvModel:
    """MOG2 or KNN of OpenCV; their mask is 0, 127 (shadow) or 255."""

    def __init__(self, options: ForegroundOptions) -> None:
        import cv2

        self._model: Any
        self._is_knn = options.method == "knn"
        if self._is_knn:
            threshold = options.threshold or 400.0
            self._model = cv2.createBackgroundSubtractorKNN(options.warm_up, threshold, options.shadows)
        else:
            threshold = options.threshold or MOG2_THRESHOLD
            self._model = cv2.createBackgroundSubtractorMOG2(500, threshold, options.shadows)
            # A new thing becomes background when it has shown for 40 % of the memory, not for 10 %.
            self._model.setBackgroundRatio(0.6)
        self._model.setShadowThreshold(0.4)

    def learn(self, frame: Image, number: int) -> None:
        # 1 / (n + 1) weighs all samples alike; KNN counts by itself.
        self._model.apply(frame, learningRate=-1 if self._is_knn else 1.0 / (number + 1))

    def moving(self, frame: Image, rate: float) -> Mask:
        result: AnyArray = (self._model.apply(frame, learningRate=rate) == 255).astype(np.uint8)
        return result


class MixtureModel:
    """MOG2's mixture in the compiled core: where a rate is low, each row learns from every 17th frame."""

    def __init__(self, options: ForegroundOptions, size: tuple[int, int]) -> None:
        with core_errors():
            self._model = _core.Mixture(*size, options.threshold or MOG2_THRESHOLD, options.shadows)

    def learn(self, frame: Image, number: int) -> None:
        self._model.learn(np.ascontiguousarray(frame), 1.0 / (number + 1))

    def prime(self, samples: AnyArray, order: Sequence[int]) -> None:
        """Do what :meth:`learn` does with samples, (N, H, W, 3) uint8, in an order, several times as fast."""
        with core_errors():
            self._model.prime(np.ascontiguousarray(samples), order)

    def moving(self, frame: Image, rate: float) -> Mask:
        return self._model.look(np.ascontiguousarray(frame), rate)


class MedianModel:
    """Selective temporal median, and the shadow test of Cucchiara et al. 2003, equation (6)."""

    SAMPLES, INTERVAL, REFRESH = 25, 25, 10
    DARKEST, LIGHTEST = 0.4, 0.95  # α and β: the brightness of a shadow, as a share of the background's
    SATURATION, HUE = 50, 20  # τS of 255 and τH of 180

    def __init__(self, options: ForegroundOptions) -> None:
        self._difference = (options.threshold or 625.0) ** 0.5
        self._shadows = options.shadows
        self._interval = max(1, round(options.memory / (2 * self.SAMPLES * self.INTERVAL)) * self.INTERVAL)
        self._samples: deque[AnyArray] = deque(maxlen=self.SAMPLES)
        self._seen = self._taken = 0
        self._background: Image | None = None

    def learn(self, frame: Image, number: int) -> None:
        self._samples.append(frame.copy())
        self._background = None

    def _refresh(self) -> Image:
        import cv2

        self._background = median_background(np.stack(self._samples))
        self._hsv = cv2.cvtColor(self._background, cv2.COLOR_BGR2HSV).astype(np.int16)
        return self._background

    def moving(self, frame: Image, rate: float) -> Mask:
        background = self._refresh() if self._background is None else self._background
        moving = largest_difference(frame, background) > self._difference
        if self._shadows:
            moving &= ~self._shadow(frame)
        self._update(frame, moving, rate)
        result: AnyArray = moving.astype(np.uint8)
        return result

    def _shadow(self, frame: Image) -> Mask:
        import cv2

        hsv = cv2.cvtColor(frame, cv2.COLOR_BGR2HSV).astype(np.int16)
        value, ground = hsv[..., 2], self._hsv[..., 2]
        hue = np.abs(hsv[..., 0] - self._hsv[..., 0])
        result: AnyArray = (
            (value >= self.DARKEST * ground)
            & (value <= self.LIGHTEST * ground)
            & (np.abs(hsv[..., 1] - self._hsv[..., 1]) <= self.SATURATION)
            & (np.minimum(hue, 180 - hue) <= self.HUE)
        )
        return result

    def _update(self, frame: Image, moving: Mask, rate: float) -> None:
        self._seen += 1
        if rate >= FLOOD_LEARNING_RATE:
            if self._samples.maxlen == self.SAMPLES:
                self._samples = deque(maxlen=9)
            self._samples.append(frame.copy())
            self._refresh()
            return
        if self._samples.maxlen != self.SAMPLES:
            self._samples = deque(self._samples, maxlen=self.SAMPLES)
        if self._seen % self._interval == 0 and self._background is not None:
            self._samples.append(np.where(moving[..., None], self._background, frame))
            self._taken += 1
            if self._taken % self.REFRESH == 0:
                self._refresh()


def largest_difference(frame: Image, background: Image) -> AnyArray:
    """Return the largest absolute difference of the three channels at each pixel, (H, W) uint8."""
    import cv2

    blue, green, red = cv2.split(cv2.absdiff(frame, background))
    return cv2.max(cv2.max(blue, green), red)


def new_model(options: ForegroundOptions, size: tuple[int, int]) -> BackgroundModel:
    """Make the model that the options name, for frames of a width and height; it knows nothing yet."""
    if options.method == "median":
        return MedianModel(options)
    if options.method in ("auto", "mixture"):
        return MixtureModel(options, size)
    return OpenCvModel(options)
