"""Geometry of known cameras and of pairs: lines, epipolar lines and distances, projections, relative poses.

Conventions: ``x_bᵀ F x_a = 0``; pixel centres at integers, so an image is the rectangle [0, W-1] × [0, H-1];
a size is (width, height); a line is (a, b, c) with a·x + b·y + c = 0; ``X_c = R X + t``, ``x ~ K X_c``.
"""

from .cameras import (
    Pose,
    PosedCamera,
    fundamental_from_cameras,
    inside,
    project,
    projection_matrix,
    triangulate,
    volume_correspondences,
)
from .correspondences import Candidates, FrontierPoints
from .epipolar import epipoles, symmetric_epipolar_distance
from .lines import area_between_lines, clip_lines, lines_through
from .pose import RelativePose, depths, relative_pose
from .vectors import cross_matrix, homogeneous

__all__ = [
    "Candidates",
    "FrontierPoints",
    "Pose",
    "PosedCamera",
    "RelativePose",
    "area_between_lines",
    "clip_lines",
    "cross_matrix",
    "depths",
    "epipoles",
    "fundamental_from_cameras",
    "homogeneous",
    "inside",
    "lines_through",
    "project",
    "projection_matrix",
    "relative_pose",
    "symmetric_epipolar_distance",
    "triangulate",
    "volume_correspondences",
]
