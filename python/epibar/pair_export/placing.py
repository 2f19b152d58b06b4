"""Relative poses of pairs put together into one world; each is known up to the length of its baseline.

Rotations: the least squares of ``R_b = R_ab R_a`` over all pairs, by eigenvectors, then made orthogonal
(Martinec and Pajdla, *Robust rotation and translation estimation in multiview reconstruction*, CVPR 2007).

Positions c and baselines s, up to one common scale, are the null vector of a linear system: ``c_b − c_a = s
d`` for the direction d of each pair; and for two pairs with a camera in common the ratio of their
baselines, from the frontier points that are one corner of one silhouette in that camera: its depth, in the
unit of either baseline, is one and the same. Triangles determine the ratios by their directions, chains and
cameras in a row by such points.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from ..arguments import Array
from ..errors import EpibarError
from ..geometry.pose import RelativePose, depths
from ..geometry.vectors import angle_between
from ..outcome.run import Pair, Run

__all__ = ["place_cameras"]

Name = tuple[str, str]

CONTRADICTION = 5.0
"""Degrees by which a pair may disagree with the others."""
WEAKEST = 0.05
"""Second smallest singular value, of rows of length about one: below it a second solution fits as well."""
LEAST_SHARED = 20
RATIO_SCATTER = 0.2
"""Quartile distance of a ratio of baselines over its median: above this the shared points say nothing."""


def place_cameras(run: Run, poses: Mapping[Name, RelativePose]) -> dict[str, tuple[Array, Array]]:
    """Place every camera that has a pose to another one.

    Parameters
    ----------
    run : Run
        With the pairs of ``poses``, and the camera matrices.
    poses : mapping of (str, str) to RelativePose

    Returns
    -------
    dict of str to (R, t)
        World to camera, ``X_c = R X + t``, in the order of the run. The first camera is the world; the
        first pair's baseline is the unit of length.

    Raises
    ------
    EpibarError
        The pairs fall apart into groups, do not determine the ratios of their baselines, or contradict each
        other.
    """
    names = [camera.name for camera in run.cameras if any(camera.name in pair for pair in poses)]
    if len(names) < 2:
        raise EpibarError("no pair has a pose: no camera can be placed")
    _check_connected(names, poses)
    rotations = _rotations(names, poses)
    positions = _positions(names, poses, rotations, _ratios(run, poses))
    return {name: (rotations[name], -rotations[name] @ positions[name]) for name in names}


def _check_connected(names: list[str], poses: Mapping[Name, RelativePose]) -> None:
    reached = {names[0]}
    for _ in names:
        reached |= {name for pair in poses if set(pair) & reached for name in pair}
    apart = [name for name in names if name not in reached]
    if apart:
        raise EpibarError(
            f"{', '.join(apart)}: no chain of pairs with a pose leads from {names[0]} here, "
            "so these cameras cannot stand in one world"
        )


def _rotations(names: list[str], poses: Mapping[Name, RelativePose]) -> dict[str, Array]:
    count = len(names)
    normal = np.zeros((3 * count, 3 * count))
    for (a, b), pose in poses.items():
        rows = np.zeros((3, 3 * count))
        rows[:, _block(names, a)], rows[:, _block(names, b)] = -pose.R, np.eye(3)
        normal += rows.T @ rows
    stacked = np.linalg.eigh(normal)[1][:, :3].reshape(count, 3, 3)
    if np.linalg.det(stacked[0]) < 0:
        stacked = -stacked
    orthogonal = np.array([_nearest_rotation(block) for block in stacked])
    found = {name: R @ orthogonal[0].T for name, R in zip(names, orthogonal, strict=True)}
    for (a, b), pose in poses.items():
        off = angle_between(found[b] @ found[a].T, pose.R)
        if off > CONTRADICTION:
            raise EpibarError(f"{a} - {b}: its rotation is {off:.1f}° off from what the other pairs say")
    return found


def _nearest_rotation(matrix: Array) -> Array:
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag((1.0, 1.0, np.linalg.det(u @ vt))) @ vt)


def _block(names: list[str], name: str) -> slice:
    place = names.index(name)
    return slice(3 * place, 3 * place + 3)


def _ratios(run: Run, poses: Mapping[Name, RelativePose]) -> dict[tuple[Name, Name], float]:
    """Baseline of the second pair over the first's, for pairs with a camera and enough points in common."""
    seen = {
        (pair.a, pair.b): _depth_of_corners(run, pair, poses)
        for pair in run.pairs
        if (pair.a, pair.b) in poses
    }
    found = {}
    for first, second in combinations(poses, 2):
        for camera in set(first) & set(second):
            one, other = seen[first][camera], seen[second][camera]
            ratios = np.array([one[corner] / other[corner] for corner in one.keys() & other.keys()])
            if len(ratios) < LEAST_SHARED:
                continue
            low, middle, high = np.percentile(ratios, (25, 50, 75))
            if high - low < RATIO_SCATTER * middle:
                found[first, second] = float(middle)
    return found


def _depth_of_corners(
    run: Run, pair: Pair, poses: Mapping[Name, RelativePose]
) -> dict[str, dict[tuple[int, float, float], float]]:
    """Depth of each frontier point by camera, then by frame and pixel, in units of the pair's baseline."""
    matrices = {camera.name: camera.matrix for camera in run.cameras}
    K_a, K_b = matrices[pair.a], matrices[pair.b]
    assert K_a is not None
    assert K_b is not None
    points = pair.frontier_points
    both = depths(poses[pair.a, pair.b], points.a, points.b, K_a, K_b)
    usable = np.isfinite(both).all(axis=0) & (np.array(both) > 0).all(axis=0)
    found = {}
    for name, frames, pixels, depth in (
        (pair.a, points.frame, points.a, both[0]),
        (pair.b, pair.frames_b, points.b, both[1]),
    ):
        corners = zip(frames[usable].tolist(), *pixels[usable].T.tolist(), strict=True)
        found[name] = dict(zip(corners, depth[usable].tolist(), strict=True))
    return found


def _positions(
    names: list[str],
    poses: Mapping[Name, RelativePose],
    rotations: Mapping[str, Array],
    ratios: Mapping[tuple[Name, Name], float],
) -> dict[str, Array]:
    """Position of each camera; the first is the origin, the first pair's baseline is 1."""
    pairs = list(poses)
    free = 3 * (len(names) - 1)
    rows = []
    directions = {(a, b): -rotations[b].T @ poses[a, b].t for a, b in pairs}
    for place, (a, b) in enumerate(pairs):
        block = np.zeros((3, 3 * len(names) + len(pairs)))
        block[:, _block(names, b)], block[:, _block(names, a)] = np.eye(3), -np.eye(3)
        block[:, 3 * len(names) + place] = -directions[a, b]
        rows.append(block[:, 3:])
    for (first, second), ratio in ratios.items():
        row = np.zeros((1, free + len(pairs)))
        row[0, free + pairs.index(first)], row[0, free + pairs.index(second)] = ratio, -1.0
        rows.append(row / np.hypot(ratio, 1.0))
    singular, vectors = np.linalg.svd(np.concatenate(rows))[1:]
    # Padded: with fewer equations than unknowns the missing singular values are zero.
    singular = np.concatenate([singular, np.zeros(len(vectors) - len(singular))])
    if singular[-2] < WEAKEST:
        raise EpibarError(
            "the pairs do not determine the ratios of their baselines: that takes three cameras not in one "
            f"line with all three pairs, or {LEAST_SHARED} frontier points that two pairs have in common"
        )
    solution = vectors[-1] / vectors[-1][free]
    scales = dict(zip(pairs, solution[free:], strict=True))
    places = dict(zip(names, np.concatenate([np.zeros(3), solution[:free]]).reshape(-1, 3), strict=True))
    for (a, b), direction in directions.items():
        between = places[b] - places[a]
        cosine = between @ direction / max(float(np.linalg.norm(between)), 1e-300)
        off = float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
        if scales[a, b] <= 0 or off > CONTRADICTION:
            raise EpibarError(f"{a} - {b}: its direction is {off:.1f}° off from what the other pairs say")
    unit = float(np.linalg.norm(places[pairs[0][1]] - places[pairs[0][0]]))
    return {name: place / unit for name, place in places.items()}
