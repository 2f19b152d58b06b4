"""The empty scene, estimated from frames that people walk through.

A temporal median is right only where the background shows in more than half of the frames. Background repeats
itself exactly and people do not, so at each pixel the compiled core takes the shortest interval that holds a
quarter of the samples (a robust estimate of the mode, after the *shorth*) and averages the samples in it:
background that shows in a quarter of the frames can be enough.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .. import _core
from ..arguments import AnyArray, Image, Mask, core_errors
from ..errors import EpibarError

__all__ = ["collect", "median_background", "samples_in_memory", "seen_to_be_dark", "steady_background"]

MEMORY_BYTES = 256 * 2**20
STRIP_ROWS = 32
DARK = 24
"""Level that pixels beside a picture stay below: black is 0 or 16, and compression adds to it."""


def samples_in_memory(limit: int, frame_bytes: int, memory: int = MEMORY_BYTES) -> int:
    """Return how many of ``limit`` frames :func:`collect` keeps, so that no others need be decoded."""
    while limit > _most(limit, frame_bytes, memory):
        limit = (limit + 1) // 2
    return limit


def _most(limit: int, frame_bytes: int, memory: int) -> int:
    return max(5, min(limit, memory // frame_bytes))


def collect(frames: Iterable[Image], limit: int, memory: int = MEMORY_BYTES) -> AnyArray:
    """Keep up to ``limit`` frames, evenly spread over a stream of unknown length, in bounded memory.

    When full, every second frame is dropped and from then on half as many are taken.

    Returns
    -------
    ndarray, shape (N, H, W, 3), uint8

    Raises
    ------
    EpibarError
        No frames, or frames of two sizes.
    """
    kept: AnyArray = np.empty(0, np.uint8)
    count, stride = 0, 1
    for index, frame in enumerate(frames):
        if index == 0:  # memory is taken when it is written to
            kept = np.empty((_most(limit, frame.nbytes, memory) + 1, *frame.shape), np.uint8)
        elif frame.shape != kept.shape[1:]:
            height, width = kept.shape[1:3]
            raise EpibarError(
                f"background: a frame of {frame.shape[1]}x{frame.shape[0]} after frames of {width}x{height}"
            )
        if index % stride:
            continue
        kept[count] = frame
        count += 1
        if count == len(kept):
            count = (count + 1) // 2
            for place in range(count):
                kept[place] = kept[2 * place]
            stride *= 2
    if not count:
        raise EpibarError("background: no frames to learn the background from")
    return kept[:count]


def steady_background(samples: AnyArray) -> Image:
    """Return the most repeated value of each pixel.

    Parameters
    ----------
    samples : ndarray, shape (N, H, W, 3), uint8
        Frames spread over time.

    Returns
    -------
    ndarray, shape (H, W, 3), uint8
    """
    if len(samples) < 3:
        result: AnyArray = samples[0].copy()
        return result
    with core_errors():
        return _core.steady_background(np.ascontiguousarray(samples))


def seen_to_be_dark(samples: AnyArray) -> Mask:
    """Tell which pixels of (N, H, W, 3) uint8 samples are dark in all of them, (H, W) bool."""
    dark: Mask = samples.max(axis=0).max(axis=2) < DARK
    return dark


def median_background(samples: AnyArray) -> Image:
    """Return the temporal median of (N, H, W, 3) uint8 samples, the upper of two middles."""
    middle = len(samples) // 2
    strips = [
        np.partition(samples[:, top : top + STRIP_ROWS], middle, axis=0)[middle]
        for top in range(0, samples.shape[1], STRIP_ROWS)
    ]
    return np.concatenate(strips)
