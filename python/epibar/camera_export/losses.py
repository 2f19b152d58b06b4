"""What a program has no place for: lenses, and names that are no file's; measured, written down and told."""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from ..arguments import Array
from ..errors import EpibarError
from ..lens.intrinsics import Intrinsics

__all__ = ["fewer_coefficients", "loss_in_pixels", "off_as_pinhole", "plain_names", "renamed", "tell"]

logger = logging.getLogger("epibar")


class Named(Protocol):
    """A camera of a network, or of a run."""

    @property
    def name(self) -> str:
        """That of its recording."""


GRID = 21
"""Pixels each way at which lenses are compared."""
OUTWARDS = 16
"""Steps from the principal point to a pixel."""
TINY = 1e-5
"""For slopes, in the plane at depth 1."""
ROUND_TRIP = 1e-3
"""Pixels: a ray that does not come as close is none of that pixel."""


def fewer_coefficients(camera: Intrinsics, count: int, program: str) -> tuple[Array, float]:
    """Return the first of OpenCV's coefficients that come closest to a lens, and how far they are off.

    Where the others are 0, they are as they were. Else the least squares of what a grid of pixels sees: what
    OpenCV's model adds to a ray is linear in k1, k2, p1, p2 and k3.

    Parameters
    ----------
    camera : Intrinsics
    count : int
        4 or 5: k1 k2 p1 p2 [k3].
    program : str
        Which has no place for more.

    Returns
    -------
    coefficients : ndarray, shape (count,)
    off : float
        The largest shift inside the image, pixels; 0 where the others are 0.

    Raises
    ------
    EpibarError
        A fisheye lens, which is none of these.
    """
    if camera.fisheye:
        raise EpibarError(
            f"{camera.name}: {program} has no fisheye lens; undistort the video, or choose another format"
        )
    given = camera.distortions
    if not np.any(given[count:]):
        return np.pad(given[:count], (0, max(0, count - len(given)))), 0.0
    rays, pixels = _view(camera)
    x, y = rays.T
    r2 = x**2 + y**2
    columns = np.array(
        [
            (x * r2, y * r2),
            (x * r2**2, y * r2**2),
            (2 * x * y, r2 + 2 * y**2),
            (r2 + 2 * x**2, 2 * x * y),
            (x * r2**3, y * r2**3),
        ]
    )[:count]
    focal = camera.matrix[[0, 1], [0, 1]]
    wanted = pixels - _pinhole(camera.matrix, rays)
    design = (columns * focal[:, None]).reshape(count, -1).T
    found: Array = np.linalg.lstsq(design, wanted.T.ravel(), rcond=None)[0].astype(np.float64)
    off = (design @ found).reshape(2, -1).T - wanted
    return found, float(np.hypot(*off.T).max())


def off_as_pinhole(camera: Intrinsics, matrix: Array) -> float:
    """How far a pinhole camera of this matrix, (3, 3), is off inside the image, pixels."""
    if not camera.distorted and np.array_equal(matrix, camera.matrix):
        return 0.0
    rays, pixels = _view(camera)
    return float(np.hypot(*(_pinhole(matrix, rays) - pixels).T).max())


def loss_in_pixels(what: str, off: Mapping[str, float]) -> list[str]:
    """Say what is lost, and how far it is off in which camera; nothing where none is."""
    lost = [f"{_two_digits(pixels)} px in {name}" for name, pixels in off.items() if pixels > 0]
    return [f"lost: {what}; off inside the image by up to {', '.join(lost)}"] if lost else []


def _two_digits(pixels: float) -> str:
    return f"{pixels:.0f}" if pixels >= 10 else f"{pixels:.2g}"


def tell(path: Path, losses: Sequence[str]) -> None:
    """Log what is lost."""
    for text in losses:
        logger.warning("%s: %s", path, text)


def _view(camera: Intrinsics) -> tuple[Array, Array]:
    """Rays (n, 2), in the plane at depth 1, of a grid of pixels, and these pixels.

    Newton's steps towards pixels that move from the principal point outwards, so that each ends on its own
    side of where a lens folds over; a pixel that no ray comes to has no lens that could be lost.
    """
    width, height = camera.size
    across, down = np.meshgrid(np.linspace(0, width - 1, GRID), np.linspace(0, height - 1, GRID))
    pixels = np.column_stack([across.ravel(), down.ravel()])
    centre = camera.matrix[:2, 2]
    rays = np.full_like(pixels, TINY)
    for share in np.append(np.repeat(np.linspace(0, 1, OUTWARDS + 1)[1:], 2), np.ones(4)):
        off = camera.through_lens(rays) - (centre + share * (pixels - centre))
        slopes = [
            (camera.through_lens(rays + step) - camera.through_lens(rays - step)) for step in TINY * np.eye(2)
        ]
        jacobian = np.stack(slopes, axis=2) / (2 * TINY)
        good = np.linalg.det(jacobian) > 0
        rays[good] -= np.linalg.solve(jacobian[good], off[good, :, None])[..., 0]
    seen = camera.through_lens(rays)
    good = np.hypot(*(seen - pixels).T) < ROUND_TRIP
    if not good.any():
        raise EpibarError(f"{camera.name}: its distortion coefficients cannot be inverted inside its image")
    return rays[good], seen[good]


def _pinhole(matrix: Array, rays: Array) -> Array:
    return np.asarray(rays * matrix[[0, 1], [0, 1]] + matrix[:2, 2])


def renamed(cameras: Sequence[Named], names: Sequence[str]) -> list[str]:
    """Say which cameras have another name in a file."""
    both = zip(names, cameras, strict=True)
    return [f"renamed: {one.name}: it is {name} in these files" for name, one in both if name != one.name]


def plain_names(cameras: Sequence[Named], refused: str, taken: Sequence[str] = ()) -> list[str]:
    """Return names that may be a file's or a key's, each once.

    Parameters
    ----------
    cameras : sequence of what has a name
    refused : str
        Regular expression of what a name may not hold; it becomes an underscore.
    taken : sequence of str
        Names that mean something else.
    """
    found: list[str] = []
    for place, camera in enumerate(cameras, 1):
        name = re.sub(refused, "_", camera.name) or "_"
        if name in found or name in taken:
            name = f"{name}_{place}"
        while name in found:
            name += "_"
        found.append(name)
    return found
