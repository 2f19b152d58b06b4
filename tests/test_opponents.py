"""The measuring program opponents.py: what COLMAP is given it gives back, and errors are right."""

import sys
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from epibar.synthetic import Camera, true_fundamental

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
if not BENCHMARKS.exists():
    pytest.skip("the measuring programs are not here", allow_module_level=True)
pycolmap = pytest.importorskip("pycolmap", reason="pycolmap, the extra 'colmap', is not installed")
sys.path.insert(0, str(BENCHMARKS))
from opponents_colmap import CORNER, in_pixels_from_the_corner, mapped, view_graph  # noqa: E402
from opponents_views import Matches, Views, errors_of, similar, straight, views_of  # noqa: E402

sys.path.remove(str(BENCHMARKS))

POINTS = 150
"""Of each pair."""


def cameras():
    """Five cameras on a ring, whose heights, aims and focal lengths differ."""
    random, found = np.random.default_rng(1), {}
    for k in range(5):
        angle = 2 * np.pi * k / 5 + 0.1 * k
        place = (5 * np.cos(angle), 5 * np.sin(angle), 2 + 0.5 * k)
        aim = random.normal((0, 0, 1), 0.4)
        found[f"cam{k}"] = Camera.look_at(place, aim, 560 + 20 * k, (640, 480), name=f"cam{k}")
    return found


def perfect(true, known):
    """Points of each pair, none of which another pair has."""
    random, pairs = np.random.default_rng(2), {}
    for one, other in combinations(true, 2):
        world = random.uniform([-2, -2, 0], [2, 2, 2], (POINTS, 3))
        a, b = (true[name].project(world)[0] for name in (one, other))
        pairs[one, other] = Matches(a, b, true_fundamental(true[one], true[other]))
    matrices = {name: camera.K for name, camera in true.items()} if known else None
    return Views({name: camera.size for name, camera in true.items()}, pairs, matrices, False)


def turned(camera, Q, scale, shift):
    """The same camera in another world, X' = scale Q X + shift."""
    centre = scale * Q @ camera.centre + shift
    R = camera.R @ Q.T
    return Camera(camera.K, R, -R @ centre, camera.size, camera.name)


def test_a_similarity_is_no_error():
    true = cameras()
    Q = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    Q *= np.linalg.det(Q)
    moved = {name: turned(camera, Q, 2.5, np.array([3.0, -1.0, 7.0])) for name, camera in true.items()}
    errors = errors_of(true, moved)
    assert errors.focal.max() == 0
    assert errors.rotation.max() < 1e-5
    assert errors.position.max() < 1e-12


def test_errors_are_those_that_were_made():
    true = cameras()
    wrong = dict(true)
    turn = np.radians(2.0)
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    K = true["cam1"].K * [[1.1, 1, 1], [1, 1.1, 1], [1, 1, 1]]
    wrong["cam1"] = Camera(K, R @ true["cam1"].R, R @ true["cam1"].t, true["cam1"].size)
    errors = errors_of(true, wrong)
    assert errors.focal == pytest.approx([0, 0.1, 0, 0, 0])
    assert sorted(errors.rotation.round(6)) == [0] * 6 + [2] * 4
    assert errors.position.max() < 1e-12
    there = np.random.default_rng(4).normal(size=(6, 3))
    mirrored = there * [1, 1, -1]
    assert np.linalg.norm(similar(mirrored, there) - there, axis=1).max() > 0.1, "no mirror is a similarity"


def test_pixels_from_the_corner():
    """A point that is on an epipolar line is on it after both have moved by half a pixel."""
    true = cameras()
    views = perfect(true, known=False)
    matches = views.pairs["cam0", "cam1"]
    F = in_pixels_from_the_corner(matches.F)
    a, b = (np.column_stack([pixels, np.ones(len(pixels))]) @ CORNER.T for pixels in (matches.a, matches.b))
    assert np.abs(np.einsum("ni,ij,nj->n", b, F, a)).max() < 1e-9
    assert a[:, :2] == pytest.approx(matches.a + 0.5)


def test_colmap_finds_the_focal_lengths():
    true = cameras()
    found = view_graph(perfect(true, known=False)).matrices
    for name, camera in true.items():
        assert found[name] == pytest.approx(camera.K, abs=1e-2)


@pytest.mark.parametrize("known", [False, True])
def test_colmap_places_cameras_by_tracks_of_two_views(known):
    true = cameras()
    found = mapped(perfect(true, known), "global")
    assert set(found) == set(true)
    errors = errors_of(true, found)
    assert errors.focal.max() < 1e-4
    assert errors.rotation.max() < 1e-3
    assert errors.position.max() < 1e-4
    for name in true if known else ():
        assert found[name].K[:2, 2] - 0.5 == pytest.approx(true[name].K[:2, 2]), "half a pixel"


def test_a_known_lens_is_taken_out():
    straight_camera = next(iter(cameras().values()))
    bent = Camera(
        *(straight_camera.K, straight_camera.R, straight_camera.t, straight_camera.size),
        distortions=(-0.25, 0.06, 0.0, 0.0, 0.0),
    )
    random = np.random.default_rng(5)
    pixels = random.uniform([40, 40], [600, 440], (200, 2))
    assert straight(bent, bent.distort(pixels)) == pytest.approx(pixels, abs=0.02)
    assert straight(straight_camera, pixels) is pixels


def test_points_are_taken_evenly_over_time():
    true = cameras()
    frame = np.random.default_rng(6).permutation(1000)
    points = SimpleNamespace(
        frame=frame, a=np.column_stack([frame, frame]).astype(float), b=np.zeros((1000, 2))
    )
    pairs = {
        ("cam0", "cam1"): SimpleNamespace(F=np.eye(3), frontier_points=points),
        ("cam0", "cam2"): SimpleNamespace(F=None, frontier_points=points),
    }
    views = views_of(true, pairs, "nothing", 11)
    assert list(views.pairs) == [("cam0", "cam1")]
    assert views.pairs["cam0", "cam1"].a[:, 0] == pytest.approx(np.linspace(0, 999, 11), abs=0.5)
