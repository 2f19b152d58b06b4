"""Theia on the points of a network's pairs: relative poses, averaged; and its whole global reconstruction.

Theia takes cameras whose focal lengths are known, or were found by another program. Positions are by least
unsquared deviations: LiGT, which asks for points of three views, fails on tracks of two.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from common import Array
from opponents_views import Matches, Views

from epibar.synthetic import Camera

SAMPSON = 4.0
"""Pixels within which a point agrees with a relative pose."""
RANSAC = (500, 2000)
"""Draws of it, at least and at the most; Theia's own 10 and 1000 are as good on the median."""
LEAST_POINTS = 30
"""Fewer points that agree make no relative pose, as in Theia's own pipeline."""
AGREE_DEGREES = 5.0
"""Relative rotations further than this from the averaged ones are left out: Theia's default."""
PROJECTION = 0.1
"""Tolerance of 1DSfM, which leaves out relative positions: Theia's default."""
LOSS_PIXELS = 2.0
"""Width of the robust loss of the bundle adjustment."""


def _prior(K: Array, size: tuple[int, int]) -> Any:
    """A camera without a lens, its matrix known."""
    from pytheia import sfm

    prior = sfm.CameraIntrinsicsPrior()
    prior.camera_intrinsics_model_type = "PINHOLE"
    prior.image_width, prior.image_height = size
    prior.focal_length.value = [K[0, 0]]
    prior.aspect_ratio.value = [K[1, 1] / K[0, 0]]
    prior.principal_point.value = K[:2, 2].tolist()
    prior.skew.value = [0.0]
    for one in (prior.focal_length, prior.aspect_ratio, prior.principal_point, prior.skew):
        one.is_set = True
    return prior


def _correspondences(one: Array, other: Array) -> list[Any]:
    from pytheia import matching, sfm

    return [
        matching.FeatureCorrespondence(sfm.Feature(p), sfm.Feature(q))
        for p, q in zip(one, other, strict=True)
    ]


def _relative(matches: Matches, cameras: tuple[Any, Any]) -> tuple[Any, Array] | None:
    """Relative pose by locally optimised RANSAC over five points, and which points agree; None without one.

    Theia's angular adjustment of two views, of version 1.2.1, is left out: from the exact pose of exact
    points it goes astray by up to 0.1°, and on a development network directions became twice as bad.
    """
    from pytheia import sfm

    options = sfm.EstimateTwoViewInfoOptions()
    options.max_sampson_error_pixels = SAMPSON
    options.min_ransac_iterations, options.max_ransac_iterations = RANSAC
    options.use_lo = options.use_mle = True
    found, info, inliers = sfm.EstimateTwoViewInfo(options, *cameras, _correspondences(matches.a, matches.b))
    if not found or len(inliers) < LEAST_POINTS:
        return None
    info.num_verified_matches = len(inliers)
    return info, np.array(inliers)


class _Graph:
    """Views, relative poses and two-view tracks as Theia holds them."""

    def __init__(self, views: Views) -> None:
        from pytheia import sfm

        if views.matrices is None:
            raise RuntimeError("uncalibrated")
        self.reconstruction, self.graph = sfm.Reconstruction(), sfm.ViewGraph()
        tracks = sfm.TrackBuilder(2, 2)
        priors, self.ids = {}, {}
        for number, (name, size) in enumerate(views.sizes.items()):
            priors[name] = _prior(views.matrices[name], size)
            self.ids[name] = self.reconstruction.AddView(name, number, float(number))
            self.reconstruction.MutableView(self.ids[name]).SetCameraIntrinsicsPrior(priors[name])
        sfm.SetCameraIntrinsicsFromPriors(self.reconstruction)
        for (a, b), matches in views.pairs.items():
            relative = _relative(matches, (priors[a], priors[b]))
            if relative is None:
                continue
            info, near = relative
            self.graph.AddEdge(self.ids[a], self.ids[b], info)
            for p, q in zip(matches.a[near], matches.b[near], strict=True):
                tracks.AddFeatureCorrespondence(self.ids[a], sfm.Feature(p), self.ids[b], sfm.Feature(q))
        tracks.BuildTracks(self.reconstruction)

    def orientations(self) -> dict[int, Array]:
        """Rotations along the pairs with the most points, to start averaging from."""
        import cv2

        edges = sorted(self.graph.GetAllEdges().items(), key=lambda e: -e[1].num_verified_matches)
        if not edges:
            raise RuntimeError("unconnected")
        found = {edges[0][0][0]: np.eye(3)}
        while True:
            reached = ((edge, info) for edge, info in edges if (edge[0] in found) != (edge[1] in found))
            edge, info = next(reached, (None, None))
            if edge is None:
                break
            turn = cv2.Rodrigues(np.asarray(info.rotation_2, np.float64))[0]
            if edge[0] in found:
                found[edge[1]] = turn @ found[edge[0]]
            else:
                found[edge[0]] = turn.T @ found[edge[1]]
        return {view: cv2.Rodrigues(R)[0].ravel() for view, R in found.items()}


def _averaged(views: Views) -> dict[str, Camera]:
    """Rotations by a robust average, then positions by least unsquared deviations."""
    import cv2
    from pytheia import sfm

    made = _Graph(views)
    rotating = sfm.RobustRotationEstimator(sfm.RobustRotationEstimatorOptions())
    turns = rotating.EstimateRotations(made.graph.GetAllEdges(), made.orientations())
    sfm.FilterViewPairsFromOrientation(turns, AGREE_DEGREES, made.graph)
    one_dimensional = sfm.FilterViewPairsFromRelativeTranslationOptions()
    one_dimensional.translation_projection_tolerance = PROJECTION
    sfm.FilterViewPairsFromRelativeTranslation(one_dimensional, turns, made.graph)
    sfm.RemoveDisconnectedViewPairs(made.graph)
    if made.graph.NumEdges() == 0:
        raise RuntimeError("contradicting")
    placing = sfm.LeastUnsquaredDeviationPositionEstimator(
        sfm.LeastUnsquaredDeviationPositionEstimatorOptions()
    )
    places = placing.EstimatePositions(made.graph.GetAllEdges(), turns)
    found = {}
    for name, view in made.ids.items():
        if view in turns and view in places:
            assert views.matrices is not None
            R = cv2.Rodrigues(np.asarray(turns[view], np.float64))[0]
            t = -R @ np.asarray(places[view], np.float64).ravel()
            found[name] = Camera(views.matrices[name], R, t, views.sizes[name], name)
    return found


def _reconstructed(views: Views, known: bool) -> dict[str, Camera]:
    """Theia's global reconstruction: the same averages, points, and bundle adjustment with a robust loss."""
    from pytheia import sfm

    made = _Graph(views)
    options = sfm.ReconstructionEstimatorOptions()
    options.num_threads = 1
    options.bundle_adjustment_loss_function_type = sfm.LossFunctionType.HUBER
    options.bundle_adjustment_robust_loss_width = LOSS_PIXELS
    free = sfm.OptimizeIntrinsicsType
    lens = free.FOCAL_LENGTH_RADIAL_DISTORTION if views.bent else free.FOCAL_LENGTH
    options.intrinsics_to_optimize = free.NONE if known else lens
    done = sfm.GlobalReconstructionEstimator(options).Estimate(made.graph, made.reconstruction)
    if not done.success:
        raise RuntimeError("unreconstructed")
    found = {}
    for name, view in made.ids.items():
        if made.reconstruction.View(view).IsEstimated():
            camera = made.reconstruction.View(view).Camera()
            R = camera.GetOrientationAsRotationMatrix()
            place, K = camera.GetPosition(), camera.GetCalibrationMatrix()
            K = K[0] if isinstance(K, tuple) else K
            found[name] = Camera(np.asarray(K), R, -R @ place, views.sizes[name], name)
    return found


def placed(views: Views, way: str, known: bool) -> dict[str, Camera]:
    """Cameras that Theia places.

    Parameters
    ----------
    views : Views
        With camera matrices.
    way : {"averaging", "global"}
    known : bool
        The camera matrices are true, and not to be adjusted.

    Raises
    ------
    RuntimeError
        One word that says why there are none.
    """
    return _averaged(views) if way == "averaging" else _reconstructed(views, known)
