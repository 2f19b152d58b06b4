"""Options of the foreground: how masks are made."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ..arguments import Mask, as_whole_number, check_between, check_choice
from ..errors import EpibarError

__all__ = ["METHODS", "ForegroundMethod", "ForegroundOptions"]

ForegroundMethod = Literal["auto", "mog2", "mixture", "knn", "median"]
"""Which background model; :class:`ForegroundOptions` says what each is."""

METHODS: tuple[ForegroundMethod, ...] = get_args(ForegroundMethod)


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

    method: ForegroundMethod = "auto"
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
        check_choice("foreground method", self.method, METHODS)
        as_whole_number("warm_up", self.warm_up, 1)
        as_whole_number("memory", self.memory, 1)
        check_between("min_area", self.min_area, 0, 1, "a share of the image, from 0 to below 1")
        for name in ("median_filter", "closing"):
            check_between(name, getattr(self, name), 0, 100, "0 (off) or more, and below 100 pixels")
        check_between("threshold", self.threshold, 0, float("inf"), "positive, or 0 for the method's default")
        if self.ignore is not None and np.ndim(self.ignore) != 2:
            raise EpibarError(f"ignore mask has shape {np.shape(self.ignore)}, expected (height, width)")
