"""What workers return is held against what was asked for: one that lies costs its pair, and no more."""

from concurrent.futures import Executor, Future
from dataclasses import replace
from shutil import copytree

import numpy as np
import pytest
from jobs_input import FAST, content, write_masks
from network_input import made_up

import epibar
from epibar import Calibration, EpibarError
from epibar.jobs.returned import checked_clocks, checked_network
from epibar.network import Network
from epibar.network.offsets import ClockOffsets
from epibar.sources.pictures import Pictures


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))[:3]


@pytest.fixture(scope="module")
def finished(masks, tmp_path_factory):
    """The folder of a run in which nobody lied."""
    folder = tmp_path_factory.mktemp("finished")
    epibar.calibrate_all(masks, folder, **FAST)
    return folder


@pytest.fixture
def without(finished, tmp_path):
    """A folder in which all is kept but one recording or pair."""

    def made(missing):
        copytree(finished, tmp_path, dirs_exist_ok=True)
        (tmp_path / missing).unlink()
        return tmp_path

    return made


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


def pictured(recording):
    recording.pictures = Pictures({recording.frames: b"\xff\xd8\xff"})
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
def test_a_lie_about_a_pair(lie, masks, without):
    out = without("pairs/cam1_cam3.npz")
    found = epibar.calibrate_all(masks, out, executor=Lying("cam1-cam3", lie), **FAST)
    assert list(found.calibrations) == [("cam1", "cam2"), ("cam2", "cam3")]
    assert [(error["a"], error["b"]) for error in found.errors] == [("cam1", "cam3")]
    assert not (out / "pairs" / "cam1_cam3.npz").exists()
    assert isinstance(found.calibrations["cam1", "cam2"], Calibration)
    assert b"cam1_cam3" not in content(out)


@pytest.mark.parametrize(
    "lie",
    [
        lambda r, s: (None, s),
        lambda r, s: (renamed(r), s),
        lambda r, s: (pictured(r), s),
        lambda r, s: (epibar.Recording.from_masks(np.ones((3, 9, 9), bool), lines=7, name="cam2"), s),
    ],
)
def test_a_lie_about_a_camera(lie, masks, without):
    out = without("recordings/cam2.npz")
    found = epibar.calibrate_all(masks, out, executor=Lying("cam2", lie), **FAST)
    assert list(found.calibrations) == [("cam1", "cam3")]
    assert [error["camera"] for error in found.errors] == ["cam2"]
    assert not (out / "recordings" / "cam2.npz").exists()


@pytest.mark.parametrize(
    "lie",
    [
        None,
        (0.0, 0.1, 0.2),
        ClockOffsets((0.0, 0.1)),
        ClockOffsets([0.0, 0.1, 0.2]),
        ClockOffsets((0.0, 0.1, float("inf"))),
        ClockOffsets((0.0, 0.1, "soon")),
        ClockOffsets((0.0, 0.1, 0.2), together="yes"),
        ClockOffsets((0.0, 0.1, 0.2), given=True),
    ],
)
def test_a_lie_about_the_clocks(lie):
    with pytest.raises(EpibarError, match="no 3 clocks"):
        checked_clocks(lie, 3)


def test_clocks_of_which_nothing_tells():
    found = ClockOffsets((0.0, 0.1, float("nan")))
    assert checked_clocks(found, 3) is found


def seen_by(network):
    """A recording of the right size for each camera."""
    masks = {size: np.zeros((1, *size[::-1]), bool) for size in {c.size for c in network.cameras.values()}}
    return {
        name: epibar.Recording.from_masks(masks[camera.size], lines=5, name=name)
        for name, camera in network.cameras.items()
    }


def other_camera(network, **other):
    cameras = dict(network.cameras)
    cameras["cam1"] = replace(cameras["cam1"], **other)
    return replace(network, cameras=cameras)


@pytest.mark.parametrize(
    "lie",
    [
        lambda n: None,
        lambda n: n.as_dict(),
        lambda n: replace(n, accepted=True),
        lambda n: replace(n, unit="furlong"),
        lambda n: replace(n, reason=object()),
        lambda n: replace(n, ground=None),
        lambda n: replace(n, clocks={}),
        lambda n: other_camera(n, rotation=2 * np.eye(3)),
        lambda n: other_camera(n, translation=np.full(3, np.nan)),
        lambda n: other_camera(n, name="cam9"),
        lambda n: other_camera(n, size=(64, 48)),
    ],
)
def test_a_lie_about_the_network(lie):
    network = made_up()
    with pytest.raises(EpibarError, match="not used"):
        checked_network(lie(network), seen_by(network))


def test_a_network_is_taken_as_it_is():
    network = made_up()
    taken = checked_network(network, seen_by(network))
    assert isinstance(taken, Network)
    assert taken.as_dict().keys() == network.as_dict().keys()
    assert taken.cameras["cam1"].expected == network.cameras["cam1"].expected
    np.testing.assert_array_equal(taken.cameras["cam2"].rotation, network.cameras["cam2"].rotation)


def test_a_lie_about_the_network_costs_the_network_alone(masks, tmp_path):
    """The pairs stay; the clocks are given."""
    options = {**FAST, "method": "frontier", "lines": 300, "masks": True}

    class Lies(Lying):
        def submit(self, function, *arguments):
            if function.__name__ != "join_cameras":
                return super().submit(function, *arguments)
            future = Future()
            future.set_result(made_up())
            return future

    found = epibar.calibrate_all(masks, tmp_path, executor=Lies("nobody", None), **options)
    assert len(found.calibrations) == 3
    assert found.network is None
    assert "other cameras" in found.content["network_reason"]
    assert not (tmp_path / "network.json").exists()
