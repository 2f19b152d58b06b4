"""A camera in a world with z up, in metres: ``X_c = R X + t``, ``x ~ K X_c``, maybe with a lens."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array
from ..errors import EpibarError
from ..geometry.cameras import fundamental_from_cameras, project, projection_matrix
from . import fisheye, lens


@dataclass(frozen=True, eq=False)
class Camera:
    """A known, stationary camera.

    Attributes
    ----------
    K : (3, 3) array
        Pixels.
    R, t : (3, 3) and (3,) array
        World to camera, metres.
    size : (width, height)
    name : str
    distortions : tuple of float
        k1, k2, p1, p2, k3 of OpenCV's lens model; empty for a pinhole. They bend what is drawn; projections
        and fundamental matrices are in undistorted pixels of the same K.
    fisheye : float, optional
        k of a lens of :mod:`~epibar.synthetic.fisheye`, in place of distortions.

    Raises
    ------
    EpibarError
        Both distortions and fisheye: a camera has one lens.
    """

    K: Array
    R: Array
    t: Array
    size: tuple[int, int]
    name: str = ""
    distortions: tuple[float, ...] = ()
    fisheye: float | None = None

    def __post_init__(self) -> None:
        if self.distortions and self.fisheye is not None:
            raise EpibarError(
                f"{self.name or 'camera'}: distortions and fisheye are given, but a camera has one lens"
            )

    @classmethod
    def look_at(
        cls,
        position: ArrayLike,
        target: ArrayLike,
        focal: float,
        size: tuple[int, int],
        roll_deg: float = 0.0,
        name: str = "",
    ) -> Camera:
        """Place a camera at ``position`` that looks at ``target``, the right way up, then roll it.

        Positions are in metres, ``focal`` is in pixels; the principal point is the middle of the image. A
        positive roll turns the picture clockwise.
        """
        position, target = np.asarray(position, dtype=np.float64), np.asarray(target, dtype=np.float64)
        forward = (target - position) / np.linalg.norm(target - position)
        # Straight up or down no direction is upright: take +y as the top of the image.
        up = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 1 - 1e-9 else np.array([0.0, 1.0, 0.0])
        right = np.cross(forward, up)
        right /= np.linalg.norm(right)
        upright = np.stack([right, np.cross(forward, right), forward])
        cos, sin = np.cos(np.deg2rad(roll_deg)), np.sin(np.deg2rad(roll_deg))
        R = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ upright
        K = np.array([[focal, 0.0, (size[0] - 1) / 2], [0.0, focal, (size[1] - 1) / 2], [0.0, 0.0, 1.0]])
        return cls(K, R, -R @ position, (int(size[0]), int(size[1])), name)

    @property
    def centre(self) -> Array:
        """Where the camera stands, (3,), metres."""
        return -self.R.T @ self.t

    @property
    def P(self) -> Array:
        """Projection matrix ``K [R | t]``, (3, 4)."""
        return projection_matrix(self)

    def project(self, points: ArrayLike) -> tuple[Array, Array]:
        """Project (n, 3) world points: (n, 2) pixels, NaN behind the camera, and (n,) depths in metres."""
        return project(self, points)

    @property
    def distorted(self) -> bool:
        """Whether the lens bends lines."""
        return self.fisheye is not None or any(self.distortions)

    @cached_property
    def lens_limit(self) -> float:
        """How far from the axis the lens follows its polynomial, in units of the focal length."""
        return (
            lens.image_limit(self.K, self.distortions, self.size) if any(self.distortions) else float("inf")
        )

    def distort(self, pixels: ArrayLike) -> Array:
        """Take (..., 2) undistorted pixels to where the lens shows them."""
        pixels = np.asarray(pixels, dtype=np.float64)
        if not self.distorted:
            return pixels
        focal, middle = self.K[[0, 1], [0, 1]], self.K[:2, 2]
        straight = (pixels - middle) / focal
        if self.fisheye is not None:
            return fisheye.bend(straight, self.fisheye) * focal + middle
        return lens.bend(straight, self.distortions, self.lens_limit) * focal + middle

    def undistort(self, pixels: ArrayLike) -> Array:
        """Take (..., 2) pixels as the lens shows them to undistorted ones."""
        pixels = np.asarray(pixels, dtype=np.float64)
        if not self.distorted:
            return pixels
        focal, middle = self.K[[0, 1], [0, 1]], self.K[:2, 2]
        bent = (pixels - middle) / focal
        if self.fisheye is not None:
            return fisheye.unbend(bent, self.fisheye) * focal + middle
        return lens.unbend(bent, self.distortions, self.lens_limit) * focal + middle

    def without_lens(self) -> Camera:
        """Return the same camera as a pinhole."""
        return replace(self, distortions=(), fisheye=None)


def true_fundamental(cam_a: Camera, cam_b: Camera) -> Array:
    """Return the fundamental matrix of two known cameras, Frobenius norm 1, ``x_bᵀ F x_a = 0``."""
    return fundamental_from_cameras(cam_a, cam_b)
