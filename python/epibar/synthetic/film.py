"""What one camera films of a world: masks frame by frame, in bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from ..arguments import Array, Bits, Index, Mask
from .camera import Camera
from .dirt import Dirt, noisy_frame
from .lens_raster import solid_spans
from .made_up_world import MadeUpWorld, Shapes
from .raster import Spans, ellipse_spans

Outlines = Literal["silhouettes", "boxes", "ellipses"]

CHUNK_PIXELS = 6_000_000
"""Of the masks that are drawn in one go."""


@dataclass(frozen=True, eq=False)
class Clock:
    """When a camera filmed.

    Attributes
    ----------
    start : float
        Second of the world at which its frame 0 was taken.
    fps : float
        Frames per second by its own clock: frame k is at k / fps seconds of its recording.
    frames : int
    drift : float
        By how much its clock runs fast, parts per million.
    """

    start: float
    fps: float
    frames: int
    drift: float = 0.0

    @property
    def rate(self) -> float:
        """Seconds of this clock per second of the world."""
        return 1.0 + 1e-6 * self.drift

    @property
    def moments(self) -> Array:
        """Second of the world of each frame."""
        return self.start + np.arange(self.frames) / self.fps / self.rate


@dataclass(frozen=True, eq=False)
class Lights:
    """Lamps that go on and off in the image, and frames in which the light of the room floods all of it.

    Attributes
    ----------
    places : (n, 3) array
        Of the lamps: x, y and radius, pixels.
    on : (T, n) bool array
    flooded : (T,) bool array
    """

    places: Array
    on: Bits
    flooded: Bits


@dataclass(frozen=True, eq=False)
class Film:
    """One camera before a world.

    Attributes
    ----------
    camera : Camera
    world : MadeUpWorld
    number : int
        Which camera of the world this is, for what only one sees.
    moments : (T,) array
        Second of the world of each frame.
    outlines : {"silhouettes", "boxes", "ellipses"}
        What stands for a mover: itself, the box around it, or an ellipse in that box.
    jitter : float
        Standard deviation of the sides of such a box, as a share of its size.
    dirt : Dirt or None
    cleaned : bool
        Whether the dirty masks are cleaned as the package cleans its own: median, closing, small areas.
    seed : int
        Of dirt and jitter.
    knocked : Camera or None
        What the camera is from frame ``knocked_at`` on.
    mirrored : bool
        Left and right changed about.
    lights : Lights or None
    also : Film or None
        What moves in this image besides, as in a mirror: the masks of a film of as many frames are added,
        before dirt.
    """

    camera: Camera
    world: MadeUpWorld
    number: int
    moments: Array
    outlines: Outlines = "silhouettes"
    jitter: float = 0.0
    dirt: Dirt | None = None
    cleaned: bool = False
    seed: int = 0
    knocked: Camera | None = None
    knocked_at: int = 0
    mirrored: bool = False
    lights: Lights | None = None
    also: Film | None = None

    def without_lens(self) -> Film:
        """Return the same film as a pinhole of the same matrix takes it."""
        return replace(
            self,
            camera=self.camera.without_lens(),
            knocked=None if self.knocked is None else self.knocked.without_lens(),
            also=None if self.also is None else self.also.without_lens(),
        )

    def iter_masks(self, start: int = 0, stop: int | None = None) -> Iterator[Mask]:
        """Draw masks frame by frame: (H, W) uint8, 0 and 1."""
        stop = len(self.moments) if stop is None else min(stop, len(self.moments))
        clean = _cleaner() if self.cleaned else None
        width, height = self.camera.size
        step = max(1, min(32, CHUNK_PIXELS // (width * height)))
        first = start
        while first < stop:
            last = min(first + step, stop)
            camera = self.camera
            if self.knocked is not None:
                if first < self.knocked_at < last:
                    last = self.knocked_at
                camera = self.knocked if first >= self.knocked_at else camera
            masks = self._drawn(camera, first, last)
            if self.also is not None:
                masks |= self.also._drawn(self.also.camera, first, last)
            for offset, mask in enumerate(masks):
                mask = self._spoilt(mask, first + offset)
                yield clean(mask) if clean is not None else mask
            first = last

    def _drawn(self, camera: Camera, first: int, last: int) -> Mask:
        """Draw a chunk of clean masks."""
        width, height = camera.size
        masks = np.zeros((last - first, height, width), np.uint8)
        shapes = self.world.shapes(self.moments[first:last], self.number)
        spans = solid_spans(camera, shapes.centres, shapes.axes, shapes.box)
        if self.outlines != "silhouettes":
            frame, spans = self._boxed(spans, shapes, first)
            _fill(masks, frame[spans.item], spans, 1)
            return masks
        if shapes.moving.all():
            _fill(masks, shapes.frame[spans.item], spans, 1)
            return masks
        depth = shapes.centres @ camera.R[2] + camera.t[2]
        # Near solids after far ones: with an index repeated, numpy keeps the last value.
        spans = spans.take(np.argsort(-depth[spans.item], kind="stable"))
        _fill(masks, shapes.frame[spans.item], spans, shapes.moving[spans.item].astype(np.uint8))
        return masks

    def _boxed(self, spans: Spans, shapes: Shapes, first: int) -> tuple[Index, Spans]:
        """Turn the spans of movers into those of boxes or ellipses: the frame of each, and the spans."""
        owner = shapes.owner[spans.item]
        spans, owner = spans.take(np.flatnonzero(owner >= 0)), owner[owner >= 0]
        key = shapes.frame[spans.item] * self.world.count + owner
        keys, index = np.unique(key, return_inverse=True)
        low, high = np.full((len(keys), 2), np.inf), np.full((len(keys), 2), -np.inf)
        np.minimum.at(low, index, np.column_stack([spans.left, spans.row]))
        np.maximum.at(high, index, np.column_stack([spans.right, spans.row]))
        frame = keys // self.world.count
        noise = np.zeros((len(keys), 4))
        if self.jitter:
            for at in np.unique(frame):
                own = frame == at
                rng = np.random.default_rng((self.seed, self.number, 1, first + int(at)))
                # One draw for every mover, so that it does not depend on who else is in view.
                noise[own] = rng.normal(0, self.jitter, (self.world.count, 4))[keys[own] % self.world.count]
        size = high - low + 1
        low, high = low - 0.5 + noise[:, :2] * size, high + 0.5 + noise[:, 2:] * size
        middle, half = (low + high) / 2, np.maximum(high - low, 1.0) / 2
        if self.outlines == "ellipses":
            shape = np.zeros((len(keys), 2, 2))
            shape[:, 0, 0], shape[:, 1, 1] = half[:, 0] ** 2, half[:, 1] ** 2
            return frame, ellipse_spans(middle, shape, self.camera.size)
        return frame, _rectangles(middle - half, middle + half, self.camera.size)

    def _spoilt(self, mask: Mask, frame: int) -> Mask:
        """Add what is wrong with a mask: dirt, lights, a mirror."""
        if self.dirt is not None:
            mask = noisy_frame(mask, self.dirt, np.random.default_rng((self.seed, self.number, 0, frame)))
        if self.lights is not None:
            for x, y, radius in self.lights.places[self.lights.on[frame]]:
                cv2.circle(mask, (round(x), round(y)), round(radius), 1, -1)
            if self.lights.flooded[frame]:
                mask[:] = 1
        return np.ascontiguousarray(mask[:, ::-1]) if self.mirrored else mask


def _fill(masks: Mask, frame: Index, spans: Spans, value: int | Mask) -> None:
    """Set the pixels of spans in a stack of masks."""
    height, width = masks.shape[1:]
    span, pixel = spans.pixels(width)
    pixel += (frame * (width * height))[span]
    masks.reshape(-1)[pixel] = value[span] if isinstance(value, np.ndarray) else value


def _rectangles(low: Array, high: Array, size: tuple[int, int]) -> Spans:
    """Spans of upright rectangles, (m, 2) corners."""
    first = np.ceil(np.clip(low, 0, size)).astype(np.int64)
    last = np.floor(np.clip(high, -1, np.array(size) - 1)).astype(np.int64)
    count = np.where(last[:, 0] >= first[:, 0], np.maximum(last[:, 1] - first[:, 1] + 1, 0), 0)
    item = np.repeat(np.arange(len(low)), count)
    row = np.arange(len(item)) + (first[:, 1] - np.cumsum(count) + count)[item]
    return Spans(item, row, first[item, 0], last[item, 0])


def _cleaner() -> Callable[[Mask], Mask]:
    from ..foreground import Foreground, ForegroundOptions

    foreground = Foreground(ForegroundOptions())
    return foreground.clean
