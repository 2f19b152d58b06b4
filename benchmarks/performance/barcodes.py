"""Packing masks and barcodes of 10,000 lines, beside numpy, gathers along lines and a Radon transform."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from data import SIZE, Pair
from machine import Machine
from numpy.typing import NDArray
from table import Stage
from timing import in_turn

LINES = 10_000
SOME = 500
"""Lines of those peers that are slow; their seconds are scaled to all lines."""


def recording_stages(pair: Pair, machine: Machine) -> list[Stage]:
    """The parts that the crate's bench has measured, and the peers of barcodes."""
    masks = pair.masks[0]
    rec = pair.recordings[0]
    segments = np.asarray(rec.segments)[:LINES].astype(int)
    packed = pack_time(masks)
    if not np.array_equal(along_lines(packed, segments[:50])[:, : rec.barcodes.shape[1]], rec.barcodes[:50]):
        raise AssertionError("the numpy barcodes differ")
    ways: dict[str, Callable[[], Any]] = {
        "numpy OR of time-packed pixels": lambda: along_lines(packed, segments[:SOME]),
        "cv2.line pixels, frame by frame": lambda: _frame_by_frame(masks[:40], segments[:SOME]),
    }
    scale = {"numpy OR of time-packed pixels": LINES / SOME}
    scale["cv2.line pixels, frame by frame"] = LINES / SOME * len(masks) / 40
    missing = []
    try:
        from skimage.draw import line as pixels_of
        from skimage.transform import radon

        # 180 angles of all offsets are 180 x 960 lines of one frame.
        angles, frames = np.arange(180.0), 2
        rays = 180 * int(np.ceil(np.hypot(*SIZE)))
        name = "scikit-image radon, as many rays"
        ways[name] = lambda: [radon(mask.astype(np.float32), angles, circle=False) for mask in masks[:frames]]
        scale[name] = LINES / rays * len(masks) / frames
        name = "scikit-image line pixels, numpy OR"
        ways[name] = lambda: along_lines(packed, segments[:SOME], pixels_of)
        scale[name] = LINES / SOME
    except ImportError:
        missing.append("scikit-image")
    seconds = {name: s * scale[name] for name, s in in_turn(ways, rounds=3).items()}
    bytes_read = float(masks.size)
    lines = Stage(
        name=f"barcodes of {LINES:,} lines from packed pixels",
        unit="line pixels x 256 frames",
        units=machine.line_pixels,
        seconds=machine.barcodes,
        limit="memory, if each pixel came from there",
        limit_seconds=32 * machine.line_pixels / machine.bytes_per_second,
        peers=seconds,
        missing=missing,
    )

    def part(name: str, seconds: float) -> Stage:
        return Stage(name, "mask bytes", bytes_read, seconds, "reading the masks once", machine.reading)

    return [
        part("packing", machine.packing),
        part("components", machine.components),
        # The difference of two measurements, of work that reads no mask.
        Stage("hulls", "mask bytes", bytes_read, max(machine.hulls, 1e-9)),
        lines,
        part(f"recorder, {LINES:,} lines, all of it", machine.recorder),
    ]


def pack_time(masks: NDArray[np.uint8]) -> NDArray[np.uint64]:
    """Bit i of a pixel's words is frame i; (H * W, words)."""
    frames = -(-len(masks) // 64) * 64
    flat = np.zeros((frames, masks[0].size), bool)
    flat[: len(masks)] = masks.reshape(len(masks), -1) != 0
    packed = np.packbits(flat, axis=0, bitorder="little")
    return np.ascontiguousarray(packed.T).view(np.uint64)


def along_lines(
    packed: NDArray[np.uint64], segments: NDArray[np.int_], pixels_of: Callable[..., Any] | None = None
) -> NDArray[np.uint64]:
    """OR of the words of each line's pixels."""
    walk = pixels_of or walked
    barcodes = np.empty((len(segments), packed.shape[1]), np.uint64)
    for i, (x0, y0, x1, y1) in enumerate(segments.tolist()):
        rows, columns = walk(y0, x0, y1, x1)
        barcodes[i] = np.bitwise_or.reduce(packed[rows * SIZE[0] + columns], axis=0)
    return barcodes


def walked(y0: int, x0: int, y1: int, x1: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Pixels of a line as the package walks them: one per step of the longer axis, halves upwards."""
    steep = abs(y1 - y0) > abs(x1 - x0)
    (m0, n0), (m1, n1) = sorted([(y0, x0), (y1, x1)] if steep else [(x0, y0), (x1, y1)])
    m = np.arange(m0, m1 + 1)
    length = max(m1 - m0, 1)
    n = n0 + (2 * (m - m0) * (n1 - n0) + length) // (2 * length)
    return (m, n) if steep else (n, m)


def _frame_by_frame(masks: NDArray[np.uint8], segments: NDArray[np.int_]) -> NDArray[np.bool_]:
    """Whether anything moves on the pixels that OpenCV draws, (lines, frames)."""
    canvas = np.zeros(masks.shape[1:], np.uint8)
    moves = np.empty((len(segments), len(masks)), bool)
    flat = masks.reshape(len(masks), -1)
    for i, (x0, y0, x1, y1) in enumerate(segments.tolist()):
        cv2.line(canvas, (x0, y0), (x1, y1), 1)
        pixels = np.flatnonzero(canvas)
        moves[i] = flat[:, pixels].any(axis=1)
        canvas.reshape(-1)[pixels] = 0
    return moves
