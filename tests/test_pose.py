"""Relative poses and cameras in one world, against those of the scene."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from known_poses import DEGREES, angle, between, true_pose, world_error

import epibar
from epibar import export, synthetic
from epibar.geometry.pose import RelativePose, relative_pose
from epibar.outcome.entries import pose_entry


@pytest.fixture(scope="module")
def scene():
    return synthetic.people(seed=5, cameras=3, walkers=6, frames=400, size=(320, 240), asymmetric=True)


@pytest.fixture(scope="module")
def calibration(scene):
    """Of the first and the last camera."""
    pair = [
        epibar.Recording.from_masks(scene.masks(index), fps=scene.fps, lines=4000, seed=index)
        for index in (0, 2)
    ]
    found = epibar.calibrate(*pair)
    assert found.accepted
    return found


def test_relative_pose(scene, calibration):
    a, b = scene.cameras[0], scene.cameras[2]
    pose = epibar.relative_pose(calibration, a.K, b.K)
    R, t = true_pose(a, b)
    assert angle(pose.R, R) < DEGREES
    assert between(pose.t, t) < DEGREES
    assert np.linalg.norm(pose.t) == pytest.approx(1)
    assert pose.in_front > 0.99 * pose.points
    assert pose.singular_ratio > 0.95
    # E belongs to the same R and t, and to F, whatever its sign.
    essential = b.K.T @ calibration.F @ a.K
    cosine = np.sum(essential * pose.E) / np.linalg.norm(essential) / np.linalg.norm(pose.E)
    assert abs(cosine) > 0.999


def test_swapped_cameras_give_the_inverse_pose(scene, calibration):
    a, b = scene.cameras[0], scene.cameras[2]
    points = calibration.frontier_points
    swapped = replace(calibration, F=calibration.F.T, frontier_points=replace(points, a=points.b, b=points.a))
    there, back = relative_pose(calibration, a.K, b.K), relative_pose(swapped, b.K, a.K)
    np.testing.assert_allclose(back.R, there.R.T, atol=1e-9)
    np.testing.assert_allclose(back.t, -there.R.T @ there.t, atol=1e-9)


def test_points_that_do_not_decide_are_refused(scene, calibration):
    """Half of the correspondences mirrored through B's epipole lie behind a camera."""
    a, b = scene.cameras[0], scene.cameras[2]
    points = calibration.frontier_points
    epipole = b.K @ (b.R @ a.centre + b.t)
    epipole = epipole[:2] / epipole[2]
    mirrored = points.b.copy()
    mirrored[::2] = 2 * epipole - mirrored[::2]
    undecided = replace(calibration, frontier_points=replace(points, b=mirrored))
    with pytest.raises(epibar.EpibarError, match="pose is not decided"):
        relative_pose(undecided, a.K, b.K)
    assert "not decided" in pose_entry(undecided, a.K, b.K)["reason"]


@pytest.mark.parametrize(
    ("change", "K", "words"),
    [
        ({"F": None}, np.eye(3), "no F"),
        ({}, np.eye(2), "K_b"),
        ({}, [["x"]], "K_b"),
        ({"frontier_points": 5}, np.eye(3), "frontier points"),
    ],
)
def test_no_pose(calibration, change, K, words):
    if change.get("frontier_points"):
        points = calibration.frontier_points
        few = {key: getattr(points, key)[:5] for key in ("frame", "a", "b", "residual")}
        change = {"frontier_points": epibar.FrontierPoints(**few)}
    with pytest.raises(epibar.EpibarError, match=words):
        relative_pose(replace(calibration, **change), np.eye(3), K)


def test_pose_entry_is_for_accepted_pairs_with_intrinsics(scene, calibration):
    K_a, K_b = scene.cameras[0].K, scene.cameras[2].K
    assert pose_entry(replace(calibration, accepted=False), K_a, K_b) is None
    assert pose_entry(calibration, None, K_b) is None
    entry = pose_entry(calibration, K_a, K_b)
    assert set(entry) == {"convention", "E", "R", "t", "points", "in_front", "singular_ratio"}


def made_up(scene, pairs, noise=0.0):
    """A run without frontier points in common, and the true poses, turned by some noise in degrees."""
    rng = np.random.default_rng(3)
    none = epibar.FrontierPoints(np.empty(0, int), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
    names = [f"cam{i + 1}" for i in range(len(scene.cameras))]
    cameras = [export.Camera(n, c.size, c.K) for n, c in zip(names, scene.cameras, strict=True)]
    rows, poses = [], {}
    for i, j in pairs:
        R, t = true_pose(scene.cameras[i], scene.cameras[j])
        R = cv2.Rodrigues(np.deg2rad(noise) * rng.normal(size=3))[0] @ R
        t = t / np.linalg.norm(t)
        rows.append(export.Pair(names[i], names[j], np.eye(3), True, "accepted", "", 0.1, 0.0, none))
        poses[names[i], names[j]] = RelativePose(np.eye(3), R, t, 0, 0, 1.0)
    return export.Run(cameras, rows), poses


def test_a_triangle_is_scaled_by_its_directions(scene):
    run, poses = made_up(scene, [(0, 1), (0, 2), (1, 2)], noise=0.2)
    rotation, direction, distance = world_error(scene, export.place_cameras(run, poses), [0, 1, 2])
    assert rotation < DEGREES
    assert direction < DEGREES
    assert distance < 0.05


def test_a_chain_without_shared_points_has_no_scale(scene):
    run, poses = made_up(scene, [(0, 1), (1, 2)])
    with pytest.raises(epibar.EpibarError, match="ratios of their baselines"):
        export.place_cameras(run, poses)


def test_pairs_that_contradict_each_other(scene):
    run, poses = made_up(scene, [(0, 1), (0, 2), (1, 2)])
    turned = cv2.Rodrigues(np.array([0.0, 0.6, 0.0]))[0]
    key = ("cam1", "cam3")
    with pytest.raises(epibar.EpibarError, match="its rotation is"):
        export.place_cameras(run, {**poses, key: replace(poses[key], R=turned @ poses[key].R)})
    with pytest.raises(epibar.EpibarError, match="its direction is"):
        export.place_cameras(run, {**poses, key: replace(poses[key], t=-poses[key].t)})


def test_groups_without_a_pair_between_them():
    scene = synthetic.people(seed=1, cameras=4, walkers=1, frames=2)
    run, poses = made_up(scene, [(0, 1), (2, 3)])
    with pytest.raises(epibar.EpibarError, match="cam3, cam4: no chain"):
        export.place_cameras(run, poses)
