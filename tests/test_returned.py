"""What workers return is held against what was asked for: one that lies costs its pair, and no more."""

from concurrent.futures import Executor, Future
from dataclasses import replace

import numpy as np
import pytest
from jobs_input import FAST, content, write_masks

import epibar
from epibar import Calibration


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))[:3]


class Lying(Executor):
    """Runs what it is given, and returns something else for one camera or pair."""

    def __init__(self, who, lie):
        self.who, self.lie = who, lie

    def submit(self, function, *arguments):
        future = Future()
        value, seconds = function(*arguments)
        names = "-".join(getattr(argument, "name", "") for argument in arguments[:2]).strip("-")
        future.set_result(self.lie(value, seconds) if names == self.who else (value, seconds))
        return future


def points(calibration, **other):
    return replace(calibration, frontier_points=replace(calibration.frontier_points, **other))


def renamed(recording):
    recording.name = "cam9"
    return recording


@pytest.mark.parametrize(
    "lie",
    [
        lambda c, s: None,
        lambda c, s: (c, s, 1),
        lambda c, s: ("calibration", s),
        lambda c, s: (c, float("nan")),
        lambda c, s: (c, -1.0),
        lambda c, s: (replace(c, F=np.eye(2)), s),
        lambda c, s: (replace(c, accepted=True, F=None), s),
        lambda c, s: (replace(c, accepted="yes"), s),
        lambda c, s: (replace(c, reason=object()), s),
        lambda c, s: (replace(c, timing=None), s),
        lambda c, s: (replace(c, seed=5), s),
        lambda c, s: (replace(c, method="frontier"), s),
        lambda c, s: (points(c, frame=c.frontier_points.frame + 1000), s),
        lambda c, s: (points(c, a=c.frontier_points.a + 1000), s),
        lambda c, s: (points(c, residual=c.frontier_points.residual[:-1]), s),
    ],
)
def test_a_lie_about_a_pair(lie, masks, tmp_path):
    found = epibar.calibrate_all(masks, tmp_path, executor=Lying("cam1-cam3", lie), **FAST)
    assert list(found.calibrations) == [("cam1", "cam2"), ("cam2", "cam3")]
    assert [(error["a"], error["b"]) for error in found.errors] == [("cam1", "cam3")]
    assert not (tmp_path / "pairs" / "cam1_cam3.npz").exists()
    assert isinstance(found.calibrations["cam1", "cam2"], Calibration)
    assert b"cam1_cam3" not in content(tmp_path)


@pytest.mark.parametrize(
    "lie",
    [
        lambda r, s: (None, s),
        lambda r, s: (renamed(r), s),
        lambda r, s: (epibar.Recording.from_masks(np.ones((3, 9, 9), bool), lines=7, name="cam2"), s),
    ],
)
def test_a_lie_about_a_camera(lie, masks, tmp_path):
    found = epibar.calibrate_all(masks, tmp_path, executor=Lying("cam2", lie), **FAST)
    assert list(found.calibrations) == [("cam1", "cam3")]
    assert [error["camera"] for error in found.errors] == ["cam2"]
    assert not (tmp_path / "recordings" / "cam2.npz").exists()
