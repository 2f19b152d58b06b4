"""Poses of made-up scenes, and how far found ones are from them."""

import numpy as np

DEGREES = 1.0
"""What a pose may be off."""


def angle(R, other):
    return np.degrees(np.arccos(np.clip((np.trace(R @ other.T) - 1) / 2, -1, 1)))


def between(u, v):
    return np.degrees(np.arccos(np.clip(u @ v / np.linalg.norm(u) / np.linalg.norm(v), -1, 1)))


def true_pose(a, b):
    R = b.R @ a.R.T
    return R, b.t - R @ a.t


def world_error(scene, placed, order):
    """Largest error of rotation and of direction to any camera, degrees, and of distances as a share."""
    first = scene.cameras[order[0]]
    unit = None
    worst = [0.0, 0.0, 0.0]
    for (R, t), index in zip(placed.values(), order, strict=True):
        camera = scene.cameras[index]
        true_R, true_t = true_pose(first, camera)
        worst[0] = max(worst[0], angle(R, true_R))
        if index == order[0]:
            continue
        position, true = -R.T @ t, -true_R.T @ true_t
        unit = unit or np.linalg.norm(position) / np.linalg.norm(true)
        worst[1] = max(worst[1], between(position, true))
        worst[2] = max(worst[2], abs(np.linalg.norm(position) / np.linalg.norm(true) / unit - 1))
    return worst
