"""What opponents are given of a network, and how far off cameras are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np
from common import Array
from networks_recordings import angle

from epibar import Calibration
from epibar.synthetic import Camera


@dataclass(frozen=True)
class Matches:
    """Points of a pair, (n, 2) each, and its fundamental matrix; pixels whose centres are whole numbers."""

    a: Array
    b: Array
    F: Array


@dataclass(frozen=True)
class Views:
    """Cameras with the points of their pairs.

    Attributes
    ----------
    sizes : dict
        Width and height of each camera's image.
    pairs : dict
        By the names of two cameras.
    matrices : dict or None
        Camera matrices, where they are known.
    bent : bool
        The points are as an unknown lens shows them.
    """

    sizes: dict[str, tuple[int, int]]
    pairs: dict[tuple[str, str], Matches]
    matrices: dict[str, Array] | None
    bent: bool


KNOWLEDGE = ("nothing", "lens", "intrinsics")
"""What the opponents know of the cameras; a known lens is taken out of the points."""


CLOSE = 0.01
"""Pixels: a point without its lens must come back this near when the lens is put back."""
STEPS = 100
"""Steps towards that, each of what is missing: they end anywhere where there is no such point."""


def straight(camera: Camera, pixels: Array) -> Array:
    """Take (n, 2) pixels to where they are without the true lens, NaN where the lens shows nothing."""
    if not camera.distorted:
        return pixels
    lens, focal, nowhere = np.array(camera.distortions), camera.K[[0, 1], [0, 1]], np.zeros(3)
    moved = pixels.copy()
    for _ in range(STEPS):
        ahead = np.column_stack([(moved - camera.K[:2, 2]) / focal, np.ones(len(moved))])
        missing = pixels - cv2.projectPoints(ahead, nowhere, nowhere, camera.K, lens)[0].reshape(-1, 2)
        moved += missing
    moved[~(np.linalg.norm(missing, axis=1) < CLOSE)] = np.nan
    return moved


def views_of(
    true: Mapping[str, Camera], pairs: Mapping[tuple[str, str], Calibration], knowledge: str, points: int
) -> Views:
    """Take so many frontier points, evenly over time, of each pair that has a geometry."""
    found = {}
    for (one, other), pair in pairs.items():
        if pair.F is None:
            continue
        order = pair.frontier_points.frame.argsort(kind="stable")
        some = order[np.linspace(0, len(order) - 1, min(points, len(order))).round().astype(int)]
        a, b, F = pair.frontier_points.a[some], pair.frontier_points.b[some], pair.F
        if knowledge != "nothing" and (true[one].distorted or true[other].distorted):
            a, b = straight(true[one], a), straight(true[other], b)
            there = np.isfinite(np.hstack([a, b])).all(axis=1)
            a, b = a[there], b[there]
            F, _ = cv2.findFundamentalMat(a, b, cv2.USAC_MAGSAC, 1.0, 0.9999, 10_000)
        if F is not None and F.shape == (3, 3):
            found[one, other] = Matches(np.asarray(a, np.float64), np.asarray(b, np.float64), F)
    matrices = {name: camera.K for name, camera in true.items()} if knowledge == "intrinsics" else None
    return Views({n: c.size for n, c in true.items()}, found, matrices, knowledge == "nothing")


def with_focal(views: Views, focals: Mapping[str, float]) -> Views:
    """The same views with square pixels, principal points in the middle and these focal lengths."""
    matrices = {}
    for name, focal in focals.items():
        width, height = views.sizes[name]
        matrices[name] = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    return replace(views, matrices=matrices)


@dataclass(frozen=True)
class Errors:
    """How far off: of focal lengths and positions one number a camera, of rotations one for each two cameras.

    Attributes
    ----------
    focal : ndarray
        Share of the true focal length, geometric means of fx and fy.
    rotation : ndarray
        Degrees.
    position : ndarray
        After the similarity that fits the positions best; share of the largest distance between two of all
        true cameras.
    """

    focal: Array
    rotation: Array
    position: Array


def similar(points: Array, there: Array) -> Array:
    """Move (n, 3) points on others by the similarity that fits them best (Umeyama 1991)."""
    here, target = points - points.mean(axis=0), there - there.mean(axis=0)
    u, s, vt = np.linalg.svd(target.T @ here)
    sign = np.diag([1.0, 1.0, np.linalg.det(u @ vt)])
    scale = (s * np.diag(sign)).sum() / max((here**2).sum(), 1e-300)
    moved: Array = scale * here @ (u @ sign @ vt).T + there.mean(axis=0)
    return moved


def errors_of(true: Mapping[str, Camera], found: Mapping[str, Camera]) -> Errors:
    """Hold two cameras or more against the true ones."""
    names = list(found)
    rig = max(np.linalg.norm(p.centre - q.centre) for p, q in combinations(true.values(), 2))

    def focal(camera: Camera) -> float:
        return float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))

    def turned(one: Camera, other: Camera) -> Array:
        return one.R @ other.R.T

    there = np.array([true[name].centre for name in names])
    placed = similar(np.array([found[name].centre for name in names]), there)
    turns = [
        angle(turned(found[p], found[q]) @ turned(true[p], true[q]).T) for p, q in combinations(names, 2)
    ]
    return Errors(
        np.array([abs(focal(found[name]) / focal(true[name]) - 1) for name in names]),
        np.array(turns),
        np.linalg.norm(placed - there, axis=1) / rig,
    )
