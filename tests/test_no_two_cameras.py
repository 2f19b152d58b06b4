"""One camera that sees all without the same part is told where there are no two cameras that see that."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import epibar
from epibar.synthetic import Camera

FPS, FRAMES, SIZE = 12.5, 400, (480, 360)
A = Camera.look_at((-9.0, -6.0, 3.6), (0.0, 0.0, 0.9), 420.0, SIZE)
B = Camera.look_at((8.0, -7.5, 4.4), (0.0, 0.0, 0.9), 400.0, SIZE)
WALKERS, TALL = 6, 1.72


def paths(seed: int) -> np.ndarray:
    """Let everybody walk between places of a hall, metres: (walkers, frames, 2)."""
    rng = np.random.default_rng(seed)
    found = np.empty((WALKERS, FRAMES, 2))
    for path in found:
        at, to = rng.uniform(-4.5, 4.5, (2, 2))
        for frame in range(FRAMES):
            if np.linalg.norm(to - at) < 0.3:
                to = rng.uniform(-4.5, 4.5, 2)
            at = at + (to - at) / np.linalg.norm(to - at) * 1.3 / FPS
            path[frame] = at
    return found


def filmed(
    camera: Camera, places: np.ndarray, lowest: float, matrix: np.ndarray | None = None
) -> epibar.Recording:
    """Film upright bodies from so many metres above the floor on."""
    heights = np.linspace(lowest, TALL, 12)
    around = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    wide = 0.24 * np.sqrt(np.clip(1 - ((heights - 0.9) / 0.95) ** 2, 0, 1))
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    body = np.concatenate(
        [np.column_stack([radius * ring, np.full(10, z)]) for radius, z in zip(wide, heights, strict=True)]
    )
    masks = np.zeros((FRAMES, SIZE[1], SIZE[0]), np.uint8)
    for frame, mask in enumerate(masks):
        for at in places[:, frame]:
            pixels = cv2.convexHull(camera.project(body + np.append(at, 0.0))[0].astype(np.float32))
            cv2.fillConvexPoly(mask, np.round(pixels).astype(np.int32), 1)
    return epibar.Recording.from_masks(masks, fps=FPS, lines=5000, seed=0, matrix=matrix)


def error(found: epibar.Calibration) -> float:
    rng = np.random.default_rng(0)
    points = rng.uniform((-4.0, -4.0, 0.0), (4.0, 4.0, TALL), (300, 3))
    in_a, in_b = A.project(points)[0], B.project(points)[0]
    return float(epibar.symmetric_epipolar_distance(found.F, in_a, in_b).mean())


@pytest.fixture(scope="module")
def whole() -> epibar.Recording:
    return filmed(B, paths(5), 0.0)


def test_both_see_all_of_everybody(whole: epibar.Recording) -> None:
    found = epibar.calibrate(filmed(A, paths(5), 0.0), whole, seed=0)
    assert found.accepted, found.reason
    assert error(found) < 1.0, error(found)
    assert "No two cameras" not in found.reason


def test_one_sees_nobodys_legs(whole: epibar.Recording) -> None:
    found = epibar.calibrate(filmed(A, paths(5), 0.9), whole, seed=0)
    assert not found.accepted, error(found)
    assert found.kind == "inaccurate"
    assert "No two cameras" in found.reason


def test_one_sees_nobodys_feet(whole: epibar.Recording) -> None:
    found = epibar.calibrate(filmed(A, paths(5), 0.3), whole, seed=0)
    assert "No two cameras" in found.reason, (found.reason, error(found))
    # What is stated grows with how far it is from two cameras; without that it is 0.65 px.
    assert error(found) < 3.0 * found.expected_error, (error(found), found.expected_error)


@pytest.mark.parametrize("lowest", [0.0, 0.3])
def test_known_cameras_of_which_one_sees_nobodys_feet(lowest: float) -> None:
    pair = [filmed(camera, paths(5), low, camera.K) for camera, low in ((A, lowest), (B, 0.0))]
    found = epibar.calibrate(*pair, seed=0)
    assert found.accepted == (lowest == 0.0), (found.reason, error(found))
    assert ("contradict" in found.reason) == (lowest > 0.0), found.reason
    assert not found.accepted or error(found) < found.expected_error
