"""What background subtraction does to silhouettes: ragged edges, holes, missed objects, false blobs."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Index, Mask


@dataclass(frozen=True)
class Dirt:
    """How dirty masks are.

    Attributes
    ----------
    false_blobs : float
        Mean number of false blobs per frame.
    blob_px : (low, high)
        Radius of a false blob, pixels.
    ragged : float
        Chance that a pixel within ``ragged_px`` of an outline is decided by noise.
    ragged_px : int
        Width of the ragged band on either side of the outline, pixels.
    holes : float
        Mean number of holes per connected component.
    hole_share : (low, high)
        Radius of a hole, as a share of the square root of the component's area.
    missed : float
        Chance that a connected component is missed in a frame.
    merged_px : int
        Radius of a closing at the end, pixels: neighbours become one, and gaps are filled.
    """

    false_blobs: float = 2.0
    blob_px: tuple[float, float] = (2.0, 14.0)
    ragged: float = 0.5
    ragged_px: int = 1
    holes: float = 0.5
    hole_share: tuple[float, float] = (0.05, 0.2)
    missed: float = 0.04
    merged_px: int = 0


def _blob(image: Mask, centre: Array, radius: float, value: int, rng: np.random.Generator) -> None:
    axes = tuple(max(1, round(radius * rng.uniform(0.6, 1.4))) for _ in range(2))
    middle = (round(float(centre[0])), round(float(centre[1])))
    cv2.ellipse(image, middle, axes, float(rng.uniform(0, 180)), 0, 360, value, -1)


def _around(mask: Mask, margin: int, step: int = 1) -> tuple[int, int, Mask]:
    """Cut out the part of a mask in which anything is set: its first column and row, and the part.

    Column and row are multiples of ``step``.
    """
    x, y, width, height = cv2.boundingRect(mask)
    left, top = (max(at - margin, 0) // step * step for at in (x, y))
    return left, top, mask[top : y + height + margin, left : x + width + margin]


def _lose(out: Mask, dirt: Dirt, rng: np.random.Generator) -> None:
    """Miss components, or cut holes into them."""
    # OpenCV goes through blocks of 2×2, on which the order of its labels depends.
    left, top, part = _around(out, 0, 2)
    if part.size == 0:
        return
    count, labels, stats, _ = cv2.connectedComponentsWithStats(part, connectivity=8)
    for label in range(1, count):
        x, y, w, h, area = stats[label]
        window = labels[y : y + h, x : x + w] == label
        if rng.random() < dirt.missed:
            part[y : y + h, x : x + w][window] = 0
            continue
        for _ in range(rng.poisson(dirt.holes)):
            rows, columns = np.nonzero(window)
            pick = rng.integers(len(rows))
            radius = rng.uniform(*dirt.hole_share) * np.sqrt(area)
            _blob(out, np.array([left + x + columns[pick], top + y + rows[pick]]), radius, 0, rng)


def _band(mask: Mask, width: int) -> Index:
    """List the pixels within a width of an outline, as places row · width + x."""
    left, top, part = _around(mask, width)
    if part.size == 0:
        return np.empty(0, np.int64)
    kernel = np.ones((2 * width + 1,) * 2, np.uint8)
    rows, columns = np.nonzero(cv2.dilate(part, kernel) != cv2.erode(part, kernel))
    places: Index = (rows + top) * mask.shape[1] + columns + left
    return places


def noisy_frame(mask: Mask, dirt: Dirt, rng: np.random.Generator) -> Mask:
    """One (H, W) mask made dirty; 0 and 1."""
    height, width = mask.shape
    out = (mask != 0).astype(np.uint8)
    if dirt.missed > 0 or dirt.holes > 0:
        _lose(out, dirt, rng)
    if dirt.ragged > 0 and dirt.ragged_px > 0:
        band = _band(out, dirt.ragged_px)
        # Noise at half resolution: real outlines are ragged in clumps, not in single pixels.
        half_width = (width + 1) // 2
        coarse = rng.random(((height + 1) // 2) * half_width)
        noise = coarse[(band // width // 2) * half_width + (band % width) // 2]
        flat = out.reshape(-1)
        flat[band[noise < dirt.ragged / 2]] = 0
        flat[band[noise > 1 - dirt.ragged / 2]] = 1
    for _ in range(rng.poisson(dirt.false_blobs)):
        _blob(out, rng.uniform(0, 1, 2) * (width, height), rng.uniform(*dirt.blob_px), 1, rng)
    if dirt.merged_px > 0:
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * dirt.merged_px + 1,) * 2)
        part = _around(out, 2 * dirt.merged_px + 1)[2]
        if part.size:
            part[:] = cv2.morphologyEx(part, cv2.MORPH_CLOSE, disc)
    result: Mask = out
    return result


def noisy(masks: ArrayLike, seed: int = 0, dirt: Dirt | None = None) -> Mask:
    """Dirty masks from clean ones.

    Parameters
    ----------
    masks : (T, H, W) array
        Non-zero = moving.
    seed : int
        Frame i draws from (seed, i), so a part of a recording gets the dirt that the whole gets.
    dirt : Dirt, optional
        How dirty.

    Returns
    -------
    (T, H, W) uint8 array
        0 and 1.
    """
    masks = np.asarray(masks)
    if masks.ndim != 3:
        raise ValueError(f"masks: shape {masks.shape}, expected (frames, height, width)")
    dirt = dirt or Dirt()
    out = np.empty(masks.shape, np.uint8)
    for frame, mask in enumerate(masks):
        out[frame] = noisy_frame(mask, dirt, np.random.default_rng((seed, frame)))
    return out
