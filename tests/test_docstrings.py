"""Every example in a docstring runs, in a folder with small videos under the names that examples use."""

import doctest
import importlib
import pkgutil
import shutil

import cv2
import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.lens import Intrinsics, write_cameras
from epibar.network import Ground, NetworkCamera, NetworkClock, NetworkPair
from epibar.network.parts import NetworkPairs

SIZE, FRAMES, LINES = (320, 240), 250, 2000
NEEDS = {"epibar.live": "rerun", "epibar.plot": "matplotlib", "epibar.export": "pycolmap"}


def examples():
    """Yield the doctests of every module that has some."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    names = [one.name for one in pkgutil.walk_packages(epibar.__path__, "epibar.")]
    for name in ["epibar", *sorted(name for name in names if name != "epibar.__main__")]:
        for found in finder.find(importlib.import_module(name), name):
            if found.examples:
                yield pytest.param(found, id=found.name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three videos and recordings, the known cameras, a run of all, what it kept of two, a network of two."""
    folder = tmp_path_factory.mktemp("examples")
    scene = synthetic.people(seed=5, cameras=3, walkers=5, frames=FRAMES, size=SIZE, asymmetric=True)
    cameras, videos = [], []
    for index, camera in enumerate(scene.cameras):
        name = f"cam{index + 1}"
        videos.append(synthetic.render_video(scene, index, folder / f"{name}.mp4", noise=1))
        rotation = cv2.Rodrigues(camera.R)[0].ravel()
        cameras.append(Intrinsics(name, camera.size, camera.K, rotation=rotation, translation=camera.t))
    write_cameras(folder / "cameras.toml", cameras)
    # Examples that give the same videos and folder find all of it done.
    epibar.calibrate_all(videos, folder / "calibrated", lines=LINES)
    for kept in (folder / "calibrated").glob("*/*.npz"):
        shutil.copy(kept, folder)
    of_two(scene).save(folder / "network.json")
    return folder


def of_two(scene):
    """The true network of the first two cameras."""
    expected = {"focal": 0.001, "rotation": 0.1, "position": 0.01}
    cameras = {
        name: NetworkCamera(
            *(name, camera.size, True, "accepted", "true", camera.K, np.zeros(5), camera.R, camera.t),
            expected,
        )
        for name, camera in zip(("cam1", "cam2"), scene.cameras, strict=False)
    }
    clocks = {name: NetworkClock(0.0, 0.0, 0.0) for name in cameras}
    F = np.eye(3) / 3**0.5
    pairs = NetworkPairs([NetworkPair("cam1", "cam2", True, "confirmed", F)])
    return epibar.Network(cameras, pairs, clocks, True, "the true one", "metre", Ground("cameras"))


@pytest.fixture
def quick(monkeypatch):
    """Fewer lines where an example leaves them open, so that all take seconds."""
    seed = epibar.record.__defaults__[1]
    monkeypatch.setattr(epibar.record, "__defaults__", (LINES, seed))
    monkeypatch.setitem(epibar.calibrate_all.__kwdefaults__, "lines", LINES)


@pytest.mark.parametrize("example", list(examples()))
@pytest.mark.usefixtures("quick")
def test_example(example, folder, monkeypatch):
    needed = next((library for name, library in NEEDS.items() if example.name == name), None)
    if needed:
        pytest.importorskip(needed, reason=f"{needed}, which the example is about, is not installed")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("MPLBACKEND", "agg")
    told = []
    result = doctest.DocTestRunner(verbose=False).run(example, out=told.append)
    assert result.failed == 0, "".join(told)
    assert result.attempted == len(example.examples)


def test_examples_are_found_and_none_is_left_out():
    found = [example.values[0] for example in examples()]
    assert {"epibar", "epibar.calibration.calibrate", "epibar.Recording.from_masks"} & {
        one.name for one in found
    }
    assert len(found) > 15
    skipped = [one.name for one in found if any(doctest.SKIP in line.options for line in one.examples)]
    assert skipped == []
