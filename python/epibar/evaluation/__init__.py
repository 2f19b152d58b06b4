"""How good is a fundamental matrix, against a known one.

The measure is the symmetric epipolar distance, mean of ``½(d(x_b, F x_a) + d(x_a, Fᵀ x_b))`` in pixels, and
it has to be said over which points: over the whole image, with correspondences drawn from the true F as the
paper does it (§4.3), or over the volume where things moved, which is what a user of F relies on. The true
candidate rate (§4.1) measures the line pairs that go into an estimation.

:func:`evaluate` does it for a whole run. The conventions are those of :mod:`epibar.geometry`.
"""

from ..geometry.cameras import volume_correspondences
from .candidates import true_candidate_rate, true_candidates
from .points import (
    GOOD_PAIR_PX,
    MeanErrors,
    compare,
    good_pair,
    image_correspondences,
    moving_volume,
)
from .run import Evaluation, PairEvaluation, evaluate
from .tangents import matched_tangent_points

__all__ = [
    "GOOD_PAIR_PX",
    "Evaluation",
    "MeanErrors",
    "PairEvaluation",
    "compare",
    "evaluate",
    "good_pair",
    "image_correspondences",
    "matched_tangent_points",
    "moving_volume",
    "true_candidate_rate",
    "true_candidates",
    "volume_correspondences",
]
