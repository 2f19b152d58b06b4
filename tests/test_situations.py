"""Situations drawn from a seed: what is said to be true is what is drawn."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from epibar import _core, synthetic
from epibar.errors import EpibarError
from epibar.synthetic import lens, lens_raster, raster
from epibar.synthetic.camera import Camera

LENSES = [
    (-0.2, 0.02, 0.001, -0.001, 0.0),
    lens.smooth_lens(-0.4, 1.0, 1.4),
    (0.05, 0.0, 0.0, 0.0, 0.0),
    (-0.3, 0.12, 0.0005, 0.0, 0.0),
]


def through(distortions, focal=540.0):
    """A camera with a lens, its principal point off the middle and its pixels not square."""
    camera = Camera.look_at((4.0, -3.0, 2.0), (0.0, 0.0, 0.0), focal, (640, 480), roll_deg=17.0)
    K = camera.K + np.array([[0, 0, 11.0], [0, 7.0, -8.0], [0, 0, 0]])
    return replace(camera, K=K, distortions=distortions)


def contour_of_ellipsoid(camera, centre, axes, count=2000):
    """World points of the contour that an ellipsoid shows to a camera: where rays touch it."""
    # As the unit sphere, from the place o: touching points p have p·o = 1.
    o = np.linalg.solve(axes, camera.centre - centre)
    middle, radius = o / (o @ o), np.sqrt(1 - 1 / (o @ o))
    basis = np.linalg.svd(o[None])[2][1:]
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    circle = middle + radius * (np.cos(angle)[:, None] * basis[0] + np.sin(angle)[:, None] * basis[1])
    return centre + circle @ axes.T


@pytest.mark.parametrize("distortions", LENSES)
def test_lens_is_opencvs(distortions):
    camera = through(distortions)
    rng = np.random.default_rng(0)
    pixels = rng.uniform(0, 1, (500, 2)) * camera.size
    straight = camera.undistort(pixels)
    np.testing.assert_allclose(camera.distort(straight), pixels, atol=1e-8)
    rays = np.column_stack([straight, np.ones(500)]) @ np.linalg.inv(camera.K).T
    seen = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), camera.K, np.array(distortions))[0][:, 0]
    np.testing.assert_allclose(seen, pixels, atol=1e-8)


@pytest.mark.parametrize("distortions", LENSES)
def test_outline_of_an_ellipsoid_through_a_lens(distortions):
    camera = through(distortions)
    rng = np.random.default_rng(1)
    checked = 0
    for _ in range(30):
        centre = rng.uniform(-1.6, 1.6, 3)
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.1, 0.5, 3)
        contour = contour_of_ellipsoid(camera, centre, axes)
        rotation, translation = cv2.Rodrigues(camera.R)[0], camera.t
        truth = cv2.projectPoints(contour, rotation, translation, camera.K, np.array(distortions))[0][:, 0]
        if not ((truth > 3) & (truth < np.array(camera.size) - 4)).all():
            continue
        spans = lens_raster.solid_spans(camera, centre[None], axes[None], np.array([False]))
        mask = np.zeros(camera.size[::-1], np.uint8)
        mask.reshape(-1)[spans.pixels(camera.size[0])[1]] = 1
        outline = truth.astype(np.float32)
        x, y = np.floor(truth).astype(int).T
        near = np.zeros_like(mask)
        for across, down in np.ndindex(2, 2):
            near[y + down, x + across] = 1
        filled = np.zeros_like(mask)
        cv2.fillPoly(filled, [np.round(truth * 256).astype(np.int32)], 1, shift=8)
        assert ((filled == mask) | (near == 1)).all()
        for row, column in np.argwhere(near):
            inside = cv2.pointPolygonTest(outline, (float(column), float(row)), True)
            assert abs(inside) < 0.1 or mask[row, column] == (inside > 0)
        checked += 1
    assert checked > 10


def test_a_lens_that_folds_is_refused():
    assert lens.fold_radius((-0.4, 0, 0, 0, 0)) == pytest.approx(1 / np.sqrt(1.2))
    assert lens.fold_radius((0.05, 0, 0, 0, 0)) == np.inf
    with pytest.raises(EpibarError, match="folds"):
        _ = through((-0.4, 0, 0, 0, 0), focal=500.0).lens_limit
    assert through((-0.4, 0, 0, 0, 0), focal=900.0).lens_limit > 0


def test_nothing_shows_twice_through_a_lens():
    camera = through((-0.3, 0.12, 0.0, 0.0, 0.0))
    fan = np.deg2rad(np.linspace(-80, 80, 400))
    points = camera.centre + 5 * (np.sin(fan)[:, None] * camera.R[0] + np.cos(fan)[:, None] * camera.R[2])
    seen = camera.distort(camera.project(points)[0])
    assert (np.diff(seen[:, 0]) > 0).all()


def test_boxes_through_a_lens_are_the_rays_that_meet_them():
    camera = through(LENSES[1])
    rng = np.random.default_rng(2)
    width, height = camera.size
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    straight = camera.undistort(np.stack([x, y], axis=-1).reshape(-1, 2))
    rays = np.column_stack([straight, np.ones(len(straight))]) @ np.linalg.inv(camera.K).T @ camera.R
    for _ in range(8):
        centre, turn = rng.uniform(-1, 1, 3), np.linalg.qr(rng.normal(size=(3, 3)))[0]
        axes = turn * rng.uniform(0.1, 0.6, 3)
        spans = lens_raster.solid_spans(camera, centre[None], axes[None], np.array([True]))
        mask = np.zeros(width * height, bool)
        mask[spans.pixels(width)[1]] = True
        o, d = np.linalg.solve(axes, camera.centre - centre), rays @ np.linalg.inv(axes).T
        near, far = np.minimum((-1 - o) / d, (1 - o) / d), np.maximum((-1 - o) / d, (1 - o) / d)
        meets = near.max(axis=1) <= far.min(axis=1)
        assert (mask != meets).sum() < 0.02 * np.sqrt(mask.sum() * 16) + 1


def test_without_a_lens_drawing_is_what_it_was():
    camera = through(())
    assert not camera.distorted
    rng = np.random.default_rng(3)
    axes = np.linalg.qr(rng.normal(size=(5, 3, 3)))[0] * 0.3
    args = camera, rng.uniform(-1, 1, (5, 3)), axes, np.array([True, False, True, False, False])
    one, other = lens_raster.solid_spans(*args), raster.solid_spans(*args)
    np.testing.assert_array_equal(one.left, other.left)


def small(family, seed=1, frames=120):
    """A situation with few frames."""
    made = synthetic.situation(seed, family)
    return made, min(frames, *(clock.frames for clock in made.clocks))


@pytest.mark.parametrize("family", synthetic.FAMILIES)
def test_every_family_draws_the_same_again(family):
    made, frames = small(family, frames=12)
    again = synthetic.situation(1, family)
    other = synthetic.situation(2, family)
    assert len(made.cameras) == len(made.clocks) == len(made.films) == len(made.groups)
    for index in (0, len(made.cameras) - 1):
        masks = made.masks(index, frames // 2, frames)
        assert masks.dtype == np.uint8
        assert masks.shape[1:] == made.cameras[index].size[::-1]
        assert set(np.unique(masks)) <= {0, 1}
        np.testing.assert_array_equal(masks, again.masks(index, 0, frames)[frames // 2 :])
    assert made.cameras[0].K.tolist() == again.cameras[0].K.tolist() != other.cameras[0].K.tolist()


@pytest.mark.parametrize("family", ["low", "high", "network", "network_off_centre", "network_plain"])
def test_true_geometry_and_clocks_fit_what_is_drawn(family):
    made = synthetic.situation(1, family)
    a, b = next(pair for pair in made.pairs() if made.answer(*pair).exists)
    recordings = [made.recording(index, lines=50, undistorted=True, frames=500)._core for index in (a, b)]
    F, offset = made.fundamental(a, b), made.time_offset(a, b)

    def matched(F, offset, radius=1.0):
        found = _core.examine(*recordings, np.ascontiguousarray(F), radius, offset, True, False, None)
        ends = found["tops"], found["bottoms"]
        return sum(end["excess"] for end in ends) / sum(end["tangents"] for end in ends)

    true = matched(F, offset)
    assert true > 0.3
    assert true > 3 * matched(F, offset + 1.7 * made.clocks[b].fps)
    off = F + 0.02 * np.abs(F).max() * np.array([[0, 1, 0], [0, 0, 0], [-1, 0, 0]])
    assert true > 3 * matched(off, offset)
