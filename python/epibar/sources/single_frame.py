"""One frame of a source, for a picture."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..arguments import AnyArray
from ..errors import EpibarError, is_address
from .colour_frames import ColourFrames
from .mask_array_file import ARRAY_SUFFIXES
from .mask_frames import MaskFrames

__all__ = ["read_frame"]


def read_frame(path: str | os.PathLike[str], index: int = 0) -> AnyArray:
    """One frame, for a picture.

    Parameters
    ----------
    path : str or path
        As for :class:`ColourFrames`; or an ``.npz`` or ``.npy`` array of masks, which comes back black and
        white.
    index : int
        Frame number from 0, reached by decoding from the start: not every container seeks exactly.

    Returns
    -------
    ndarray, shape (H, W, 3), uint8
        BGR.

    Raises
    ------
    EpibarError
        The source cannot be read, is an address, or has no such frame.
    """
    path = os.fspath(path)
    if is_address(path):
        raise EpibarError(f"{path}: what an address showed cannot be shown again")
    if index < 0:
        raise EpibarError(f"{path}: frame {index} asked for; frames count from 0")
    if Path(path).suffix.lower() in ARRAY_SUFFIXES:
        with MaskFrames(path) as masks:
            for number, _, mask in masks:
                if number == index:
                    return np.repeat(mask[:, :, None] * np.uint8(255), 3, axis=2)
            raise EpibarError(f"{path}: frame {index} asked for, but it has {masks.frame_count} frames")
    with ColourFrames(path) as frames:
        result: AnyArray = frames.read(index)
        return result
