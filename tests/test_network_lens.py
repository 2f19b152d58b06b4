"""Lenses that a network finds: those of fisheye cameras, and how far from the middle a lens is one."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from network_input import LINES, made_up

import epibar
from epibar import synthetic
from epibar.network import NetworkCamera
from epibar.report.camera_angles import field_of_view, image_corners
from epibar.synthetic.networks import SETTINGS
from epibar.synthetic.settings import draw

MATRIX = np.array([[500.0, 0.0, 319.5], [0.0, 500.0, 239.5], [0.0, 0.0, 1.0]])


def camera(*radial):
    k1, k2, k3 = radial
    return NetworkCamera("cam1", (640, 480), True, "accepted", "", MATRIX, np.array([k1, k2, 0.0, 0.0, k3]))


def test_a_lens_reaches_to_where_its_polynomial_turns_back():
    # r + k1 r³ is largest at r = 1/√(-3 k1), where it is two thirds of that.
    assert camera(-0.3, 0.0, 0.0).lens_reach == pytest.approx(500 * 2 / 3 / np.sqrt(0.9), abs=0.5)
    assert camera(-0.1, 0.0, 0.0).lens_reach is None
    assert camera(0.1, 0.0, 0.0).lens_reach is None
    assert camera(-0.3, 0.1, 0.0).lens_reach is None
    assert camera(0.0, 0.0, -0.5).lens_reach < 400
    assert replace(camera(-0.3, 0.0, 0.0), matrix=MATRIX + np.diag([200.0, 200.0, 0.0])).lens_reach is None
    assert made_up().cameras["cam4"].lens_reach is None


def test_directions_undo_a_strong_lens():
    one = camera(-0.34, 0.16, -0.04)
    rays = np.array([[0.0, 0.0], [0.3, -0.2], [-0.9, 0.4], [0.8, 0.8]])
    nowhere = np.zeros(3)
    points = np.column_stack([rays, np.ones(4)])
    pixels = cv2.projectPoints(points, nowhere, nowhere, one.matrix, one.distortions)[0][:, 0]
    np.testing.assert_allclose(one.directions(pixels), rays, atol=1e-6)
    assert np.isnan(camera(-0.3, 0.0, 0.0).directions([[319.5 + 360.0, 239.5]])).all()
    np.testing.assert_allclose(replace(one, distortions=None).directions([[819.5, 239.5]]), [[1.0, 0.0]])
    with pytest.raises(epibar.EpibarError, match="shape"):
        one.directions([1.0, 2.0])
    with pytest.raises(epibar.EpibarError, match="cam4 has no place"):
        made_up().cameras["cam4"].directions([[0.0, 0.0]])


def test_the_report_shows_what_a_lens_holds_for():
    one = replace(camera(-0.3, 0.0, 0.0), rotation=np.eye(3), translation=np.zeros(3))
    assert one.lens_reach < 400
    corners = image_corners(one, 1.0)
    focal = one.matrix[0, 0]
    radius = np.hypot(*corners[:, :2].T)
    np.testing.assert_allclose(focal * radius * (1 - 0.3 * radius**2), 0.98 * one.lens_reach, rtol=1e-6)
    # Half of the width is within reach.
    half = np.tan(np.deg2rad(field_of_view(one) / 2))
    assert focal * half * (1 - 0.3 * half**2) == pytest.approx(320, abs=0.01)


def test_the_lenses_of_fisheye_cameras_are_found():
    setting = replace(
        SETTINGS["network_fisheye"],
        cameras=(3, 3),
        clocks=None,
        frames=(700, 700),
        rates=(12.5,),
        count=(8, 8),
    )
    made = draw(4, "network_fisheye", setting)
    recordings = {
        one.name: made.recording(index, lines=LINES, matrix=False) for index, one in enumerate(made.cameras)
    }
    net = epibar.calibrate_network(recordings, time_offset=0.0)
    assert net.accepted, net.reason
    found = synthetic.accepted_cameras(net)
    for name, error in synthetic.network_errors(made, found).items():
        expected = net.cameras[name].expected
        assert abs(error.focal) < 2 * expected["focal"] < 0.1, name
        assert error.rotation < 2 * expected["rotation"] < 4, name
    assert any(camera.lens_reach is not None for camera in net.cameras.values())
    for one in made.cameras:
        reach = net.cameras[one.name].lens_reach
        middle = (np.array(one.size) - 1) / 2
        assert (reach is None) == ("its lens holds up to" not in net.cameras[one.name].reason)
        # Half way to the sides the lens that was found shows what the true one does.
        seen = middle + 0.25 * min(one.size) * np.array([[1, 0], [0, 1], [-1, 0], [0.7, 0.7]])
        apart = _shown(net.cameras[one.name], one, seen) - seen
        assert np.linalg.norm(apart - apart.mean(axis=0), axis=1).max() < 3


def _shown(found, true, seen):
    """Where the camera that was found shows what the true one shows at pixels."""
    rays = (true.undistort(seen) - true.K[:2, 2]) / true.K[0, 0]
    points = np.column_stack([rays, np.ones(len(rays))])
    nowhere = np.zeros(3)
    return cv2.projectPoints(points, nowhere, nowhere, found.matrix, found.distortions)[0][:, 0]


def test_fisheye_lenses_bend_by_angles():
    one = replace(synthetic.situation(1, "network_fisheye").cameras[0], fisheye=0.0)
    focal, middle = one.K[0, 0], one.K[:2, 2]
    for degrees in (0.0, 20.0, 70.0, 85.0):
        angle = np.deg2rad(degrees)
        straight = middle + focal * np.tan(angle) * np.array([0.6, 0.8])
        bent = middle + focal * angle * np.array([0.6, 0.8])
        np.testing.assert_allclose(one.distort(straight), bent, atol=1e-9)
        np.testing.assert_allclose(one.undistort(bent), straight, atol=1e-6)
    assert np.isnan(one.undistort(middle + np.array([focal * 1.6, 0.0]))).all()
    for k in (-0.04, 0.08):
        other = replace(one, fisheye=k)
        pixels = middle + focal * np.linspace(-1.2, 1.2, 25)[:, None] * [0.8, 0.6]
        np.testing.assert_allclose(other.distort(other.undistort(pixels)), pixels, atol=1e-6)
    assert not one.without_lens().distorted
