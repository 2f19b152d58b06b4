"""Options of the foreground: how masks are made."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from ..arguments import Mask
from ..errors import EpibarError

__all__ = ["METHODS", "ForegroundOptions"]

METHODS = ("auto", "mog2", "mixture", "knn", "median")


@dataclass(frozen=True)
class ForegroundOptions:
    """How masks are made. Sizes are pixels in an image 480 lines high and grow with the image.

    Parameters
    ----------
    method : {"auto", "mog2", "mixture", "knn", "median"}
        Background model. "mixture" is MOG2 with rows that learn in turn, several times as fast as OpenCV's
        "mog2", with silhouettes as good; it is what "auto" takes.
    warm_up : int
        Frames that teach the model: the number sampled over the video when primed, or else the number of
        first frames whose masks stay empty.
    shadows : bool
        Drop what is only darker than the background.
    ignore : ndarray, shape (H, W), optional
        Non-zero where motion does not count: a clock in the picture, a screen, trees.
    median_filter, closing : float
        Diameter of the median filter that removes specks and of the closing that joins parts; 0 switches off.
    min_area : float
        Components below this share of the image are removed.
    threshold : float
        Squared distance to the background, in variances (MOG2, mixture) or grey levels (KNN, median); 0 is
        the method's default: 80, 400, 625.
    memory : int
        Frames over which the model adapts to slow changes. With a background clip ten times as slow.
    background : str or path, optional
        Video, picture or folder of the empty scene.
    """

    method: str = "auto"
    warm_up: int = 60
    shadows: bool = True
    ignore: Mask | None = None
    median_filter: float = 5.0
    closing: float = 7.0
    min_area: float = 0.0005
    threshold: float = 0.0
    memory: int = 2000
    background: str | os.PathLike[str] | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise EpibarError(f"foreground method {self.method!r}: choose one of {', '.join(METHODS)}")
        if self.warm_up < 1 or self.memory < 1:
            raise EpibarError(
                f"warm_up is {self.warm_up}, memory is {self.memory}: both must be at least 1 frame"
            )
        if not 0 <= self.min_area < 1:
            raise EpibarError(f"min_area is {self.min_area}: it is a share of the image, from 0 to below 1")
        if not all(0 <= value < 100 for value in (self.median_filter, self.closing)):
            raise EpibarError(
                f"median_filter {self.median_filter}, closing {self.closing}: 0 (off) to 100 pixels"
            )
        if not 0 <= self.threshold < float("inf"):
            raise EpibarError(
                f"threshold is {self.threshold}: it must be positive, or 0 for the method's default"
            )
        if self.ignore is not None and np.ndim(self.ignore) != 2:
            raise EpibarError(f"ignore mask has shape {np.shape(self.ignore)}, expected (height, width)")
