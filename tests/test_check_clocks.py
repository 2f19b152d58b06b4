"""New footage of which nobody knows when it began: of people who walk one way at one speed, and of others."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest

import epibar
from epibar.network import Ground, NetworkCamera, NetworkClock, NetworkPair
from epibar.network.parts import METRE, NetworkPairs
from epibar.synthetic import Camera, true_fundamental

FPS, FRAMES, SIZE = 8.0, 360, (480, 360)
CAMERAS = {
    "cam1": Camera.look_at((-4.1, -2.6, 2.3), (-0.5, 0.0, 0.9), 325.0, SIZE),
    "cam2": Camera.look_at((1.5, 2.9, 2.5), (0.4, 0.0, 0.9), 340.0, SIZE),
    "cam3": Camera.look_at((4.4, -2.3, 2.2), (0.1, 0.0, 0.9), 320.0, SIZE),
}
WHOLE = {"cam1": 0.0, "cam2": 1.75, "cam3": -2.25}
"""By how many seconds each began after the first, whole frames: nothing is drawn between them."""
BETWEEN = {"cam1": 0.0, "cam2": 0.5625, "cam3": -2.42125}
"""The same between frames, to which offsets are pulled."""


def stored() -> epibar.Network:
    """Make the true network."""
    errors = {"focal": 0.004, "rotation": 0.05, "position": 0.01}
    made = {
        name: NetworkCamera(
            name, SIZE, True, "accepted", "true", c.K, np.zeros(5), c.R, c.t, dict(errors),
            position_covariance=np.eye(3) * 0.004**2,
        )
        for name, c in CAMERAS.items()
    }  # fmt: skip
    names = list(CAMERAS)
    pairs = [
        NetworkPair(a, b, True, "confirmed", true_fundamental(CAMERAS[a], CAMERAS[b]), {"tangents": 9.0})
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    ]
    clocks = {name: NetworkClock(0.0, 0.0, 0.0) for name in names}
    ground = Ground("floor", 1.72, 0.1, 400, 0.1, level_error=0.01)
    return epibar.Network(made, NetworkPairs(pairs), clocks, True, "the true one", METRE, ground, 1.0)


def body(wide: float, tall: float) -> np.ndarray:
    """Points of somebody who stands at the origin."""
    around = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    heights = np.linspace(0.0, tall, 10)
    radii = wide * np.sqrt(np.clip(1 - ((heights / tall - 0.55) / 0.57) ** 2, 0, 1))
    return np.concatenate(
        [np.column_stack([r * ring, np.full(10, z)]) for r, z in zip(radii, heights, strict=True)]
    )


def draw(mask: np.ndarray, camera: Camera, points: np.ndarray) -> None:
    """Draw somebody whom a camera sees whole."""
    pixels, depths = camera.project(points)
    if (depths > 0.3).all():
        outline = cv2.convexHull(pixels.astype(np.float32))
        cv2.fillConvexPoly(mask, np.round(outline).astype(np.int32), 1)


def filmed(camera: Camera, later: float, seed: int, empty: int = 0) -> epibar.Recording:
    """Film who passes along a corridor, from so many seconds on; nobody in so many frames before."""
    rng = np.random.default_rng(seed)
    masks = np.zeros((FRAMES + empty, SIZE[1], SIZE[0]), np.uint8)
    start = -80.0
    while start < 80.0:
        start += rng.uniform(2.4, 6.0)
        across, wide, tall, speed = rng.uniform((-0.6, 0.18, 1.5, 1.14), (0.6, 0.28, 1.95, 1.26))
        points = body(wide, tall)
        for frame, mask in enumerate(masks[empty:]):
            along = start + speed * (frame / FPS + later)
            if abs(along) < 7.0:
                draw(mask, camera, points + np.array([along, across, 0.0]))
    return epibar.Recording.from_masks(masks, fps=FPS, lines=4000, seed=0)


def walking(camera: Camera, later: float, seed: int) -> epibar.Recording:
    """Film four people who walk as they like, from so many seconds on."""
    rng = np.random.default_rng(seed)
    masks = np.zeros((FRAMES, SIZE[1], SIZE[0]), np.uint8)
    for _ in range(4):
        goals = rng.uniform(-2.2, 2.2, (30, 2))
        points = body(rng.uniform(0.18, 0.26), rng.uniform(1.55, 1.9))
        gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(goals, axis=0), axis=1))])
        for frame, mask in enumerate(masks):
            on = 5.0 + 1.1 * (frame / FPS + later)
            x, y = (np.interp(on, gone, goals[:, axis]) for axis in (0, 1))
            draw(mask, camera, points + np.array([x, y, 0.0]))
    return epibar.Recording.from_masks(masks, fps=FPS, lines=4000, seed=0)


@pytest.mark.parametrize(("later", "seed", "empty"), [(WHOLE, 3, 0), (BETWEEN, 1, 0), (BETWEEN, 1, 480)])
def test_cameras_that_stand_are_not_said_to_have_moved(
    later: dict[str, float], seed: int, empty: int
) -> None:
    films = {name: filmed(camera, later[name], seed, empty) for name, camera in CAMERAS.items()}
    check = stored().check(films)
    assert check.ok, check.reason
    # The clock of the first camera is known no better than theirs, which are told by it.
    first, *others = (check.cameras[name].shifted_error for name in CAMERAS)
    assert first > 0.5 * min(others), (first, others)


def test_a_turn_is_noticed_by_people_who_walk_as_they_like() -> None:
    turned = cv2.Rodrigues(np.array([0.0, np.deg2rad(0.4), 0.0]))[0]
    camera = CAMERAS["cam1"]
    now = CAMERAS | {"cam1": dataclasses.replace(camera, R=turned @ camera.R, t=turned @ camera.t)}
    check = stored().check({name: walking(camera, BETWEEN[name], 2) for name, camera in now.items()})
    # Of three cameras it may not be known which moved, but that one did.
    assert "cam1" in check.moved + check.suspects, check.reason
    moved = check.cameras["cam1"]
    assert abs(moved.turned - 0.4) < moved.turned_error < 0.2, moved
