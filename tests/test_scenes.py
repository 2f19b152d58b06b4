"""Views that differ: rolled or facing cameras, objects and parts of the scene that only one of them sees."""

from dataclasses import replace

import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.geometry.cameras import inside
from epibar.geometry.epipolar import epipoles

SIZE = (480, 360)
LINES = 10_000


def walkers(seed, **options):
    """Eight people before two cameras."""
    return synthetic.people(seed, cameras=2, frames=500, size=SIZE, **options)


def cubes(seed):
    return synthetic.cubes(seed, cameras=2, objects=10, frames=300, size=SIZE)


def rolled(scene, rolls):
    """Roll the cameras clockwise, degrees."""

    def turned(camera, roll):
        cos, sin = np.cos(np.deg2rad(roll)), np.sin(np.deg2rad(roll))
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return replace(camera, R=turn @ camera.R, t=turn @ camera.t)

    return replace(scene, cameras=[turned(*both) for both in zip(scene.cameras, rolls, strict=True)])


def occluded_in_one_view(seed):
    """People before two cameras, static boxes hiding what the second sees."""
    scene = walkers(seed, occluders=8)
    seen_by = scene.solids.seen_by.copy()
    seen_by[~scene.solids.moving, 0] = False
    return replace(scene, solids=replace(scene.solids, seen_by=seen_by))


def moving_pixels(scene):
    """Pixels of both cameras' masks, in frames spread over the scene."""
    frames = range(0, scene.frames, 50)
    return [sum(int(scene.masks(i, t, t + 1).sum()) for t in frames) for i in range(2)]


def check(scene, **options):
    """Calibrate; F must be right over the volume where things moved, and accepted."""
    recordings = [epibar.Recording.from_masks(scene.masks(i), lines=LINES, seed=i) for i in range(2)]
    calibration = epibar.calibrate(*recordings, **options)
    error = epibar.symmetric_epipolar_distance(calibration.F, *scene.volume_correspondences(0, 1)).mean()
    assert calibration.accepted, f"{calibration.reason} ({error:.2f} px)"
    assert error < 1.0


def test_objects_that_only_one_camera_sees():
    scene = walkers(1, one_camera_only=4)
    assert all(
        more > 1.1 * less for more, less in zip(moving_pixels(scene), moving_pixels(walkers(1)), strict=True)
    )
    check(scene)


def test_static_occluders_in_one_view():
    scene = occluded_in_one_view(3)
    (seen, hidden), (all_of_it, uncovered) = moving_pixels(scene), moving_pixels(walkers(3))
    assert seen == all_of_it
    assert hidden < 0.95 * uncovered
    check(scene)


def test_images_of_different_size_and_focal_length():
    scene = walkers(1, asymmetric=True)
    assert scene.cameras[0].size != scene.cameras[1].size
    check(scene)


def test_cameras_that_see_each_other():
    scene = walkers(1, facing=True)
    for epipole, camera in zip(epipoles(scene.fundamental(0, 1)), scene.cameras, strict=True):
        assert inside((epipole[:2] / epipole[2])[None], camera.size)[0]
    check(scene)


@pytest.mark.parametrize("rolls", [(30, -30), (90, 0), (0, 180), (-120, 70)])
def test_rolled_cameras(rolls):
    check(rolled(walkers(1), rolls), upright=False)


def test_rolled_cameras_without_a_common_clock():
    """Up is found before the clocks: tangents are told apart by it while they are fitted, too."""
    scene, late = rolled(walkers(1), (90, -90)), 37
    a = epibar.Recording.from_masks(scene.masks(0), lines=LINES, seed=0)
    b = epibar.Recording.from_masks(scene.masks(1, late), lines=LINES, seed=1)
    calibration = epibar.calibrate(a, b, upright=False, time_offset="search")
    assert calibration.accepted, calibration.reason
    assert abs(calibration.time_offset + late) < 0.2


def test_rolled_cameras_before_what_has_no_up():
    check(rolled(cubes(1), (90, -120)), upright=False)
