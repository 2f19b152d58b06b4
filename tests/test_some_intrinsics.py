"""A camera file that has the lenses of some cameras: which are taken, and what is said of the others."""

import json
from dataclasses import replace

import numpy as np
import pytest
from check_input import FEW, SIZE, network, some_masks
from jobs_input import WORDS, write_masks

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.cli.calibrate import _about_lenses
from epibar.jobs import runner
from epibar.jobs.all_pairs import AllPairs
from epibar.jobs.inputs import camera_inputs
from epibar.lens import Intrinsics, write_cameras
from epibar.lens.cameras_toml import find_cameras
from epibar.report.inputs import ReportCamera
from epibar.report.prose import ABOUT_LENSES, advice, pairs_pixels

MATRIX = [[150.0, 0.0, 79.5], [0.0, 150.0, 59.5], [0.0, 0.0, 1.0]]


def lens(name):
    return Intrinsics(name, (160, 120), MATRIX)


@pytest.fixture(scope="module")
def cubes(tmp_path_factory):
    return [str(path) for path in write_masks(tmp_path_factory.mktemp("cubes"))]


@pytest.fixture
def given(tmp_path):
    """Write a camera file of some names."""

    def write(*names):
        write_cameras(tmp_path / "some.toml", map(lens, names))
        return str(tmp_path / "some.toml")

    return write


def test_places_say_something_where_every_video_has_one():
    assert find_cameras([lens("cam1"), lens("cam3")], ["cam1", "cam2", "cam3"]).keys() == {"cam1", "cam3"}
    found = find_cameras([lens("a"), lens("cam1"), lens("c")], ["cam1", "x", "y"])
    assert {name: one.name for name, one in found.items()} == {"cam1": "cam1", "y": "c"}
    # Of two tables it is not known which of the three videos they are of.
    with pytest.raises(EpibarError, match=r"x: no camera of that name .* it has a, b"):
        find_cameras([lens("a"), lens("b")], ["x", "y", "z"])


def test_two_cameras_need_both(cubes, given, tmp_path):
    with pytest.raises(EpibarError, match="cam2: no camera of that name in the camera file"):
        camera_inputs(cubes[:2], intrinsics=given("cam1"), masks=True)
    # One that was recorded already may know its own.
    saved = [str(tmp_path / f"cam{k}.npz") for k in (1, 2)]
    for path, masks in zip(saved, cubes, strict=False):
        epibar.record(masks, masks=True, lines=100).save(path)
    with pytest.raises(EpibarError, match=r"cam2: no camera"):
        camera_inputs([saved[0], "cam2.mp4"], intrinsics=given("cam1"))
    one, other = camera_inputs(["cam1.mp4", saved[1]], intrinsics=given("cam1"))
    assert (one.intrinsics.name, other.intrinsics) == ("cam1", None)


def test_a_file_of_some_cameras_is_used_for_these(cubes, given, tmp_path, capsys):
    out = tmp_path / "out"
    words = ["calibrate", *cubes[:3], "-o", str(out), *WORDS, "--intrinsics", given("cam2", "cam9")]
    assert main(words) == 0
    printed = capsys.readouterr()
    assert "some.toml: no video is called cam9" in printed.err
    assert "some.toml does not have cam1, cam3: taken as filmed" in printed.err
    assert "pairs of cam1, cam3 were calibrated without a lens model" in printed.err
    content = json.loads((out / "calibration.json").read_text())
    assert [camera["matrix"] is None for camera in content["cameras"]] == [True, False, True]
    assert content["convention"].endswith("each camera that has one, of others as in the video")
    assert main([*words[:-1], given("cam7", "cam9")]) == 2
    assert "it has cam7, cam9" in capsys.readouterr().err


def test_pairs_are_exported_with_a_file_of_some(cubes, given, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["calibrate", *cubes[:3], "-o", str(out), *WORDS, "-q"]) == 0
    export = ["export", str(out), "--all", "--format", "npz", "-o", str(tmp_path / "pairs.npz")]
    assert main([*export, "--intrinsics", given("cam2", "cam9")]) == 0
    assert "some.toml: no camera is called cam9" in capsys.readouterr().err
    assert main([*export, "--intrinsics", given("cam1", "cam2")]) == 0
    printed = capsys.readouterr()
    assert "without a pose: cam1 - cam3: no camera matrix" in printed.err
    assert "without a pose: cam1 - cam2: no camera matrix" not in printed.err
    assert main([*export, "--intrinsics", given("cam9", "cam8")]) == 2


def test_inspect_takes_a_file_of_some(cubes, given, capsys):
    words = ["inspect", *cubes[:2], "--masks", "--lines", "100", "--intrinsics"]
    assert main([*words, given("cam2")]) == 0
    assert "does not have cam1" in capsys.readouterr().err
    assert main([*words, given("cam8")]) == 2


def test_check_takes_a_file_of_some(core, tmp_path, capsys):
    net = network()
    net.cameras["cam1"] = replace(net.cameras["cam1"], distortions=np.zeros(5), undistorted=True)
    net.save(tmp_path / "network.json")
    masks = [str(tmp_path / f"cam{k + 1}.npz") for k in range(3)]
    for k, path in enumerate(masks):
        np.savez_compressed(path, masks=some_masks(k), fps=25.0)
    taken_out = Intrinsics("cam1", SIZE, net.cameras["cam1"].matrix, [-0.2, 0.0, 0.0, 0.0])
    strange = Intrinsics("cam9", SIZE, net.cameras["cam1"].matrix)
    words = ["check", str(tmp_path), *masks, *FEW, "--intrinsics", str(tmp_path / "some.toml")]
    write_cameras(tmp_path / "some.toml", [taken_out, strange])
    assert main(words) == 0
    assert [round(one["camera"]["distortions"][0], 3) for one in core.cameras] == [0.0, -0.21, -0.22]
    assert "some.toml: no camera is called cam9" in capsys.readouterr().err
    write_cameras(tmp_path / "some.toml", [strange])
    assert main(words) == 2
    assert "it has cam9" in capsys.readouterr().err
    # Of a run that took no lens of cam2 out, the one that is given is of no use.
    cameras = [{"name": "cam2", "width": 640, "height": 480, "matrix": None, "index": 1}]
    content = {"format": 1, "cameras": cameras, "pairs": [], "intrinsics": None}
    (tmp_path / "calibration.json").write_text(json.dumps(content))
    write_cameras(tmp_path / "some.toml", [taken_out, replace(taken_out, name="cam2")])
    assert main(words) == 0
    assert "some.toml is not used for cam2" in capsys.readouterr().err
    assert core.cameras[1]["camera"]["distortions"][0] == pytest.approx(-0.21)


# --- sentences ---


def films(*known):
    masks = np.zeros((20, 120, 160), bool)
    return {
        f"cam{k + 1}": epibar.Recording.from_masks(masks, lines=20, matrix=MATRIX if matrix else None)
        for k, matrix in enumerate(known)
    }


def test_whose_lenses_were_found_is_said():
    def said(*known):
        return _about_lenses(AllPairs(films(*known), {}, [], {}, network()))

    assert said(True, True, True) is None
    assert said(False, False, False).startswith("focal lengths and lenses were not given")
    assert said(True, False, False).startswith("focal lengths and lenses of cam2, cam3 were not given")


def test_a_third_camera_is_no_advice_for_three():
    def said(*known):
        return _about_lenses(AllPairs(films(*known), {}, [], {}))

    assert said(False, False).endswith("give --intrinsics, or a third camera")
    assert said(False, True, False).startswith("pairs of cam1, cam3 were calibrated without a lens model")
    assert said(False, True, False).endswith("give --intrinsics")


def test_saved_recordings_are_not_called_as_filmed(cubes, tmp_path, monkeypatch, capsys):
    """Whether they are shows when they are read."""

    def refused(*_):
        raise EpibarError("not here")

    monkeypatch.setattr(runner, "calibrate_pair", refused)
    saved = []
    for name, film in films(True, True, True).items():
        saved.append(str(tmp_path / f"{name}.npz"))
        film.save(saved[-1])
    few = ["--no-report", "--time-offset", "0", "--lines", "20"]
    for words, told in ((saved, False), ([*cubes[:3], "--masks"], True)):
        assert main(["calibrate", *words, "-o", str(tmp_path / f"out{told}"), *few]) != 0
        assert ("may be refused for its lenses" in capsys.readouterr().err) == told


def test_the_report_says_which_pairs_are_as_filmed():
    def said(*known):
        return pairs_pixels(
            [ReportCamera(name, None, True, film, None) for name, film in films(*known).items()]
        )

    assert said(False, False).startswith("As they were filmed")
    assert "filmed" not in said(True, True)
    assert said(True, False).startswith("cam1 in undistorted pixels")


def test_a_lens_that_was_taken_out_is_not_asked_for():
    masks = np.zeros((20, 120, 160), bool)
    one = epibar.Recording.from_masks(masks, lines=20)
    inaccurate = replace(
        epibar.calibrate(one, one, method="lines", draws=10), kind="inaccurate", accepted=False
    )
    assert ABOUT_LENSES in advice(inaccurate)
    assert ABOUT_LENSES not in advice(inaccurate, lenses_known=True)
