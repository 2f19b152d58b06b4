"""Of which pixels a camera is: the lens that was taken out of its recording stays known, or it is said."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from check_input import FEW, SIZE, films, network, some_masks

import epibar
from epibar import EpibarError, Recording
from epibar.camera_export.formats import CAMERA_FORMATS
from epibar.cli import main
from epibar.lens import Intrinsics, write_cameras
from epibar.network.core_parts import camera_of
from epibar.network.prose import network_notes

BENT = [-0.2, 0.03, 0.0, 0.0, 0.0]


def lens(name, distortions=BENT, fisheye=False):
    return Intrinsics(name, SIZE, network().cameras[name].matrix, distortions, fisheye)


def straight(*names, known=True):
    """The network of check_input, some cameras of which are in undistorted pixels."""
    net = network()
    for name in names:
        net.cameras[name] = replace(
            net.cameras[name],
            distortions=np.zeros(5),
            undistorted=True,
            lens=lens(name) if known else None,
        )
    return net


@pytest.fixture
def masks(tmp_path):
    for k in range(3):
        np.savez_compressed(tmp_path / f"cam{k + 1}.npz", masks=some_masks(k), fps=25.0)
    return [str(tmp_path / f"cam{k + 1}.npz") for k in range(3)]


# --- what is kept ---


@pytest.mark.parametrize("fisheye", [False, True])
def test_a_recording_keeps_the_lens_that_was_taken_out(fisheye, masks, tmp_path):
    known = lens("cam1", BENT[:4], fisheye)
    made = epibar.record(masks[0], masks=True, lines=50, intrinsics=known)
    made.save(tmp_path / "saved.npz")
    again = Recording.load(tmp_path / "saved.npz").lens
    assert (again.size, again.fisheye) == (SIZE, fisheye)
    np.testing.assert_array_equal(again.matrix, known.matrix)
    np.testing.assert_array_equal(again.distortions, known.distortions)
    assert epibar.record(masks[0], masks=True, lines=50).lens is None


def test_a_lens_that_is_damaged_is_refused(masks, tmp_path):
    made = epibar.record(masks[0], masks=True, lines=50, intrinsics=lens("cam1"))
    arrays = {**made.to_arrays(), "distortions": np.zeros(7)}
    with pytest.raises(EpibarError, match=r"^there: damaged \(.*7 distortions"):
        Recording.from_arrays(arrays, "there")
    del arrays["distortions"], arrays["fisheye"]  # as older versions saved it
    assert Recording.from_arrays(arrays, "there").lens is None


def test_a_network_keeps_it_and_exports_are_for_the_videos(tmp_path):
    net = straight("cam1")
    net.save(tmp_path / "network.json")
    again = epibar.Network.load(tmp_path / "network.json")
    assert [camera.undistorted for camera in again.cameras.values()] == [True, False, False, False]
    np.testing.assert_array_equal(again.cameras["cam1"].lens.distortions, BENT)
    again.export(tmp_path / "cameras.toml")
    one, other = epibar.load_cameras(tmp_path / "cameras.toml")[:2]
    np.testing.assert_array_equal(one.distortions, BENT)
    np.testing.assert_array_equal(other.distortions, net.cameras["cam2"].distortions)
    assert not any("undistorted" in text for text in network_notes(again))
    content = json.loads((tmp_path / "network.json").read_text())
    content["cameras"][0]["lens"]["distortions"] = [1, 2]
    (tmp_path / "network.json").write_text(json.dumps(content))
    with pytest.raises(EpibarError, match=r"network\.json: damaged .*2 distortions"):
        epibar.Network.load(tmp_path / "network.json")


def test_what_the_recordings_know_is_what_the_network_does():
    answer = dict.fromkeys(("matrix", "distortions", "rotation", "translation", "expected"))
    answer |= {"name": "cam1", "accepted": False, "status": "", "reason": "", "position_covariance": None}
    answer["deviates"] = (np.nan, np.nan)
    (film,) = films("cam1", matrix=lens("cam1").matrix).values()
    for taken_out, undistorted in ((None, True), (lens("cam1"), True), (lens("cam1", np.zeros(5)), False)):
        film.lens = taken_out
        assert camera_of(answer, SIZE, film).undistorted == undistorted
    film.matrix = film.lens = None
    assert not camera_of(answer, SIZE, film).undistorted


def test_where_the_lens_is_not_known_it_is_said(tmp_path):
    net = straight("cam1", "cam3", known=False)
    (told,) = (text for text in network_notes(net) if "undistorted" in text)
    assert told.startswith("cam1, cam3: in undistorted pixels, not in those of the video")
    for name in CAMERA_FORMATS:
        if name in ("anipose", "caliscope"):
            net.export(tmp_path / name, name)
            assert told in tomllib.loads((tmp_path / name).read_text())["metadata"]["notes"]
    net.export(tmp_path / "given.toml", lenses={"cam1": lens("cam1")})
    notes = tomllib.loads((tmp_path / "given.toml").read_text())["metadata"]["notes"]
    assert [text.partition(":")[0] for text in notes if "undistorted" in text] == ["cam3"]


# --- new footage ---


def test_new_footage_is_undistorted_as_the_old_was(core, masks, tmp_path, capsys):
    """By network.json alone: neither calibration.json nor a camera file is there any more."""
    straight("cam1", "cam2").save(tmp_path / "network.json")
    assert main(["check", str(tmp_path), *masks, *FEW]) == 0, capsys.readouterr().err
    assert [one["camera"]["distortions"] for one in core.cameras[:2]] == [[0.0] * 5] * 2
    assert core.cameras[2]["camera"]["distortions"] == network().cameras["cam3"].distortions.tolist()
    expected = epibar.record(masks[0], masks=True, lines=50, intrinsics=lens("cam1"))
    np.testing.assert_array_equal(core.recordings[0].heat, expected.heat)
    raw = epibar.record(masks[0], masks=True, lines=50)
    assert not np.array_equal(raw.heat, expected.heat)


def test_raw_footage_of_undistorted_cameras_is_never_a_move(core, masks, tmp_path, capsys):
    straight("cam1", "cam2", known=False).save(tmp_path / "network.json")
    words = ["check", str(tmp_path), *masks, *FEW]
    assert main(words) == 2
    printed = capsys.readouterr()
    assert "cam1: the network has it in undistorted pixels" in printed.err
    assert "give --intrinsics FILE.toml" in printed.err
    assert "frames of" not in printed.err
    given = tmp_path / "known.toml"
    write_cameras(given, [lens("cam1")])
    assert main([*words, "--intrinsics", str(given)]) == 2
    assert "cam2: the network has it in undistorted pixels" in capsys.readouterr().err
    write_cameras(given, [lens("cam1"), lens("cam2")])
    assert main([*words, "--intrinsics", str(given)]) == 0
    assert [one["camera"]["distortions"][0] for one in core.cameras] == [0.0, 0.0, -0.22]
    # A recording that was saved without its lens is told as late as it is read.
    saved = []
    for k, path in enumerate(masks):
        matrix = lens("cam1").matrix if k == 0 else None
        film = epibar.record(path, masks=True, lines=50)
        film.matrix = matrix
        (tmp_path / "films").mkdir(exist_ok=True)
        saved.append(str(tmp_path / "films" / f"cam{k + 1}.npz"))
        film.save(saved[-1])
    capsys.readouterr()
    assert main(["check", str(tmp_path), *saved, "--time-offset", "0"]) == 2
    assert "error: cam2: the network has it in undistorted pixels" in capsys.readouterr().err


def test_the_calibration_of_an_older_version_tells_too(core, masks, tmp_path, capsys):
    net = network()
    net.cameras["cam1"] = replace(net.cameras["cam1"], distortions=np.zeros(5))
    net.save(tmp_path / "network.json")
    cameras = [
        {"name": name, "width": 640, "height": 480, "matrix": matrix, "index": k}
        for k, (name, matrix) in enumerate([("cam1", lens("cam1").matrix.tolist()), ("cam2", None)])
    ]
    content = {"format": 1, "cameras": cameras, "pairs": [], "intrinsics": None}
    (tmp_path / "calibration.json").write_text(json.dumps(content))
    assert main(["check", str(tmp_path), *masks, *FEW]) == 2
    assert "cam1: the network has it in undistorted pixels" in capsys.readouterr().err


def test_from_python_too(core):
    net = straight("cam1")
    with pytest.raises(EpibarError, match=r"cam1: .*undistorted.*network\.cameras\['cam1'\]\.lens"):
        net.check(films("cam1", "cam2"), 0.0)
    mine = films("cam1", matrix=lens("cam1").matrix)
    assert net.check({**mine, **films("cam2")}, 0.0).ok


def test_lenses_of_saved_recordings_are_compared(masks, tmp_path, capsys):
    given = tmp_path / "known.toml"
    write_cameras(given, [lens(name) for name in ("cam1", "cam2")])
    saved = []
    for k, path in enumerate(masks[:2]):
        (tmp_path / "films").mkdir(exist_ok=True)
        saved.append(str(tmp_path / "films" / f"cam{k + 1}.npz"))
        words = ["record", path, "--masks", "--lines", "50", "--intrinsics", str(given), "-o", saved[-1]]
        assert main([*words, "-q"]) == 0
    write_cameras(given, [lens("cam1"), lens("cam2", [-0.3, 0.0, 0.0, 0.0])])
    assert main(["inspect", *saved, "--intrinsics", str(given)]) == 3
    printed = capsys.readouterr()
    assert "cam2.npz: recorded with other distortions; record the video again" in printed.err
    assert "taken to be" not in printed.out
