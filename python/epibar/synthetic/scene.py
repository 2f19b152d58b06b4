"""A scene: known cameras, and solids that move in front of them. Masks are drawn when asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Array, Bits, Index, Mask
from ..geometry.cameras import inside, volume_correspondences
from .camera import Camera, true_fundamental
from .dirt import Dirt, noisy_frame
from .lens_raster import solid_spans
from .raster import Spans

_CHUNK = 16


@dataclass(frozen=True, eq=False)
class Solids:
    """Convex solids over time, M of them over T frames, in metres.

    Attributes
    ----------
    centres : (T, M, 3) array
    axes : (T, M, 3, 3) array
        Half-axes in columns.
    box : (M,) bool array
        A box, or else an ellipsoid.
    owner : (M,) int array
        Which object (walker, cube) the solid is part of.
    moving : (M,) bool array
        False for an occluder, which hides what is behind it and is no foreground itself.
    seen_by : (M, cameras) bool array
        Which cameras the solid is drawn in.
    """

    centres: Array
    axes: Array
    box: Bits
    owner: Index
    moving: Bits
    seen_by: Bits

    @classmethod
    def of(
        cls,
        centres: Array,
        axes: Array,
        box: bool,
        owner: Index,
        seen_by: Bits,
        moving: bool = True,
    ) -> Solids:
        """Make solids of one kind."""
        count = centres.shape[1]
        return cls(centres, axes, np.full(count, box), owner, np.full(count, moving), seen_by)

    def joined(self, other: Solids) -> Solids:
        """Join these solids and others, whose owners are numbered after these."""
        return Solids(
            np.concatenate([self.centres, other.centres], axis=1),
            np.concatenate([self.axes, other.axes], axis=1),
            np.concatenate([self.box, other.box]),
            np.concatenate([self.owner, other.owner + int(self.owner.max(initial=-1)) + 1]),
            np.concatenate([self.moving, other.moving]),
            np.concatenate([self.seen_by, other.seen_by]),
        )

    def at(self, frames: Array) -> Solids:
        """Return the solids at moments between frames, (K,) frame numbers; between two they move straight."""
        first = np.clip(np.floor(frames).astype(np.int64), 0, max(len(self.centres) - 2, 0))
        second = np.minimum(first + 1, len(self.centres) - 1)
        share = np.clip(frames - first, 0.0, 1.0)

        def between(values: Array) -> Array:
            part = share.reshape(-1, *(1,) * (values.ndim - 1))
            return (1 - part) * values[first] + part * values[second]

        return replace(self, centres=between(self.centres), axes=between(self.axes))

    def random_points(self, n: int, rng: np.random.Generator) -> Array:
        """Draw (n, 3) points, each in a random moving solid that all cameras may see, at a random time."""
        common = np.flatnonzero(self.moving & self.seen_by.all(axis=1))
        if len(common) == 0:
            return np.empty((0, 3))
        time, solid = rng.integers(len(self.centres), size=n), rng.choice(common, size=n)
        direction = rng.normal(size=(n, 3))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        within = direction * np.cbrt(rng.uniform(0, 1, (n, 1)))
        result: Array = self.centres[time, solid] + np.einsum("nij,nj->ni", self.axes[time, solid], within)
        return result


@dataclass(frozen=True, eq=False)
class Scene:
    """A made-up scene with known truth.

    Attributes
    ----------
    name : str
    cameras : list of Camera
    solids : Solids
    frames : int
    fps : float
    volume_points : (n, 3) array
        Random points where things moved, metres.
    seed : int
        Of the dirt; the rest is drawn already.
    dirt : Dirt or None
        Makes the masks dirty.
    """

    name: str
    cameras: list[Camera]
    solids: Solids
    frames: int
    fps: float
    volume_points: Array
    seed: int = 0
    dirt: Dirt | None = None

    def fundamental(self, a: int, b: int) -> Array:
        """Return the true fundamental matrix from camera a to camera b, ``x_bᵀ F x_a = 0``."""
        return true_fundamental(self.cameras[a], self.cameras[b])

    def filmed_at(self, seconds: Array, fps: float) -> Scene:
        """Return the scene as a camera of another clock films it: frame k shows the moment ``seconds[k]``.

        Parameters
        ----------
        seconds : (K,) array
            Moments since frame 0 of this scene; they should not go beyond its last frame.
        fps : float
            Frames per second by the clock of that camera.
        """
        solids = self.solids.at(np.asarray(seconds, dtype=np.float64) * self.fps)
        return replace(self, solids=solids, frames=len(solids.centres), fps=fps)

    def visible(self, camera_index: int) -> Bits:
        """Tell which of the volume points lie inside this camera's image."""
        camera = self.cameras[camera_index]
        return inside(camera.project(self.volume_points)[0], camera.size)

    def volume_correspondences(self, a: int, b: int) -> tuple[Array, Array]:
        """Project the volume points inside both images: two (m, 2) arrays, pixels."""
        return volume_correspondences(self.cameras[a], self.cameras[b], self.volume_points)

    def spans(self, camera_index: int, start: int, stop: int, ordered: bool) -> tuple[Spans, Index]:
        """List the image rows of the solids in frames start … stop − 1.

        Returns the spans, whose ``item`` is (frame − start) · S + s for solid ``drawn[s]`` of the S solids
        drawn, and ``drawn``. When ``ordered``, near solids come after far ones.
        """
        camera, solids = self.cameras[camera_index], self.solids
        drawn = np.flatnonzero(solids.seen_by[:, camera_index])
        centres = solids.centres[start:stop, drawn].reshape(-1, 3)
        axes = solids.axes[start:stop, drawn].reshape(-1, 3, 3)
        spans = solid_spans(camera, centres, axes, np.tile(solids.box[drawn], stop - start))
        if ordered:
            depth = centres @ camera.R[2] + camera.t[2]
            spans = spans.take(np.argsort(-depth[spans.item], kind="stable"))
        return spans, drawn

    def _draw(self, camera_index: int, start: int, stop: int) -> Mask:
        width, height = self.cameras[camera_index].size
        masks = np.zeros((stop - start, height, width), np.uint8)
        occluded = not self.solids.moving[self.solids.seen_by[:, camera_index]].all()
        spans, drawn = self.spans(camera_index, start, stop, ordered=occluded)
        if len(drawn) == 0:
            return masks
        span, pixel = spans.pixels(width)
        frame = spans.item // len(drawn)
        pixel += (frame * (width * height))[span]
        # With an index repeated, numpy keeps the last value: the nearest solid.
        value = self.solids.moving[drawn][spans.item % len(drawn)].astype(np.uint8)[span] if occluded else 1
        masks.reshape(-1)[pixel] = value
        return masks

    def iter_masks(self, camera_index: int, start: int = 0, stop: int | None = None) -> Iterator[Mask]:
        """Draw the masks of one camera frame by frame: (H, W) uint8, 0 and 1, in bounded memory."""
        stop = self.frames if stop is None else min(stop, self.frames)
        for first in range(start, stop, _CHUNK):
            for offset, mask in enumerate(self._draw(camera_index, first, min(first + _CHUNK, stop))):
                if self.dirt is not None:
                    rng = np.random.default_rng((self.seed, camera_index, first + offset))
                    mask = noisy_frame(mask, self.dirt, rng)
                yield mask

    def masks(self, camera_index: int, start: int = 0, stop: int | None = None) -> Mask:
        """Draw the masks of one camera, (T, H, W) uint8, 0 and 1."""
        stop = self.frames if stop is None else min(stop, self.frames)
        width, height = self.cameras[camera_index].size
        out = np.empty((max(stop - start, 0), height, width), np.uint8)
        for index, mask in enumerate(self.iter_masks(camera_index, start, stop)):
            out[index] = mask
        return out
