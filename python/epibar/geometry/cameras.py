"""Known cameras: ``X_c = R X + t``, ``x ~ K X_c``, pixel centres at integers, ``x_bᵀ F x_a = 0``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Bits, Size, as_finite
from ..errors import EpibarError
from .vectors import cross_matrix


class PosedCamera(Protocol):
    """What a camera needs to have here: ``X_c = R X + t``, ``x ~ K X_c``, and a size (width, height)."""

    @property
    def K(self) -> Array:
        """(3, 3), pixels."""

    @property
    def R(self) -> Array:
        """(3, 3), world to camera."""

    @property
    def t(self) -> Array:
        """(3,), world to camera."""

    @property
    def size(self) -> Size:
        """Width and height, pixels."""


def fundamental_from_cameras(cam_a: PosedCamera, cam_b: PosedCamera) -> Array:
    """Return the fundamental matrix of two known cameras.

    It is ``K_b⁻ᵀ [t]ₓ R K_a⁻¹`` with R = R_b R_aᵀ and t = t_b − R t_a.

    Returns
    -------
    (3, 3) array
        Frobenius norm 1, ``x_bᵀ F x_a = 0`` in undistorted pixels.

    Raises
    ------
    EpibarError
        If the two cameras stand at one place, where no F is defined.
    """
    rotation = cam_b.R @ cam_a.R.T
    cross = cross_matrix(cam_b.t - rotation @ cam_a.t)
    fundamental = np.linalg.inv(cam_b.K).T @ cross @ rotation @ np.linalg.inv(cam_a.K)
    norm = np.linalg.norm(fundamental)
    if norm < 1e-14:
        raise EpibarError("the two cameras stand at one place: no baseline, no fundamental matrix")
    result: Array = fundamental / norm
    return result


def projection_matrix(camera: PosedCamera) -> Array:
    """``K [R | t]``, (3, 4)."""
    return camera.K @ np.column_stack([camera.R, camera.t])


def opengl_pose(camera: PosedCamera) -> tuple[Array, Array]:
    """Rotation (3, 3) and position (3,) of camera to world in OpenGL's axes: x right, y up, z back."""
    return camera.R.T * (1.0, -1.0, -1.0), -camera.R.T @ camera.t


def project(camera: PosedCamera, points3d: ArrayLike) -> tuple[Array, Array]:
    """Project world points: (n, 2) pixels, NaN behind the camera, and (n,) depths."""
    local = as_finite("points3d", points3d, 3) @ camera.R.T + camera.t
    depth = local[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = (local @ camera.K.T)[:, :2] / np.where(depth > 0, depth, np.nan)[:, None]
    return pixels, depth


def inside(points: Array, size: Size) -> Bits:
    """Tell which of the (n, 2) points lie in the image."""
    x, y = points[:, 0], points[:, 1]
    return (x >= 0) & (x <= size[0] - 1) & (y >= 0) & (y <= size[1] - 1)


def triangulate(P_a: ArrayLike, P_b: ArrayLike, points_a: ArrayLike, points_b: ArrayLike) -> Array:
    """Linear triangulation (DLT) of correspondences seen by two known cameras.

    Parameters
    ----------
    P_a, P_b : (3, 4) array
        Projection matrices.
    points_a, points_b : (n, 2) array
        Undistorted pixels.

    Returns
    -------
    (n, 3) array
        World points. They may lie behind a camera: the caller knows what is plausible.
    """
    rows = []
    for name, matrix, points in (("a", P_a, points_a), ("b", P_b, points_b)):
        matrix, points = as_finite(f"P_{name}", matrix, (3, 4)), as_finite(f"points_{name}", points, 2)
        rows += [points[:, axis, None] * matrix[2] - matrix[axis] for axis in (0, 1)]
    if len(rows[0]) != len(rows[2]):
        raise EpibarError(f"points_b: {len(rows[2])} points, but points_a has {len(rows[0])}")
    system = np.stack(rows, axis=1)
    system /= np.linalg.norm(system, axis=2, keepdims=True)
    solution = np.linalg.svd(system)[2][:, 3]
    result: Array = solution[:, :3] / solution[:, 3:]
    return result


@dataclass(frozen=True)
class Pose:
    """A camera in the world: x ~ K X_c, X_c = R X + t, ``size`` = (width, height) in pixels."""

    K: Array
    R: Array
    t: Array
    size: tuple[int, int]


def volume_correspondences(
    cam_a: PosedCamera, cam_b: PosedCamera, points3d: ArrayLike
) -> tuple[Array, Array]:
    """Project (n, 3) world points into both cameras; two (m, 2) arrays of those inside both images."""
    a, b = project(cam_a, points3d)[0], project(cam_b, points3d)[0]
    keep = inside(a, cam_a.size) & inside(b, cam_b.size)
    return a[keep], b[keep]
