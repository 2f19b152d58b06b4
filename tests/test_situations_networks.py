"""Errors of a calibrated network against the truth of a situation."""

from dataclasses import replace

import numpy as np
import pytest

from epibar import synthetic
from epibar.synthetic import motion


@pytest.fixture(scope="module")
def situation():
    return synthetic.situation(1, "network_off_centre")


def in_another_world(camera, scale=0.3):
    """The same camera in a world that is turned, moved and smaller: X' = scale (Q X + d)."""
    turn = motion.rotations(np.array([0.6, 0.0, 0.8]), np.array(1.1))
    place = scale * (turn @ camera.centre + [4.0, -2.0, 1.0])
    rotation = camera.R @ turn.T
    return replace(camera, R=rotation, t=-rotation @ place)


def turned(camera, degrees):
    turn = motion.rotations(np.array([0.0, 1.0, 0.0]), np.array(np.deg2rad(degrees)))
    return replace(camera, R=turn @ camera.R, t=turn @ camera.t)


def test_a_similarity_is_no_error(situation):
    assert len(situation.cameras) > 3
    found = {camera.name: in_another_world(camera) for camera in situation.cameras}
    for error in synthetic.network_errors(situation, found).values():
        assert error.rotation < 1e-5
        assert error.position < 1e-9
        assert abs(error.focal) < 1e-12
    for a, b in situation.pairs():
        assert synthetic.pair_error(situation, found, a, b) < 1e-5


def test_what_is_wrong_is_told_of_that_camera_alone(situation):
    found = {camera.name: in_another_world(camera) for camera in situation.cameras}
    names = list(found)
    bad = found[names[1]]
    bad = turned(bad, 2.0)
    moved = bad.centre + 0.3 * np.array([0.5, 0.0, 0.0])
    K = bad.K.copy()
    K[0, 0], K[1, 1] = 1.03 * K[0, 0], 1.03 * K[1, 1]
    found[names[1]] = replace(bad, K=K, t=-bad.R @ moved)
    errors = synthetic.network_errors(situation, found)
    centres = np.array([camera.centre for camera in situation.cameras])
    size = np.linalg.norm(centres[:, None] - centres, axis=2).max()
    assert errors[names[1]].rotation == pytest.approx(2.0, abs=1e-6)
    assert errors[names[1]].position == pytest.approx(0.5 / size, rel=1e-6)
    assert errors[names[1]].focal == pytest.approx(0.03)
    for name in (names[0], *names[2:]):
        assert errors[name].rotation < 1e-5
        assert errors[name].position < 1e-9
    a, b = next(pair for pair in situation.pairs() if 1 in pair and situation.answer(*pair).exists)
    assert synthetic.pair_error(situation, found, a, b) > 1


def test_a_part_of_the_cameras(situation):
    found = {camera.name: in_another_world(camera) for camera in situation.cameras[1:4]}
    assert list(synthetic.network_errors(situation, found)) == ["cam02", "cam03", "cam04"]


def test_a_wrong_lens_shows_in_the_pairs(situation):
    found = {camera.name: in_another_world(camera) for camera in situation.cameras}
    first = situation.cameras[0].name
    found[first] = found[first].without_lens()
    a, b = next(pair for pair in situation.pairs() if pair[0] == 0 and situation.answer(*pair).exists)
    assert synthetic.pair_error(situation, found, a, b) > 0.5
