"""Frames and ready-made masks, streamed from whatever a user has.

A source is a video file, a folder of images, a stream or numbered-image pattern that OpenCV opens, or (masks
only) an ``.npz`` or ``.npy`` array. Every source is read from start to end in bounded memory and may be read
again: each ``iter()`` starts at frame 0. Frames count from 0; times are seconds since frame 0.

What is wrong but bearable (a truncated file, no frame rate, dropped frames) goes to ``warnings``; what is not
raises :class:`~epibar.errors.EpibarError`.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from .errors import EpibarError
from .frame_source import DEFAULT_FPS
from .frames import Frames
from .mask_array import ARRAY_SUFFIXES
from .mask_frames import MaskFrames
from .prefetch import prefetched

__all__ = ["DEFAULT_FPS", "Frames", "MaskFrames", "prefetched", "read_frame"]


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
        return frames.read(index)
