"""How far a calibrated network is from the true cameras of a situation.

A network from videos alone is known up to a similarity. Orientation, scale and place are taken from the
cameras in such a way that a few wrong ones do not spoil the figures of the others: of all alignments by one
camera (of orientations) and by two (of positions) the one with the least median error counts, refined over
the cameras that are within three times that median.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array
from ..geometry import symmetric_epipolar_distance
from ..geometry.vectors import angle_between
from .camera import Camera, true_fundamental

if TYPE_CHECKING:
    from ..network.parts import NetworkParts
    from .situations import Situation
    from .staging import Staging


@dataclass(frozen=True)
class CameraError:
    """How wrong one camera is.

    Attributes
    ----------
    rotation : float
        Degrees.
    position : float
        Share of the size of the rig, which is the largest distance between two of the true cameras.
    focal : float
        Share: estimated by true focal length (geometric mean of fx and fy), less one.
    """

    rotation: float
    position: float
    focal: float


def nearest_rotation(matrix: Array) -> Array:
    """Rotation matrix that is nearest to a matrix."""
    u, _, vt = np.linalg.svd(matrix)
    rotation: Array = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return rotation


def _orientation(true: list[Array], found: list[Array]) -> Array:
    """World rotation Q such that found ≈ true Qᵀ, robustly."""
    turns = [f.T @ t for t, f in zip(true, found, strict=True)]
    errors = np.array(
        [[angle_between(f @ turn, t) for t, f in zip(true, found, strict=True)] for turn in turns]
    )
    best = int(np.median(errors, axis=1).argmin())
    near = errors[best] <= 3 * np.median(errors[best]) + 1e-9
    return nearest_rotation(np.array(turns)[near].sum(axis=0))


def _similarity(true: Array, found: Array) -> tuple[float, Array]:
    """Scale and shift that move (n, 3) found places, already turned, on the true ones, robustly."""
    (scale, shift), least = (1.0, np.zeros(3)), np.inf
    for i, j in combinations(range(len(true)), 2):
        s = float(np.linalg.norm(true[i] - true[j])) / max(float(np.linalg.norm(found[i] - found[j])), 1e-12)
        move = (true[i] + true[j]) / 2 - s * (found[i] + found[j]) / 2
        median = float(np.median(np.linalg.norm(s * found + move - true, axis=1)))
        if median < least:
            (scale, shift), least = (s, move), median
    near = np.linalg.norm(scale * found + shift - true, axis=1) <= 3 * least + 1e-9
    if near.sum() < 2:
        return scale, shift
    middle, there = found[near].mean(axis=0), true[near].mean(axis=0)
    ours, theirs = found[near] - middle, true[near] - there
    scale = float((ours * theirs).sum() / (ours**2).sum())
    return scale, there - scale * middle


def _laid_over(
    situation: Situation | Staging, found: Mapping[str, Camera]
) -> tuple[list[Camera], Array, Array, tuple[float, Array]]:
    """True cameras, the turn of the world, the places found as turned by it, and the similarity of these."""
    known = {camera.name: camera for camera in situation.cameras}
    true = [known[name] for name in found]
    turn = _orientation([camera.R for camera in true], [camera.R for camera in found.values()])
    turned = np.array([camera.centre for camera in found.values()]) @ turn
    return true, turn, turned, _similarity(np.array([camera.centre for camera in true]), turned)


def accepted_cameras(network: NetworkParts) -> dict[str, Camera]:
    """Return the accepted cameras of a network as :func:`network_errors` takes them, by their names.

    Lengths are in the network's unit.
    """
    found = {}
    for name, camera in network.cameras.items():
        if not camera.accepted:
            continue
        assert camera.matrix is not None
        assert camera.rotation is not None
        assert camera.translation is not None
        distortions = () if camera.distortions is None else tuple(map(float, camera.distortions))
        found[name] = Camera(
            camera.matrix, camera.rotation, camera.translation, camera.size, name, distortions
        )
    return found


def network_errors(situation: Situation | Staging, found: Mapping[str, Camera]) -> dict[str, CameraError]:
    """Hold calibrated cameras against the true ones.

    Parameters
    ----------
    situation : Situation or Staging
        Its cameras are the true ones, by their names.
    found : mapping of name to Camera
        Two cameras of the situation or more, in a world of their own.

    Returns
    -------
    dict of name to CameraError
    """
    true, turn, turned, (scale, shift) = _laid_over(situation, found)
    centres = [camera.centre for camera in true]
    size = max(np.linalg.norm(one - other) for one, other in combinations(centres, 2))
    return {
        name: CameraError(
            angle_between(estimate.R @ turn, camera.R),
            float(np.linalg.norm(scale * place + shift - camera.centre) / size),
            float(np.sqrt(np.prod(np.diag(estimate.K)[:2]) / np.prod(np.diag(camera.K)[:2])) - 1),
        )
        for name, camera, estimate, place in zip(found, true, found.values(), turned, strict=True)
    }


def position_errors(situation: Situation | Staging, found: Mapping[str, Camera]) -> dict[str, Array]:
    """Return how far each camera of a network is from where it truly stands, and which way.

    Parameters and alignment as of :func:`network_errors`.

    Returns
    -------
    dict of name to ndarray, shape (3,)
        From the true place to the one found, along the axes of the network and in its unit.
    """
    true, turn, turned, (scale, shift) = _laid_over(situation, found)
    places = np.array([camera.centre for camera in true])
    return dict(zip(found, (turned + (shift - places) / scale) @ turn.T, strict=True))


@dataclass(frozen=True)
class WorldError:
    """How wrong the world of a network is, over the cameras that stand.

    Attributes
    ----------
    vertical : float
        Angle between its z and the true up, degrees.
    floor : float
        Mean distance of its z = 0 from the true floor where things moved, metres.
    unit : float
        Metres that one of its units measures in truth.
    """

    vertical: float
    floor: float
    unit: float


def world_error(situation: Situation | Staging, found: Mapping[str, Camera]) -> WorldError:
    """Hold vertical, floor and scale of a network against the truth; cameras as of :func:`network_errors`."""
    _, turn, _, (unit, origin) = _laid_over(situation, found)
    up = turn[2]
    beside = situation.volume_points[:, :2] - origin[:2]
    heights = origin[2] - beside @ up[:2] / up[2]
    vertical = np.rad2deg(np.arctan2(np.hypot(up[0], up[1]), up[2]))
    return WorldError(float(vertical), float(np.abs(heights).mean()), unit)


def pair_error(situation: Situation, found: Mapping[str, Camera], a: int, b: int) -> float:
    """Mean symmetric epipolar distance of a pair of calibrated cameras over the volume, pixels.

    Where the true lenses show a point is taken through the estimated lenses, so that it is in undistorted
    pixels of the estimated cameras. NaN where the two see nothing in common.
    """
    points = situation.correspondences(a, b, lens=True)
    if not len(points[0]):
        return float("nan")
    one, other = (found[situation.cameras[index].name] for index in (a, b))
    straight = one.undistort(points[0]), other.undistort(points[1])
    return float(symmetric_epipolar_distance(true_fundamental(one, other), *straight).mean())
