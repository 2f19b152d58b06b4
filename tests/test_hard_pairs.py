"""Made-up pairs of which the verdict was wrong once, looked at since."""

import pytest

import epibar
from epibar import synthetic


def recorded(seed, family, a, b):
    situation = synthetic.situation(seed, family)
    return situation, situation.recording(a), situation.recording(b)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_queue_is_found_by_either_order_of_its_cameras(swapped):
    """People who merge and hide one another: refused by one order as having no common scene."""
    a, b = (3, 2) if swapped else (2, 3)
    situation, rec_a, rec_b = recorded(9205, "queueing", a, b)
    cal = epibar.calibrate(rec_a, rec_b)
    assert cal.accepted, cal.reason
    assert situation.error(cal.F, a, b) < cal.expected_error < 1.5


def test_one_path_is_refused_where_it_is_off_beside_the_path():
    """Accepted once: 0.6 px off on the path, 3.9 px over the room."""
    situation, rec_a, rec_b = recorded(9002, "one_path_strays", 0, 1)
    cal = epibar.calibrate(rec_a, rec_b)
    assert situation.error(cal.F, 0, 1) < 1.0 < 3.0 < situation.error(cal.F, 0, 1, situation.room_points)
    assert not cal.accepted
    assert cal.kind == "undetermined"
    assert "one path" in cal.reason
