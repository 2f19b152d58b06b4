"""Motion barcodes of lines in masks, and matching them between two cameras: the paper's first two steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from .arguments import AnyArray, Array, Index, PackedBits, as_masks, as_whole_number, core_errors
from .errors import EpibarError

__all__ = ["barcodes", "match_barcodes"]


def barcodes(masks: AnyArray, segments: ArrayLike) -> PackedBits:
    """Motion barcode of each line: for each frame one bit, set where the line crosses a moving pixel.

    Parameters
    ----------
    masks : ndarray, shape (T, H, W), bool or uint8
        Non-zero where something moves.
    segments : array_like, shape (n, 4)
        End points (x0, y0, x1, y1) of each line, pixels.

    Returns
    -------
    ndarray, shape (n, ceil(T / 64)), uint64
        Bit ``i % 64`` of word ``i // 64`` is frame ``i``.

    Raises
    ------
    EpibarError
        Wrong rank, dtype or shape, or a coordinate that is not finite.

    Examples
    --------
    >>> import numpy as np, epibar
    >>> masks = np.zeros((3, 4, 5), np.uint8)
    >>> masks[1, 2, 3] = 1
    >>> epibar.barcodes(masks, [[0, 2, 4, 2]]).tolist()
    [[2]]
    """
    stack = as_masks(masks)
    try:
        lines = np.ascontiguousarray(segments, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise EpibarError("segments hold what is no number, expected (n, 4): x0, y0, x1, y1") from None
    if lines.ndim != 2 or lines.shape[1] != 4:
        raise EpibarError(f"segments have shape {lines.shape}, expected (n, 4): x0, y0, x1, y1")
    if not np.isfinite(lines).all():
        raise EpibarError("segments hold a coordinate that is not finite")
    with core_errors():
        return _core.barcodes(stack, lines)


def match_barcodes(
    bits_a: ArrayLike, bits_b: ArrayLike, frames: int, mutual: int = 3, limit: int = 1000
) -> tuple[Index, Index, Array]:
    """Pairs of lines, each among the best matches of the other, by correlation of their motion barcodes.

    Parameters
    ----------
    bits_a, bits_b : array_like, shapes (n_a, words) and (n_b, words), uint64
        Packed barcodes of the lines of each camera, from :func:`barcodes`, on one common time line.
    frames : int
        Number of frames, at most ``64 * words``.
    mutual : int
        Each line of a pair is among this many best matches of the other.
    limit : int
        At most this many pairs, the best ones.

    Returns
    -------
    index_a, index_b : ndarray, shape (m,), int64
        Rows of ``bits_a`` and ``bits_b``.
    correlation : ndarray, shape (m,)
        Pearson correlation of the two barcodes, falling.

    Raises
    ------
    EpibarError
        Arrays of different widths, or a number out of its range.
    """
    packed = []
    for name, bits in (("bits_a", bits_a), ("bits_b", bits_b)):
        array = np.asarray(bits)
        if array.ndim != 2 or array.dtype != np.uint64:
            raise EpibarError(
                f"{name}: shape {array.shape}, dtype {array.dtype}; expected (lines, words) of uint64"
            )
        packed.append(np.ascontiguousarray(array))
    frames = as_whole_number("frames", frames, 1)
    for name, array in zip(("bits_a", "bits_b"), packed, strict=True):
        if array.shape[1] != -(-frames // 64):
            raise EpibarError(
                f"{name}: {array.shape[1]} words per line, but {frames} frames need {-(-frames // 64)}"
            )
    with core_errors():
        return _core.match_barcodes(
            packed[0],
            packed[1],
            frames,
            as_whole_number("mutual", mutual, 1),
            as_whole_number("limit", limit, 1),
        )
