"""What the stages work on: eight walkers before high cameras, 768x576, 800 frames."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from epibar import Recording, synthetic

SIZE = (768, 576)
FRAMES = 800
LINES = 20000

Bits = NDArray[np.uint64]


@dataclass(frozen=True)
class Pair:
    """Two cameras of one scene."""

    frames: int = FRAMES
    seed: int = 1

    @cached_property
    def scene(self) -> synthetic.Scene:
        """Eight people in view of two cameras."""
        return synthetic.people(self.seed, cameras=2, frames=self.frames, size=SIZE)

    @cached_property
    def masks(self) -> list[NDArray[np.uint8]]:
        """Of both cameras, (T, H, W)."""
        return [np.ascontiguousarray(self.scene.masks(camera)) for camera in range(2)]

    @cached_property
    def recordings(self) -> list[Recording]:
        """Of both cameras."""
        return [
            Recording.from_masks(masks, fps=25.0, lines=LINES, seed=camera)
            for camera, masks in enumerate(self.masks)
        ]

    def barcodes(self, count: int) -> list[Bits]:
        """`count` informative barcodes of each camera; (count, words)."""
        found = []
        for masks, seed in zip(self.masks, (11, 12), strict=True):
            lines = LINES
            while True:
                bits = Recording.from_masks(masks, fps=25.0, lines=lines, seed=seed).barcodes
                ones = np.bitwise_count(bits).sum(axis=1)
                bits = bits[(ones > 0.05 * self.frames) & (ones < 0.95 * self.frames)]
                if len(bits) >= count:
                    break
                lines *= 2
            found.append(np.ascontiguousarray(bits[:count]))
        return found


def random_barcodes(count: int, frames: int, seed: int) -> Bits:
    """Passages at random times: bits that flip once in twelve frames; (count, words)."""
    flips = np.random.default_rng(seed).random((count, frames), dtype=np.float32) < 1 / 12
    packed = np.packbits(np.logical_xor.accumulate(flips, axis=1), axis=1, bitorder="little")
    bits = np.zeros((count, -(-frames // 64) * 8), np.uint8)
    bits[:, : packed.shape[1]] = packed
    return bits.view(np.uint64)
