"""The empty scene, estimated from frames that people walk through.

A temporal median is right only where the background shows in more than half of the frames. Background repeats
itself exactly and people do not, so at each pixel we take the shortest interval that holds a quarter of the
samples (a robust estimate of the mode, after the *shorth*) and average the samples in it: background that
shows in a quarter of the frames can be enough.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..errors import EpibarError

__all__ = ["collect", "median_background", "steady_background"]

STEADY_SHARES = (0.25, 0.375, 0.5, 0.625)
"""The first must be there; a larger one that agrees nearly as well wins over somebody who stood still."""
MEMORY_BYTES = 256 * 2**20
STRIP_ROWS = 32


def collect(frames: Iterable[np.ndarray], limit: int, memory: int = MEMORY_BYTES) -> np.ndarray:
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
    kept: list[np.ndarray] = []
    stride = 1
    for index, frame in enumerate(frames):
        if kept and frame.shape != kept[0].shape:
            height, width = kept[0].shape[:2]
            raise EpibarError(
                f"background: a frame of {frame.shape[1]}x{frame.shape[0]} after frames of {width}x{height}"
            )
        if index % stride:
            continue
        kept.append(frame)
        if len(kept) > max(5, min(limit, memory // frame.nbytes)):
            kept = kept[::2]
            stride *= 2
    if not kept:
        raise EpibarError("background: no frames to learn the background from")
    return np.stack(kept)


def steady_background(samples: np.ndarray) -> np.ndarray:
    """Return the most repeated value of each pixel.

    Parameters
    ----------
    samples : ndarray, shape (N, H, W, 3), uint8
        Frames spread over time.

    Returns
    -------
    ndarray, shape (H, W, 3), uint8
    """
    count = len(samples)
    if count < 3:
        result: np.ndarray = samples[0].copy()
        return result
    strips = [samples[:, top : top + STRIP_ROWS] for top in range(0, samples.shape[1], STRIP_ROWS)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # sorting releases the interpreter
        return np.concatenate(list(pool.map(_steady_strip, strips)))


def _steady_strip(strip: np.ndarray) -> np.ndarray:
    """Most repeated value of each pixel of some rows, (N, rows, W, 3): (rows, W, 3)."""
    blue, green, red = (strip[..., channel].astype(np.uint16) for channel in range(3))
    grey = ((blue + 2 * green + red) >> 2).astype(np.uint8)
    ordered = np.sort(grey, axis=0)
    low, high = _steady_range(ordered)
    inside = (grey >= low) & (grey <= high)
    total = np.einsum("nyxc,nyx->yxc", strip, inside, dtype=np.float32, casting="unsafe")
    mean: np.ndarray = np.rint(total / inside.sum(axis=0)[..., None])
    return mean.astype(np.uint8)


def _steady_range(ordered: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest grey level, (H, W) uint8, that count as background in sorted (N, H, W) samples."""
    count = len(ordered)
    for number, share in enumerate(STEADY_SHARES):
        window = min(count, max(2, round(count * share)))
        widths = ordered[window - 1 :] - ordered[: count - window + 1]
        start = widths.argmin(axis=0)[None]
        width = np.take_along_axis(widths, start, axis=0)[0].astype(np.int16)
        lowest = np.take_along_axis(ordered, start, axis=0)[0]
        if number == 0:
            low, narrowest, chosen = lowest, width, width
            continue
        as_good = width <= 3 * narrowest + 6  # 2.8 times is what the noise alone gives at 62.5 %
        low, chosen = np.where(as_good, lowest, low), np.where(as_good, width, chosen)
    return low, (low + chosen).astype(np.uint8)


def median_background(samples: np.ndarray) -> np.ndarray:
    """Return the temporal median of (N, H, W, 3) uint8 samples, the upper of two middles."""
    middle = len(samples) // 2
    strips = [
        np.partition(samples[:, top : top + STRIP_ROWS], middle, axis=0)[middle]
        for top in range(0, samples.shape[1], STRIP_ROWS)
    ]
    return np.concatenate(strips)
