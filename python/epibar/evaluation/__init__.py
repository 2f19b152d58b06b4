"""How good is a fundamental matrix, against a known one.

The measure is the symmetric epipolar distance, mean of ``½(d(x_b, F x_a) + d(x_a, Fᵀ x_b))`` in pixels, and
it has to be said over which points: over the whole image, with correspondences drawn from the true F as the
paper does it (§4.3), or over the volume where things moved, which is what a user of F relies on. The true
candidate rate (§4.1) measures the line pairs that go into an estimation.

Conventions: ``x_bᵀ F x_a = 0``; pixel centres at integers, so an image is the rectangle [0, W-1] × [0, H-1];
a size is (width, height); a line is (a, b, c) with a·x + b·y + c = 0.
"""

from .cameras import PosedCamera, fundamental_from_cameras, inside, project, projection_matrix, triangulate
from .lines import area_between_lines, clip_lines, epipoles, true_candidate_rate, true_candidates
from .points import (
    GOOD_PAIR_PX,
    Figures,
    compare,
    good_pair,
    image_correspondences,
    moving_volume,
    symmetric_epipolar_distance,
    volume_correspondences,
)
from .tangents import matched_tangent_points

__all__ = [
    "GOOD_PAIR_PX",
    "Figures",
    "PosedCamera",
    "area_between_lines",
    "clip_lines",
    "compare",
    "epipoles",
    "fundamental_from_cameras",
    "good_pair",
    "image_correspondences",
    "inside",
    "matched_tangent_points",
    "moving_volume",
    "project",
    "projection_matrix",
    "symmetric_epipolar_distance",
    "triangulate",
    "true_candidate_rate",
    "true_candidates",
    "volume_correspondences",
]
