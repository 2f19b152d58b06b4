"""The measures, each against a simple number or a slow and obvious way to get the same one."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from epibar import evaluation, geometry, synthetic

RECTIFIED = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def scene():
    return synthetic.people(seed=2, cameras=3, walkers=4, frames=30, asymmetric=True)


def test_symmetric_epipolar_distance_of_one_point():
    F = np.array([[1e-6, 2e-6, -3e-3], [-1e-6, 3e-6, 2e-3], [1e-3, -4e-3, 1.0]])
    a, b = np.array([120.0, 45.0]), np.array([310.0, 222.0])
    line_b, line_a = F @ [*a, 1], F.T @ [*b, 1]
    d_b = abs(line_b @ [*b, 1]) / np.hypot(*line_b[:2])
    d_a = abs(line_a @ [*a, 1]) / np.hypot(*line_a[:2])
    assert geometry.symmetric_epipolar_distance(F, [a], [b])[0] == pytest.approx((d_a + d_b) / 2)
    assert geometry.symmetric_epipolar_distance(-7 * F, [a], [b])[0] == pytest.approx((d_a + d_b) / 2)
    assert geometry.symmetric_epipolar_distance(RECTIFIED, [[1, 7.5]], [[9, 5.0]])[0] == pytest.approx(2.5)


@pytest.mark.parametrize(
    ("F", "a", "b", "named"),
    [
        (np.eye(4), [[0, 0]], [[0, 0]], "F"),
        (np.full((3, 3), np.nan), [[0, 0]], [[0, 0]], "F"),
        (np.zeros((3, 3)), [[0, 0]], [[0, 0]], "F"),
        (RECTIFIED, [0, 0], [[0, 0]], "points_a"),
        (RECTIFIED, [[np.nan, 0]], [[0, 0]], "points_a"),
        (RECTIFIED, [[0, 0]], [[0, 0, 1]], "points_b"),
        (RECTIFIED, [[0, 0]], [[0, 0], [1, 1]], "points_b"),
    ],
)
def test_bad_input_is_named(F, a, b, named):
    with pytest.raises(ValueError, match=f"^{named}:"):
        geometry.symmetric_epipolar_distance(F, a, b)


def test_points_at_the_epipole_are_infinitely_far():
    F = np.array([[0.0, -1, 50], [1, 0, -30], [-50, 30, 0]])  # both epipoles at (30, 50)
    assert np.isinf(geometry.symmetric_epipolar_distance(F, [[30, 50]], [[1, 2]])[0])


def test_no_baseline_is_refused(scene):
    with pytest.raises(ValueError, match="baseline"):
        geometry.fundamental_from_cameras(scene.cameras[0], scene.cameras[0])


def test_fundamental_agrees_with_projection_matrices(scene):
    a, b = scene.cameras[:2]
    # Hartley & Zisserman, table 9.1: F = [e_b]ₓ P_b P_a⁺.
    x, y, z = b.P @ [*a.centre, 1]
    F = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ b.P @ np.linalg.pinv(a.P)
    F *= np.sign((F * scene.fundamental(0, 1)).sum()) / np.linalg.norm(F)
    np.testing.assert_allclose(scene.fundamental(0, 1), F, atol=1e-12)


def test_clip_lines():
    lines = [[0, 1, -10], [2, 0, -8], [1, 1, -3], [0, 1, 5], [1, -1, 500], [0, 0, 1]]
    segments, hit = geometry.clip_lines(lines, (101, 51))
    assert hit.tolist() == [True, True, True, False, False, False]
    assert {tuple(p) for p in segments[0]} == {(0.0, 10.0), (100.0, 10.0)}
    assert {tuple(p) for p in segments[1]} == {(4.0, 0.0), (4.0, 50.0)}
    np.testing.assert_allclose(np.sort(segments[2][:, 0]), [0, 3], atol=1e-12)


def test_area_between_lines_simple():
    size = (101, 51)
    assert geometry.area_between_lines([0, 1, -10], [0, -3, 36], size) == pytest.approx(200)
    assert geometry.area_between_lines([0, 1, -10], [0, 1, -10], size) == pytest.approx(0)
    # A nearly vertical and a vertical line: two triangles, whatever the signs.
    crossing = geometry.area_between_lines([1, 0, -50], [-1, 0.04, 49], size)
    assert crossing == pytest.approx(25 * 1 * 0.5 + 25 * 1 * 0.5)
    assert isinstance(crossing, float)
    # Lines along two opposite borders enclose most of the image, and so do lines over two opposite corners.
    assert geometry.area_between_lines([0, 1, -1], [0, 1, -49], size) == pytest.approx(4800)
    assert geometry.area_between_lines([1, 1, -10], [-1, -1, 140], size) == pytest.approx(5000 - 100)
    assert geometry.area_between_lines([0, 1, 9], [1, 0, 9], size) == 0
    with pytest.raises(ValueError, match="line2"):
        geometry.area_between_lines(np.ones((2, 3)), np.ones((3, 3)), size)


def test_area_between_lines_against_counting():
    rng = np.random.default_rng(0)
    size = (160, 90)
    step = 0.25
    x, y = np.meshgrid(np.arange(step / 2, 159, step), np.arange(step / 2, 89, step))
    angle, through = rng.uniform(0, np.pi, (2, 200)), rng.uniform(-20, 180, (2, 200, 2))
    lines = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=2)
    lines[..., 2] = -(lines[..., :2] * through).sum(axis=2)
    areas = geometry.area_between_lines(lines[0], lines[1], size)
    compared = Counter()
    hit = geometry.clip_lines(lines[0], size)[1] & geometry.clip_lines(lines[1], size)[1]
    for one, two, area, cuts in zip(*lines, areas, hit, strict=True):
        beyond_one, beyond_two = (line[0] * x + line[1] * y + line[2] > 0 for line in (one, two))
        parts = [(p & q).sum() for p in (~beyond_one, beyond_one) for q in (~beyond_two, beyond_two)]
        wedges = min(parts[0] + parts[3], parts[1] + parts[2])
        empty = [k for k in range(4) if parts[k] == 0]
        if len(empty) == 1:  # they do not cross inside; in the opposite part lies what is between them
            compared["apart"] += 1
            wedges = parts[3 - empty[0]]
        elif min(parts) < 60 and cuts:  # nearly so
            continue
        compared["all"] += 1
        assert area == pytest.approx(wedges * step**2, abs=8)
    assert compared["all"] > 150, compared
    assert compared["apart"] > 20, compared
    np.testing.assert_allclose(areas, geometry.area_between_lines(-2 * lines[1], lines[0], size), atol=1e-9)


def test_true_candidate_rate(scene):
    F = scene.fundamental(0, 1)
    size_a, size_b = scene.cameras[0].size, scene.cameras[1].size
    a, b = evaluation.image_correspondences(F, size_a, size_b, 1000)
    lines_b, lines_a = np.column_stack([a, np.ones(1000)]) @ F.T, np.column_stack([b, np.ones(1000)]) @ F
    assert evaluation.true_candidate_rate(lines_a, lines_b, F, size_a, size_b) == 1.0
    assert evaluation.true_candidate_rate(lines_a, lines_b, F.T, size_a, size_b) < 0.1
    rng = np.random.default_rng(1)
    spoiled = lines_b.copy()
    spoiled[:300] = np.cross(rng.uniform(0, 400, (300, 3)), rng.uniform(0, 400, (300, 3)))
    true = evaluation.true_candidates(lines_a, spoiled, F, size_a, size_b)
    assert true[300:].all()
    assert true[:300].mean() < 0.1
    assert np.isnan(evaluation.true_candidate_rate(np.empty((0, 3)), np.empty((0, 3)), F, size_a, size_b))


def test_true_candidate_threshold():
    # Epipolar lines are the rows. A line turned about the image's middle by a slope s sweeps two triangles
    # of (W - 1)² s / 8 each: below 3 W is below s = 12 W / (W - 1)².
    size = (641, 481)
    limit = 12 * 641 / 640**2
    for share, wanted in ((0.98, True), (1.02, False)):
        slope = share * limit
        line = [[slope, -1, 240 - slope * 320]]
        row = [[0, 1, -100.0]]
        assert evaluation.true_candidates(line, row, RECTIFIED, size, size).tolist() == [wanted]
        assert evaluation.true_candidates(row, line, RECTIFIED, size, size).tolist() == [wanted]


def test_image_correspondences(scene):
    F = scene.fundamental(0, 1)
    size_a, size_b = scene.cameras[0].size, scene.cameras[1].size
    a, b = evaluation.image_correspondences(F, size_a, size_b, 5000, seed=3)
    assert len(a) == len(b) == 5000
    assert geometry.symmetric_epipolar_distance(F, a, b).max() < 1e-8
    for points, size in ((a, size_a), (b, size_b)):
        assert points.min() > -1e-6
        assert (points <= np.array(size) - 1 + 1e-6).all()
    np.testing.assert_array_equal(a, evaluation.image_correspondences(F, size_a, size_b, 5000, seed=3)[0])
    apart = np.array([[0.0, 0, 0], [0, 0, -1], [0, 1, 5000]])  # row y meets row y + 5000
    with pytest.raises(ValueError, match="F_true"):
        evaluation.image_correspondences(apart, size_a, size_b, 100)


def test_volume_correspondences_are_inside_and_in_front(scene):
    a, b = scene.cameras[:2]
    behind = a.centre - 3 * a.R[2]
    outside = [0.0, 0.0, 500.0]
    points = np.vstack([scene.volume_points[:50], behind, outside])
    x_a, x_b = evaluation.volume_correspondences(a, b, points)
    wanted = (scene.visible(0) & scene.visible(1))[:50]
    np.testing.assert_allclose(x_a, a.project(points[:50][wanted])[0])
    np.testing.assert_allclose(x_b, b.project(points[:50][wanted])[0])


def test_triangulate_and_moving_volume(scene):
    a, b = scene.cameras[:2]
    points = scene.volume_points[:200]
    found = geometry.triangulate(a.P, b.P, a.project(points)[0], b.project(points)[0])
    np.testing.assert_allclose(found, points, atol=1e-8)
    grid = np.linspace(0, 100, 1001)[:, None] * [1, 2, 3]
    volume = evaluation.moving_volume(grid, n=4000, seed=1)
    assert volume.shape == (4000, 3)
    np.testing.assert_allclose(volume.min(axis=0), [3, 6, 9], rtol=0.05)
    np.testing.assert_allclose(volume.max(axis=0), [97, 194, 291], rtol=0.01)


def hulls(masks):
    for mask in masks:
        contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        yield [cv2.convexHull(contour)[:, 0].astype(float) for contour in contours]


def test_matched_tangents_take_the_same_side():
    def shifted(x, y):
        return np.array([[x, y], [x + 10, y], [x + 10, y + 10], [x, y + 10]], dtype=float)

    # Rows are epipolar lines: the tops and bottoms of two squares of one height meet, 2 × 2 points.
    a, b, frames = evaluation.matched_tangent_points(
        [[], [shifted(50, 20)]], [[shifted(0, 0)], [shifted(90, 20.5)]], RECTIFIED, radius=1.0
    )
    assert frames.tolist() == [1, 1]
    assert sorted(a[:, 1]) == [20, 30]
    np.testing.assert_allclose(np.sort(b[:, 1]), [20.5, 30.5])
    # A bottom on the row of a top is not a match.
    one_over = evaluation.matched_tangent_points(
        [[shifted(50, 20)]], [[shifted(50, 30)]], RECTIFIED, radius=1.0
    )
    assert len(one_over[0]) == 0
    # Two candidates for one tangent: neither is used.
    twice = [[shifted(50, 20), shifted(70, 20)]]
    assert len(evaluation.matched_tangent_points([[shifted(50, 20)]], twice, RECTIFIED)[0]) == 0
    # A tangent at the border is the border's.
    inner = shifted(50, 0)
    border = evaluation.matched_tangent_points([[inner]], [[inner]], RECTIFIED, 1.0, (200, 100), (200, 100))
    assert border[0][:, 1].tolist() == [10]


@pytest.mark.parametrize("facing", [False, True])
def test_matched_tangents_triangulate_the_motion(facing):
    scene = synthetic.people(seed=5, cameras=2, walkers=3, frames=40, facing=facing, asymmetric=True)
    F = scene.fundamental(0, 1)
    a, b = scene.cameras
    x_a, x_b, frames = evaluation.matched_tangent_points(
        list(hulls(scene.masks(0))), list(hulls(scene.masks(1))), F, 3.0, a.size, b.size
    )
    assert len(x_a) > (20 if facing else 80)
    assert geometry.symmetric_epipolar_distance(F, x_a, x_b).max() <= 3.0
    assert frames.max() < 40
    points = geometry.triangulate(a.P, b.P, x_a, x_b)
    near = ((points > [-6, -6, -0.3]) & (points < [6, 6, 2.2])).all(axis=1)
    assert near.mean() > 0.8


def test_tangents_from_near_and_within():
    # Both epipoles at (30, 50), each epipolar line maps to itself.
    F = np.array([[0.0, -1, 50], [1, 0, -30], [-50, 30, 0]])
    triangle = np.array([[31.0, 30], [31, 90], [40, 60]])
    a, b, _ = evaluation.matched_tangent_points([[triangle]], [[triangle]], F)
    assert sorted(a[:, 1]) == [30, 90]
    np.testing.assert_array_equal(a, b)
    around = triangle - [5, 0]
    assert len(evaluation.matched_tangent_points([[around]], [[around]], F)[0]) == 0


def test_compare_and_good_pair(scene):
    F = scene.fundamental(0, 1)
    size_a, size_b = scene.cameras[0].size, scene.cameras[1].size
    volume = scene.volume_correspondences(0, 1)
    figures = evaluation.compare(3 * F, F, size_a, size_b, volume, n=1000)
    assert figures.image_error < 1e-8
    assert figures.volume_error < 1e-8
    assert figures.volume_points == len(volume[0])
    assert figures.good
    wrong = evaluation.compare(F.T, F, size_a, size_b, n=1000)
    assert wrong.image_error > 20
    assert np.isnan(wrong.volume_error)
    assert not wrong.good
    assert evaluation.good_pair(2.9)
    assert not evaluation.good_pair(3.0)
    assert not evaluation.good_pair(float("nan"))


def test_any_object_with_a_pose_is_a_camera(scene):
    plain = [SimpleNamespace(K=c.K, R=c.R, t=c.t, size=c.size) for c in scene.cameras[:2]]
    np.testing.assert_array_equal(geometry.fundamental_from_cameras(*plain), scene.fundamental(0, 1))
