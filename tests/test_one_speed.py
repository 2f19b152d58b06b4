"""Where all moves one way at one speed nothing tells the clocks: a wrong offset has a geometry that fits."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import epibar
from epibar.synthetic import Camera, true_fundamental

FPS, FRAMES, SIZE = 10.0, 500, (320, 240)
A = Camera.look_at((-5.0, -6.0, 3.0), (0.0, 0.0, 0.8), 260.0, SIZE)
B = Camera.look_at((3.0, 5.5, 2.6), (0.0, 0.0, 0.9), 270.0, SIZE)


def passers(seed: int, spread: float) -> list[tuple[float, float, float, float, float]]:
    """Draw who comes along: where at time 0, speed, lane, width and height, metres and metres a second."""
    rng = np.random.default_rng(seed)
    found, x = [], -8.0 - 1.4 * FRAMES / FPS
    while x < 8.0:
        x += rng.exponential(1.7)
        found.append(
            (
                x,
                1.4 * (1 + rng.normal(0, spread)),
                rng.uniform(-1.5, 1.5),
                rng.uniform(0.2, 0.35),
                rng.uniform(1.4, 2.0),
            )
        )
    return found


def filmed(camera: Camera, movers: list[tuple[float, ...]], later: float) -> np.ndarray:
    """Film boxes that pass, from so many seconds on."""
    masks = np.zeros((FRAMES, SIZE[1], SIZE[0]), np.uint8)
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (0, 1)], float)
    for frame, mask in enumerate(masks):
        for start, speed, lane, half, tall in movers:
            at = start + speed * (frame / FPS + later)
            if abs(at) < 6.0:
                box = np.array([at, lane, 0.0]) + corners * [half, half, tall]
                pixels = cv2.convexHull(camera.project(box)[0].astype(np.float32))
                cv2.fillConvexPoly(mask, np.round(pixels).astype(np.int32), 1)
    return masks


def recordings(spread: float, later: float) -> tuple[epibar.Recording, epibar.Recording]:
    movers = passers(3, spread)
    of_a, of_b = filmed(A, movers, 0.0), filmed(B, movers, later)
    return (
        epibar.Recording.from_masks(of_a, fps=FPS, lines=4000, seed=0),
        epibar.Recording.from_masks(of_b, fps=FPS, lines=4000, seed=1),
    )


def error(found: epibar.Calibration) -> float:
    rng = np.random.default_rng(0)
    points = rng.uniform((-3.0, -1.5, 0.0), (3.0, 1.5, 1.7), (300, 3))
    in_a, in_b = A.project(points)[0], B.project(points)[0]
    return float(epibar.symmetric_epipolar_distance(found.F, in_a, in_b).mean())


def test_the_scene_has_an_answer() -> None:
    points = np.array([[0.5, 0.3, 1.0]])
    F = true_fundamental(A, B)
    assert epibar.symmetric_epipolar_distance(F, A.project(points)[0], B.project(points)[0])[0] < 1e-6


@pytest.mark.parametrize("later", [0.0, 0.3])
def test_of_one_speed_an_offset_that_is_given_is_believed_and_no_other_one_found(later: float) -> None:
    a, b = recordings(0.0, later)
    told = epibar.calibrate(a, b, seed=0, time_offset=-later * FPS)
    assert told.accepted, told.reason
    assert "is believed, as what moves does not tell it" in told.reason
    assert error(told) < 1.0, error(told)
    found = epibar.calibrate(a, b, seed=0, time_offset="auto")
    assert not found.accepted, (found.time_offset, error(found))
    assert found.kind == "ambiguous"
    assert "Give the offset" in found.reason


def test_of_speeds_that_differ_a_little_a_wrong_offset_is_not_believed() -> None:
    a, b = recordings(0.1, 0.2)
    told = epibar.calibrate(a, b, seed=0, time_offset=0.0)
    assert not told.accepted, error(told)
    assert told.kind == "ambiguous"
    assert "speaks against the offset that was given" in told.reason


def test_of_speeds_that_differ_the_right_offset_needs_no_remark() -> None:
    a, b = recordings(0.25, 0.2)
    told = epibar.calibrate(a, b, seed=0, time_offset=-2.0)
    assert told.accepted, told.reason
    assert error(told) < 1.0, error(told)
    assert "believed" not in told.reason


def test_of_speeds_that_differ_the_offset_is_found() -> None:
    a, b = recordings(0.25, 0.2)
    found = epibar.calibrate(a, b, seed=0, time_offset="auto")
    assert found.accepted, found.reason
    assert error(found) < 1.0, (found.time_offset, error(found))
    assert abs(found.time_offset + 2.0) < 0.3, found.time_offset
