"""Situations drawn from a seed: what is said to be true is what is drawn."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from epibar import _core, synthetic
from epibar.errors import EpibarError
from epibar.synthetic import Clock, lens, lens_raster, raster, tracks
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


@pytest.mark.parametrize("family", synthetic.FAMILIES)
def test_every_family_draws_the_same_again(family):
    frames, made, again = 12, synthetic.situation(1, family), synthetic.situation(1, family)
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
    recordings = [made.recording(index, lines=50, undistorted=True, frames=300)._core for index in (a, b)]
    F, offset = made.fundamental(a, b), made.time_offset(a, b)

    def matched(F, offset, radius=1.0):
        found = _core.examine(*recordings, np.ascontiguousarray(F), radius, offset, True, False, None)
        ends = found["tops"], found["bottoms"]
        return sum(end["excess"] for end in ends) / sum(end["tangents"] for end in ends)

    true = matched(F, offset)
    assert true > 0.2
    assert true > 3 * matched(F, offset + 1.7 * made.clocks[b].fps)
    off = F + 0.02 * np.abs(F).max() * np.array([[0, 1, 0], [0, 0, 0], [-1, 0, 0]])
    assert true > 3 * matched(off, offset)


def test_clocks():
    made = replace(
        synthetic.situation(1, "network_plain"),
        clocks=[Clock(3.0, 25.0, 10), Clock(1.0, 30.0, 10, drift=100.0), Clock(5.5, 25.0, 10, drift=-50.0)],
    )
    for a, b in ((0, 1), (1, 2), (2, 0)):
        offset, drift = made.clock_between(a, b)
        one, other = made.clocks[a], made.clocks[b]
        # What is at frame 7 of a: at which second of the world, and so at which second of b's recording?
        seconds, world = 7 / one.fps, one.moments[7]
        assert (world - other.start) * other.rate == pytest.approx(offset + seconds * (1 + 1e-6 * drift))
        assert made.time_offset(a, b) == pytest.approx(offset * other.fps)
    assert made.clock_between(0, 1)[0] == pytest.approx(2.0 * 1.0001)


def test_hand_started_clocks():
    made = synthetic.situation(2, "network")
    starts = [clock.start for clock in made.clocks]
    assert 1 < max(starts) - min(starts) <= 20
    assert made.clocks[0].drift == 0
    assert {clock.fps for clock in made.clocks} <= {25.0, 30.0}
    assert not made.synchronised
    assert synthetic.situation(2, "low").synchronised


def test_a_frame_shows_the_moment_of_its_clock():
    made = synthetic.situation(2, "network_plain")
    film = made.films[0]
    later = replace(film, moments=film.moments[10:11])
    np.testing.assert_array_equal(next(later.iter_masks()), made.masks(0, 10, 11)[0])


@pytest.mark.parametrize("seed", range(12))
def test_lenses_of_networks(seed):
    made = synthetic.situation(seed, "network_off_centre")
    for camera in made.cameras:
        assert -0.4 <= camera.distortions[0] <= 0.05
        assert np.abs(camera.K[:2, 2] - (np.array(camera.size) - 1) / 2).max() <= 0.02 * camera.size[0]
        assert synthetic.field_of_view(camera) <= 120
        assert lens.fold_radius(camera.distortions) > camera.lens_limit
        pixels = np.random.default_rng(seed).uniform(0, 1, (200, 2)) * camera.size
        np.testing.assert_allclose(camera.distort(camera.undistort(pixels)), pixels, atol=1e-6)


def test_wide_lenses_are_drawn():
    views = [
        synthetic.field_of_view(camera)
        for seed in range(10)
        for camera in synthetic.situation(seed, "network").cameras
    ]
    assert max(views) > 100
    assert min(views) < 55


def test_what_is_planted_is_what_is_said():
    made = synthetic.situation(3, "network_stranger")
    (fault,) = made.faults
    (index,) = fault.cameras
    for a, b in made.pairs():
        assert (made.answer(a, b).reason == "another scene") == (index in (a, b))
    plain = synthetic.situation(3, "network_knocked")
    (index,) = plain.faults[0].cameras
    film = plain.films[index]
    still = replace(film, knocked=None)
    half = film.knocked_at
    assert (next(film.iter_masks(half - 1)) == next(still.iter_masks(half - 1))).all()
    assert (next(film.iter_masks(half)) != next(still.iter_masks(half))).any()
    back = synthetic.situation(3, "reversed")
    assert (np.diff(back.films[1].moments) < 0).all()
    assert (np.diff(back.films[0].moments) > 0).all()


def test_a_false_pair_agrees_on_a_geometry_of_its_own():
    made = synthetic.situation(1, "network_false_pair")
    a, b = made.faults[0].cameras
    assert [index for index, film in enumerate(made.films) if film.also is not None] == [a, b]
    F_false = synthetic.true_fundamental(made.films[a].also.camera, made.films[b].also.camera)
    assert made.error(F_false, a, b) > 10
    recordings = [made.recording(index, lines=50, undistorted=True, frames=300)._core for index in (a, b)]
    offset, excess = made.time_offset(a, b), []
    for F in (made.fundamental(a, b), F_false, made.fundamental(a, b)[::-1].copy()):
        found = _core.examine(*recordings, np.ascontiguousarray(F), 1.0, offset, True, False, None)
        excess.append(found["tops"]["excess"] + found["bottoms"]["excess"])
    assert min(excess[:2]) > 3 * max(excess[2], 10.0)


def test_networks_that_no_motion_determines():
    made = synthetic.situation(2, "network_no_baseline")
    places = np.array([camera.centre for camera in made.cameras])
    assert np.linalg.norm(places - places[0], axis=1).max() < 0.011
    assert len({tuple(np.round(camera.R[2], 3)) for camera in made.cameras}) == len(made.cameras)
    assert [film.camera for film in made.films] == made.cameras
    for family in ("network_no_baseline", "network_one_plane", "network_unrelated"):
        situation = synthetic.situation(2, family)
        assert not any(situation.answer(a, b).exists for a, b in situation.pairs())
    assert len(set(synthetic.situation(2, "network_unrelated").groups)) > 2
    off = synthetic.situation(3, "network_one_plane").volume_points
    off = np.linalg.svd(off - off.mean(axis=0), compute_uv=False) / np.sqrt(len(off))
    assert off[2] < 0.03 < 0.3 < off[1]


def test_mirrored():
    made = synthetic.situation(4, "mirrored")
    plain = replace(made.films[1], mirrored=False)
    np.testing.assert_array_equal(made.masks(1, 0, 3), [m[:, ::-1] for m in plain.iter_masks(0, 3)])
    for points in (None, made.room_points):
        assert made.error(made.fundamental(0, 1), 0, 1, points) < 1e-6
    assert not made.answer(0, 1).exists
    assert made.has_fundamental(0, 1)
    assert not synthetic.situation(4, "unrelated").has_fundamental(0, 1)
    assert not synthetic.situation(4, "reversed").has_fundamental(0, 1)


def test_rooms_with_one_timetable():
    made = synthetic.situation(5, "same_timetable")
    first, second = (film.world.movers[0].track for film in made.films)
    assert (first.present[: len(second.present)] == second.present).mean() > 0.99
    there = first.present[:-2] & second.present[: len(first.present) - 2]
    assert there.any()
    assert (first.position[:-2][there] != second.position[: len(first.present) - 2][there]).any()


def test_walkers_keep_a_foot_on_the_floor_and_it_stays():
    rng = np.random.default_rng(0)
    walkers = synthetic.Walkers(rng, tracks.free(rng, 5, 20.0, (10.0, 10.0), pauses=0.0))
    pose = walkers.at(np.arange(4.0, 18.0, 0.02))
    low = pose.centres[..., 2] - np.linalg.norm(pose.axes[..., 2, :], axis=2)
    assert np.abs(low.min(axis=1)).max() < 0.05
    height = (pose.centres[..., 2] + np.linalg.norm(pose.axes[..., 2, :], axis=2)).max(axis=0)
    assert 1.3 < height.max() < 2.2
    # Parts 5 and 10 are the feet, five to a walker: one of them moves much slower than the body does.
    speed = np.linalg.norm(np.diff(pose.centres[..., :2], axis=0), axis=2) / 0.02
    feet = np.stack([speed[:, 25:30], speed[:, 50:55]])
    assert np.median(feet.min(axis=0)) < 0.2 * np.median(speed[:, 5:10])


def test_what_is_undetermined_is_so_by_the_information_in_the_motion():
    for family, least in (("one_plane", 50.0), ("pure_floor", 3.0), ("one_mover_standing", 1.0)):
        made = synthetic.situation(1, family)
        assert synthetic.error_bound(made, 0, 1, made.room_points) > least
    made = synthetic.situation(1, "low")
    assert synthetic.error_bound(made, 0, 1) < 0.2
    assert synthetic.error_bound(made, 0, 1) == pytest.approx(synthetic.error_bound(made, 1, 0), rel=0.01)


def test_the_bound_is_reached_by_least_squares():
    made = synthetic.situation(1, "low")
    points, weight = synthetic.information.frontier_points(made, 0, 1)
    assert weight == 1.0
    rng, errors = np.random.default_rng(0), []
    truth = made.fundamental(0, 1)
    steps = synthetic.information._directions(truth, made.cameras[0].size, made.cameras[1].size)
    exact = made.correspondences(0, 1, points)
    for _ in range(30):
        one, other = (np.column_stack([p + rng.normal(0, 0.5, p.shape), np.ones(len(p))]) for p in exact)
        F = truth
        for _ in range(2):
            lengths = np.hypot(
                np.linalg.norm((one @ F.T)[:, :2], axis=1), np.linalg.norm((other @ F)[:, :2], axis=1)
            )
            slope = np.einsum("ni,kij,nj->nk", other, steps, one) / lengths[:, None]
            off = np.einsum("ni,ij,nj->n", other, F, one) / lengths
            F = F - np.einsum("k,kij->ij", np.linalg.lstsq(slope, off, rcond=None)[0], steps)
        errors.append(made.error(F, 0, 1))
    assert np.mean(errors) == pytest.approx(synthetic.error_bound(made, 0, 1), rel=0.25)


def test_boxes_stand_around_their_movers():
    made = synthetic.situation(1, "boxes")
    film = replace(made.films[0], jitter=0.0)
    boxes, bodies = (next(f.iter_masks(50)) for f in (film, replace(film, outlines="silhouettes")))
    assert (boxes >= bodies).all()
    assert boxes.sum() > 1.2 * bodies.sum()
    ellipses = next(replace(film, outlines="ellipses").iter_masks(50))
    assert ellipses.sum() / boxes.sum() == pytest.approx(np.pi / 4, abs=0.12)


def test_shadows_lie_on_the_floor():
    made = synthetic.situation(1, "shadows")
    film = made.films[0]
    shapes = film.world.shapes(film.moments[40:41], 0)
    shadow = shapes.owner < 0
    assert shadow.sum() == (~shadow).sum()
    assert np.abs(shapes.centres[shadow, 2]).max() < 1e-9
    assert np.abs(shapes.axes[shadow][:, 2]).max() < 1e-9


def test_recordings_know_what_they_are_told():
    made = synthetic.situation(1, "network")
    raw = made.recording(0, lines=20, frames=5)
    straight = made.recording(0, lines=20, frames=5, undistorted=True)
    assert raw.matrix is None
    np.testing.assert_array_equal(straight.matrix, made.cameras[0].K)
    assert raw.name == straight.name == "cam01"
    assert raw.times[1] == pytest.approx(1 / made.clocks[0].fps)
    assert (raw.heat != straight.heat).any()


@pytest.mark.parametrize("seed", [1, 4])
def test_undistorting_what_the_lens_filmed_gives_what_is_drawn_without_it(seed):
    made = synthetic.situation(seed, "network_off_centre")
    film = replace(made.films[0], dirt=None, cleaned=False)
    camera = film.camera
    frames = [len(film.moments) // 3, len(film.moments) // 2]
    raw, straight = ([next(f.iter_masks(k)) for k in frames] for f in (film, film.without_lens()))
    for one, other in zip(raw, straight, strict=True):
        taken = cv2.undistort(one * np.uint8(255), camera.K, np.array(camera.distortions)) >= 128
        # The straight image shows more or less than the bent one: only where both look.
        both = cv2.undistort(np.full_like(one, 255), camera.K, np.array(camera.distortions)) == 255
        edge = cv2.dilate(other, np.ones((3, 3), np.uint8)) != cv2.erode(other, np.ones((3, 3), np.uint8))
        assert other.any()
        assert (taken[both & ~edge] != (other[both & ~edge] > 0)).sum() <= 2
        assert abs(taken[both].sum() - other[both].sum()) < 0.1 * edge[both].sum() + 3


def test_an_unknown_family_is_told():
    with pytest.raises(ValueError, match="low_wide"):
        synthetic.situation(1, "nothing")
