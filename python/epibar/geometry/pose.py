"""Relative pose of two cameras from F and their camera matrices, up to the length of the baseline.

With ``X_b = R X_a + t`` the essential matrix is ``E = [t]ₓ R ~ K_bᵀ F K_a``. It allows four poses, and only
the true one has the things seen in front of both cameras (cheirality; Hartley and Zisserman, *Multiple View
Geometry*, 9.6). Pitfall: a wrong F passes this test as well. The verdict is what tells whether F is right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, as_camera_matrix
from ..errors import EpibarError
from .correspondences import FrontierPoints
from .vectors import cross_matrix, homogeneous

__all__ = ["PairGeometry", "RelativePose", "depths", "relative_pose"]

LEAST_POINTS = 20
DECISIVE = 0.8
"""Share of the frontier points that must lie in front of both cameras; the other poses share the rest."""


class PairGeometry(Protocol):
    """What a pair needs to have for a pose: a :class:`~epibar.Calibration` has it."""

    @property
    def F(self) -> Array | None:
        """(3, 3), ``x_b^T F x_a = 0``."""

    @property
    def frontier_points(self) -> FrontierPoints:
        """Correspondences in undistorted pixels."""


@dataclass(frozen=True, eq=False)
class RelativePose:
    """Where camera B stands relative to camera A: ``X_b = R X_a + t``, the baseline being the unit of length.

    Attributes
    ----------
    E : ndarray, shape (3, 3)
        Essential matrix ``[t]ₓ R``, singular values 1, 1, 0.
    R : ndarray, shape (3, 3)
        Rotation from A's axes (x right, y down, z forward) to B's.
    t : ndarray, shape (3,)
        Unit vector. B stands at ``-R.T @ t`` in A's axes.
    points : int
        Frontier points that the pose was chosen with.
    in_front : int
        How many of them it puts in front of both cameras.
    singular_ratio : float
        Second over first singular value of ``K_bᵀ F K_a``. It is 1 when F and the camera matrices agree, so a
        low one says that a camera matrix (or F) is off.
    """

    E: Array
    R: Array
    t: Array
    points: int
    in_front: int
    singular_ratio: float

    def __repr__(self) -> str:
        return f"<RelativePose {self.in_front} of {self.points} points in front of both cameras>"


def relative_pose(calibration: PairGeometry, K_a: ArrayLike, K_b: ArrayLike) -> RelativePose:
    """Rotation and direction of translation between the cameras of a pair.

    Parameters
    ----------
    calibration : Calibration
        Of the pair. Look at ``accepted`` first: this works on any F.
    K_a, K_b : array_like, shape (3, 3)
        Camera matrices, pixels. F has to be in undistorted pixels of these matrices: give the intrinsics to
        :func:`epibar.record` where lenses distort.

    Returns
    -------
    RelativePose

    Raises
    ------
    EpibarError
        There is no F, a matrix is no camera matrix, or the frontier points do not decide between the poses.

    Examples
    --------
    >>> import epibar
    >>> camera_a, camera_b = epibar.load_cameras("cameras.toml")[:2]
    >>> cal = epibar.Calibration.load("cam1_cam2.npz")
    >>> pose = epibar.relative_pose(cal, camera_a.matrix, camera_b.matrix)
    >>> position_of_b = -pose.R.T @ pose.t
    """
    import cv2

    if calibration.F is None:
        raise EpibarError("no F was found for this pair, so there is no pose")
    matrix_a, matrix_b = as_camera_matrix(K_a, "K_a"), as_camera_matrix(K_b, "K_b")
    points = calibration.frontier_points
    if len(points) < LEAST_POINTS:
        raise EpibarError(
            f"{len(points)} frontier points: at least {LEAST_POINTS} are needed to tell the pose "
            "from the three others that F allows; method='frontier' finds them"
        )
    essential = matrix_b.T @ calibration.F @ matrix_a
    singular = np.linalg.svd(essential, compute_uv=False)
    first, second, direction = cv2.decomposeEssentialMat(essential)
    rotations = np.asarray(first, np.float64), np.asarray(second, np.float64)
    towards = np.asarray(direction, np.float64).ravel()
    rays_a, rays_b = _rays(points.a, matrix_a), _rays(points.b, matrix_b)
    counts = [
        (_in_front(R, sign * towards, rays_a, rays_b), which, sign)
        for which, R in enumerate(rotations)
        for sign in (1.0, -1.0)
    ]
    in_front, which, sign = max(counts)
    if in_front < DECISIVE * len(points):
        raise EpibarError(
            f"the pose is not decided: the best of the four that F allows has only {in_front} of "
            f"{len(points)} frontier points in front of both cameras; check the camera matrices"
        )
    R, t = rotations[which], sign * towards
    ratio = float(singular[1] / singular[0])
    return RelativePose(cross_matrix(t) @ R, R, t, len(points), in_front, ratio)


def depths(pose: RelativePose, a: Array, b: Array, K_a: Array, K_b: Array) -> tuple[Array, Array]:
    """Depths of correspondences in both cameras, two (n,) arrays in units of the baseline."""
    return _depths(pose.R, pose.t, _rays(a, K_a), _rays(b, K_b))


def _rays(points: Array, matrix: Array) -> Array:
    """Viewing rays with depth 1, (n, 3)."""
    return homogeneous(points) @ np.linalg.inv(matrix).T


def _depths(R: Array, t: Array, rays_a: Array, rays_b: Array) -> tuple[Array, Array]:
    """Least squares of ``depth_b ray_b = depth_a R ray_a + t``; not finite where the rays are parallel."""
    turned = rays_a @ R.T
    aa, bb = (turned**2).sum(axis=1), (rays_b**2).sum(axis=1)
    ab, at, bt = (turned * rays_b).sum(axis=1), turned @ t, rays_b @ t
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = aa * bb - ab**2
        return (ab * bt - bb * at) / determinant, (aa * bt - ab * at) / determinant


def _in_front(R: Array, t: Array, rays_a: Array, rays_b: Array) -> int:
    depth_a, depth_b = _depths(R, t, rays_a, rays_b)
    return int(((depth_a > 0) & (depth_b > 0)).sum())
