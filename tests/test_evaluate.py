"""A run against known cameras, called from Python: its numbers against those that are known beforehand."""

import json

import cv2
import numpy as np
import pytest

import epibar
from epibar import export, geometry, synthetic
from epibar.geometry import FrontierPoints
from epibar.lens import Intrinsics

SHIFT = 2.0
"""Pixels by which the F of one pair is off, in B and upwards."""


@pytest.fixture(scope="module")
def scene():
    return synthetic.people(seed=3, cameras=3, walkers=4, frames=60, asymmetric=True)


@pytest.fixture(scope="module")
def cameras(scene):
    return [
        Intrinsics(
            f"cam{index + 1}",
            camera.size,
            camera.K,
            rotation=cv2.Rodrigues(camera.R)[0].ravel(),
            translation=camera.t,
        )
        for index, camera in enumerate(scene.cameras)
    ]


def frontier_points(scene, a, b):
    points_a, points_b = scene.volume_correspondences(a, b)
    count = len(points_a)
    return FrontierPoints(np.zeros(count, np.int64), points_a, points_b, np.zeros(count))


@pytest.fixture(scope="module")
def run(scene):
    """The first pair is right, the second is shifted and was refused, the third has no F."""
    shifted = np.array([[1.0, 0, 0], [0, 1, SHIFT], [0, 0, 1]])
    found = {(0, 1): scene.fundamental(0, 1), (0, 2): shifted.T @ scene.fundamental(0, 2), (1, 2): None}
    pairs = [
        export.Pair(
            f"cam{a + 1}",
            f"cam{b + 1}",
            F,
            accepted=(a, b) == (0, 1),
            kind="accepted" if (a, b) == (0, 1) else "ambiguous",
            reason="",
            expected_error=0.5 if (a, b) == (0, 1) else None,
            time_offset=0.0,
            frontier_points=frontier_points(scene, a, b),
        )
        for (a, b), F in found.items()
    ]
    names = [export.Camera(f"cam{index + 1}", camera.size) for index, camera in enumerate(scene.cameras)]
    return export.Run(names, pairs)


def distances(F, a, b):
    """Point by point, as the definition says it."""
    found = []
    for x, y in zip(a, b, strict=True):
        x, y = np.append(x, 1), np.append(y, 1)
        in_b, in_a = F @ x, F.T @ y
        found.append((abs(y @ in_b) / np.hypot(*in_b[:2]) + abs(x @ in_a) / np.hypot(*in_a[:2])) / 2)
    return np.array(found)


def test_a_right_pair_has_no_error(run, cameras):
    right = epibar.evaluate(run, cameras).pairs[0]
    assert (right.name, right.accepted, right.expected_error) == ("cam1 - cam2", True, 0.5)
    assert right.volume_error < 1e-6
    assert right.image_error < 1e-6


def test_the_error_of_a_pair_that_is_off(run, cameras, scene):
    off = epibar.evaluate(run, cameras).pairs[1]
    assert not off.accepted
    a, b = scene.cameras[0], scene.cameras[2]
    # The volume is the box of all points that the true cameras triangulate, so made here in another way.
    pairs = [(0, 1), (0, 2), (1, 2)]
    world = np.concatenate([seen_by(scene, *pair) for pair in pairs])
    box = np.percentile(world, (3, 97), axis=0)
    points = np.random.default_rng(0).uniform(*box, (10_000, 3))
    x_a, x_b = a.project(points)[0], b.project(points)[0]
    inside = geometry.inside(x_a, a.size) & geometry.inside(x_b, b.size)
    expected = distances(run.pairs[1].F, x_a[inside][::10], x_b[inside][::10]).mean()
    assert off.volume_error == pytest.approx(expected, rel=0.02)
    assert off.volume_error == pytest.approx(SHIFT, rel=0.5)


def seen_by(scene, a, b):
    """World points that both cameras see."""
    visible = scene.visible(a) & scene.visible(b)
    return scene.volume_points[visible]


def test_what_cannot_be_measured_is_none(run, cameras):
    without = epibar.evaluate(run, cameras).pairs[2]
    assert (without.volume_error, without.image_error) == (None, None)
    nowhere = export.Run(
        run.cameras,
        [export.Pair("cam1", "cam2", run.pairs[0].F, True, "accepted", "", None, 0.0, nothing())],
    )
    found = epibar.evaluate(nowhere, cameras)
    assert not found.volume_known
    assert found.pairs[0].volume_error is None
    assert found.pairs[0].image_error < 1e-6


def nothing():
    return FrontierPoints(np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))


def test_it_is_plain_for_json(run, cameras):
    content = json.loads(json.dumps(epibar.evaluate(run, cameras).as_dict(), allow_nan=False))
    assert content["volume_known"] is True
    assert [pair["b"] for pair in content["pairs"]] == ["cam2", "cam3", "cam3"]
    assert content["warnings"] == []


def test_a_lens_that_was_not_taken_out_is_told(run, cameras):
    bent = [
        Intrinsics(c.name, c.size, c.matrix, [-0.3, 0, 0, 0, 0], False, c.rotation, c.translation)
        for c in cameras
    ]
    assert "lens distortion" in epibar.evaluate(run, bent).warnings[0]


def test_cameras_without_a_pose(run, cameras):
    unposed = [Intrinsics(c.name, c.size, c.matrix) for c in cameras]
    with pytest.raises(epibar.EpibarError, match="no rotation and translation"):
        epibar.evaluate(run, unposed)
