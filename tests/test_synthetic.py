"""The synthetic scenes are the yardstick of everything else: geometry, unbiased drawing, and seeds."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from epibar import synthetic
from epibar.errors import EpibarError
from epibar.geometry.cameras import inside
from epibar.geometry.epipolar import epipoles, symmetric_epipolar_distance
from epibar.synthetic import raster
from epibar.synthetic.camera import Camera


def random_boxes(rng, count):
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    turned = synthetic.motion.rotations(axis, rng.uniform(0, np.pi, count))
    return rng.uniform(-1, 1, (count, 3)), turned * rng.uniform(0.1, 0.5, (count, 1, 3))


@pytest.fixture
def camera():
    return Camera.look_at((4.0, -3.0, 2.0), (0.0, 0.0, 0.0), 300.0, (321, 200), roll_deg=17.0)


def test_a_camera_has_one_lens(camera):
    bent = replace(camera, distortions=(-0.2, 0.0, 0.0, 0.0, 0.0), name="cam1")
    with pytest.raises(EpibarError, match=r"cam1: distortions and fisheye are given, but .* one lens"):
        replace(bent, fisheye=0.02)
    assert replace(bent, distortions=(), fisheye=0.02).fisheye == 0.02


def test_look_at_is_upright_and_rolls_clockwise():
    upright = Camera.look_at((0, -5, 0), (0, 0, 0), 500.0, (640, 480))
    pixels, depth = upright.project([[0, 0, 0], [1, 0, 0], [0, 0, 1], [0, -9, 0]])
    np.testing.assert_allclose(pixels[:3], [[319.5, 239.5], [419.5, 239.5], [319.5, 139.5]], atol=1e-9)
    assert depth[0] == pytest.approx(5.0)
    assert depth[3] < 0
    assert np.isnan(pixels[3]).all()
    np.testing.assert_allclose(upright.centre, [0, -5, 0], atol=1e-12)
    rolled = Camera.look_at((0, -5, 0), (0, 0, 0), 500.0, (640, 480), roll_deg=90.0)
    np.testing.assert_allclose(rolled.project([[0, 0, 1]])[0], [[419.5, 239.5]], atol=1e-9)
    homogeneous = rolled.P @ [0.3, 0.2, -0.4, 1.0]
    np.testing.assert_allclose(rolled.project([[0.3, 0.2, -0.4]])[0][0], homogeneous[:2] / homogeneous[2])


@pytest.mark.parametrize("make", [synthetic.people, synthetic.cubes])
def test_fundamental_matrix_convention(make):
    scene = make(seed=3, frames=5, asymmetric=True)
    assert len({camera.size for camera in scene.cameras}) > 2
    F = scene.fundamental(0, 1)
    assert np.linalg.norm(F) == pytest.approx(1.0)
    assert np.linalg.svd(F)[1][2] < 1e-12
    a, b = scene.volume_correspondences(0, 1)
    assert len(a) > 500
    assert symmetric_epipolar_distance(F, a, b).max() < 1e-8
    assert symmetric_epipolar_distance(F.T, a, b).mean() > 20
    assert symmetric_epipolar_distance(F, b, a).mean() > 20
    assert symmetric_epipolar_distance(F, a[:, ::-1], b[:, ::-1]).mean() > 20
    np.testing.assert_allclose(np.abs(scene.fundamental(1, 0)), np.abs(F.T), atol=1e-12)


def test_ellipsoid_is_set_where_the_ray_meets_it(camera):
    rng = np.random.default_rng(0)
    centres, axes = random_boxes(rng, 12)
    width, height = camera.size
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(camera.K).T @ camera.R
    for centre, axis in zip(centres, axes, strict=True):
        spans = raster.solid_spans(camera, centre[None], axis[None], np.array([False]))
        mask = np.zeros((height, width), bool)
        mask.reshape(-1)[spans.pixels(width)[1]] = True
        # In its own frame it is the unit sphere: the ray o + s d meets it if the discriminant is ≥ 0.
        o, d = np.linalg.solve(axis, camera.centre - centre), rays @ np.linalg.inv(axis).T
        meets = (d @ o) ** 2 >= (d**2).sum(-1) * (o @ o - 1)
        assert mask.sum() > 50
        np.testing.assert_array_equal(mask, meets)


def test_box_is_set_where_the_pixel_centre_is_in_its_hull(camera):
    rng = np.random.default_rng(1)
    centres, axes = random_boxes(rng, 12)
    width, height = camera.size
    for centre, axis in zip(centres, axes, strict=True):
        spans = raster.solid_spans(camera, centre[None], axis[None], np.array([True]))
        mask = np.zeros((height, width), bool)
        mask.reshape(-1)[spans.pixels(width)[1]] = True
        hull = cv2.convexHull(camera.project(centre + raster.BOX_CORNERS @ axis.T)[0].astype(np.float32))[
            :, 0
        ]
        y, x = np.indices((height, width))
        edge = np.roll(hull, -1, axis=0) - hull
        sign = edge[:, 0, None, None] * (y - hull[:, 1, None, None])
        sign = sign - edge[:, 1, None, None] * (x - hull[:, 0, None, None])
        wanted = (sign >= 0).all(axis=0) | (sign <= 0).all(axis=0)
        # float32 corners of the oracle may decide a pixel on the outline the other way.
        assert (mask != wanted).sum() <= 1
        assert mask.sum() > 50


@pytest.mark.parametrize("box", [False, True])
def test_drawing_is_unbiased(camera, box):
    rng = np.random.default_rng(2)
    centres, axes = random_boxes(rng, 1500)
    centres *= 0.4
    axes *= 0.6
    # The truth is the same outlines drawn sixteen times finer, with pixel centres where they belong.
    fine = Camera(
        np.array([[16, 0, 7.5], [0, 16, 7.5], [0, 0, 1]]) @ camera.K, camera.R, camera.t, (321 * 16, 200 * 16)
    )

    def measure(camera):
        spans = raster.solid_spans(camera, centres, axes, np.full(len(centres), box))
        count = spans.right - spans.left + 1
        area = np.bincount(spans.item, count, len(centres))
        x = np.bincount(spans.item, count * (spans.left + spans.right) / 2, len(centres)) / area
        y = np.bincount(spans.item, count * spans.row, len(centres)) / area
        top = np.full(len(centres), np.inf)
        np.minimum.at(top, spans.item, spans.row)
        left = np.full(len(centres), np.inf)
        np.minimum.at(left, spans.item, spans.left)
        return area, x, y, top, left

    area, x, y, top, left = measure(camera)
    fine_area, fine_x, fine_y, fine_top, fine_left = measure(fine)
    assert np.mean(area - fine_area / 256) == pytest.approx(0, abs=0.6)  # of some 1,000 pixels
    assert np.mean(x - (fine_x - 7.5) / 16) == pytest.approx(0, abs=5e-3)
    assert np.mean(y - (fine_y - 7.5) / 16) == pytest.approx(0, abs=5e-3)
    # The outermost centre lies inside the outline, by half a pixel or a little more: never outside.
    for outermost, true in ((top, (fine_top - 8) / 16), (left, (fine_left - 8) / 16)):
        assert (outermost - true).min() > -0.1
        assert 0.4 < np.mean(outermost - true) < 1.2


def test_solids_behind_or_around_the_camera_are_not_drawn(camera):
    forward = camera.R[2]
    centres = camera.centre + np.array([-2.0, 0.0, 0.3, 3.0])[:, None] * forward
    axes = np.tile(0.5 * np.eye(3), (4, 1, 1))
    for box in (False, True):
        spans = raster.solid_spans(camera, centres, axes, np.full(4, box))
        assert set(spans.item) == {3}


@pytest.mark.parametrize("make", [synthetic.people, synthetic.cubes, synthetic.thin_cubes])
def test_same_seed_same_masks(make):
    options = {"frames": 40, "size": (160, 120), "dirty": True, "one_camera_only": 2, "occluders": 2}
    first, again, other = make(7, **options), make(7, **options), make(8, **options)
    masks = first.masks(1)
    assert masks.dtype == np.uint8
    assert masks.shape == (40, 120, 160)
    assert set(np.unique(masks)) == {0, 1}
    np.testing.assert_array_equal(masks, again.masks(1))
    assert (masks != other.masks(1)).any()
    np.testing.assert_array_equal(masks[21:37], first.masks(1, 21, 37))
    np.testing.assert_array_equal(masks, np.stack(list(first.iter_masks(1))))


def test_motion_seed_changes_motion_and_not_cameras():
    scene, other = (synthetic.people(7, frames=3, motion_seed=seed) for seed in (None, 99))
    np.testing.assert_array_equal(scene.cameras[2].P, other.cameras[2].P)
    assert (scene.masks(2) != other.masks(2)).any()


@pytest.mark.parametrize("make", [synthetic.people, synthetic.cubes])
def test_motion_fills_the_images(make):
    scene = make(seed=5, frames=200, size=(320, 240))
    for index in range(len(scene.cameras)):
        assert scene.visible(index).mean() > 0.7
        assert 0.01 < scene.masks(index).mean() < 0.3


def test_volume_points_lie_under_the_masks():
    scene = synthetic.people(seed=2, frames=1, walkers=3)
    pixels = np.round(scene.cameras[0].project(scene.volume_points)[0]).astype(int)
    keep = scene.visible(0)
    assert scene.masks(0)[0][pixels[keep, 1], pixels[keep, 0]].mean() > 0.93


def test_an_empty_room_stays_empty():
    scene = synthetic.people(seed=1, walkers=0, frames=3, size=(64, 48), occluders=1)
    assert not scene.masks(0).any()
    assert scene.volume_points.shape == (0, 3)
    assert len(list(synthetic.render_frames(scene, 1, empty_frames=2))) == 5


def test_walkers_walk():
    scene = synthetic.people(seed=4, walkers=10)
    trunk = scene.solids.centres[:, 10:20]
    speed = np.linalg.norm(np.diff(trunk[..., :2], axis=0), axis=2) * scene.fps
    assert speed.max() < 1.7
    assert 0.6 < np.median(speed) < 1.6
    assert np.abs(scene.solids.centres[..., :2]).max() < 6.5
    low = scene.solids.centres[..., 2] - np.linalg.norm(scene.solids.axes[..., 2, :], axis=2)
    high = scene.solids.centres[..., 2] + np.linalg.norm(scene.solids.axes[..., 2, :], axis=2)
    assert low.min() > -0.05
    assert high.max(axis=1).min() > 1.5
    assert high.max() < 2.0
    assert (np.linalg.norm(np.diff(scene.solids.centres, axis=0), axis=2) * scene.fps).max() < 6.0


def test_one_path_is_one_plane():
    scene = synthetic.people(seed=4, frames=50, one_path=True)
    trunk = scene.solids.centres[:, 8:16].reshape(-1, 3)
    assert np.linalg.svd(trunk[:, :2] - trunk[:, :2].mean(axis=0))[1][1] < 1e-9


@pytest.mark.parametrize("asymmetric", [False, True])
def test_facing_cameras_have_their_epipoles_inside(asymmetric):
    for seed in range(3):
        scene = synthetic.people(
            seed, frames=2, camera_height=synthetic.LOW_CAMERAS, facing=True, asymmetric=asymmetric
        )
        for epipole, camera in zip(epipoles(scene.fundamental(0, 1)), scene.cameras, strict=False):
            assert inside((epipole[:2] / epipole[2])[None], camera.size)[0]


def test_one_camera_only_and_occluders():
    plain = synthetic.people(seed=6, frames=60, cameras=3)
    extra = synthetic.people(seed=6, frames=60, cameras=3, one_camera_only=1)
    hidden = synthetic.people(seed=6, frames=60, cameras=3, occluders=1)
    for index in range(3):
        masks = plain.masks(index)
        assert (extra.masks(index) >= masks).all()
        assert (hidden.masks(index) <= masks).all()
        assert (extra.masks(index) != masks).any() == (index == 0)
        assert (hidden.masks(index) != masks).any() == (index == 0)


def test_noisy_does_each_thing():
    masks = np.zeros((60, 120, 160), np.uint8)
    masks[:, 40:80, 50:90] = 1
    off = {"false_blobs": 0.0, "ragged": 0.0, "holes": 0.0, "missed": 0.0}
    np.testing.assert_array_equal(synthetic.noisy(masks * 255, 1, synthetic.Dirt(**off)), masks)
    missed = synthetic.noisy(masks, 1, synthetic.Dirt(**{**off, "missed": 0.5}))
    assert 15 < (missed.sum(axis=(1, 2)) == 0).sum() < 45
    assert (synthetic.noisy(masks, 1, synthetic.Dirt(**{**off, "holes": 3.0})) <= masks).all()
    assert (synthetic.noisy(masks, 1, synthetic.Dirt(**{**off, "false_blobs": 3.0})) >= masks).all()
    ragged = synthetic.noisy(masks, 1, synthetic.Dirt(**{**off, "ragged": 0.5}))
    assert (ragged != masks).any()
    assert (ragged[:, 44:76, 54:86] == 1).all()
    assert ragged.sum() / masks.sum() == pytest.approx(1.0, abs=0.03)
    with pytest.raises(ValueError, match="masks"):
        synthetic.noisy(masks[0])


def test_video_shows_what_the_masks_say(tmp_path):
    scene = synthetic.people(seed=1, frames=12, size=(320, 240), walkers=4, occluders=1)
    path = synthetic.render_video(scene, 0, tmp_path / "camera.mp4", empty_frames=5)
    video = cv2.VideoCapture(str(path))
    frames = [video.read()[1] for _ in range(17)]
    assert not video.read()[0]
    assert frames[0].shape == (240, 320, 3)
    difference = np.abs(frames[16].astype(float) - frames[2]).max(axis=2)
    mask = scene.masks(0)[11] > 0
    assert np.median(difference[mask]) > 30
    assert np.median(difference[~mask]) < 10
    again = list(synthetic.render_frames(scene, 0, empty_frames=1))
    for one, two in zip(again, synthetic.render_frames(scene, 0, empty_frames=1), strict=True):
        np.testing.assert_array_equal(one, two)
    with pytest.raises(OSError, match="nowhere"):
        synthetic.render_video(scene, 0, tmp_path / "nowhere" / "camera.mp4")
