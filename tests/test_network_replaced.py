"""A folder that has a network already: what another run or ``scale`` leaves of it, and what is said."""

import dataclasses
import json

import numpy as np
import pytest
from network_input import LINES

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.jobs import runner
from epibar.network import NetworkClock
from epibar.network.extending import Extension, with_added
from epibar.network.tracks_csv import load_tracks
from epibar.network.walkers import WalkerTracks

WORDS = ["--masks", "--lines", str(LINES), "--no-report"]
TAPE = ["--distance", "cam1", "cam2", "4.2"]


@pytest.fixture(scope="module")
def done(masks, tmp_path_factory):
    """A run of three cameras of which nothing is known, scaled by a distance."""
    out = tmp_path_factory.mktemp("run") / "out"
    assert main(["calibrate", *masks, "--out", str(out), *WORDS, "--quiet"]) == 0
    assert main(["scale", str(out), *TAPE, "--quiet"]) == 0
    return out


def written(out):
    names = ("network.json", "cameras.toml", "tracks.csv", "calibration.json")
    return {name: (out / name).read_bytes() for name in names}


def heights(out):
    """How tall people are by each file that says so."""
    told = json.loads((out / "calibration.json").read_text())["network"]["ground"]["height"]
    tracks = load_tracks(out / "tracks.csv")
    return epibar.Network.load(out / "network.json").ground.height, told, float(np.median(tracks.height))


def test_scale_writes_all_or_none(again, monkeypatch, capsys):
    before = written(again)

    def full(*_):
        raise EpibarError("tracks.csv: cannot be written (No space left on device)")

    words = ["scale", str(again), "--distance", "cam1", "cam2", "20", "--forget", "--quiet"]
    with monkeypatch.context() as patched:
        patched.setattr(WalkerTracks, "save", full)
        assert main(words) == 2
    assert "No space left" in capsys.readouterr().err
    assert written(again) == before
    assert main(words) == 0
    known, told, tall = heights(again)
    assert known == pytest.approx(told)
    assert tall == pytest.approx(known, rel=0.02)


def test_a_slip_of_a_unit_costs_no_digits(again):
    tall = load_tracks(again / "tracks.csv").top
    assert (
        main(["scale", str(again), "--distance", "cam1", "cam2", "0.042+-0.001", "--forget", "--quiet"]) == 0
    )
    assert main(["scale", str(again), *TAPE, "--forget", "--quiet"]) == 0
    np.testing.assert_allclose(load_tracks(again / "tracks.csv").top, tall, atol=1e-3)


def test_the_same_again_says_which_lengths_it_does_without(masks, again, capsys):
    assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 0
    err = capsys.readouterr().err
    assert "made anew, without the distance of 4.2 m between cam1 and cam2" in err
    assert epibar.Network.load(again / "network.json").unit == "baseline"
    assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 0
    assert "made anew" not in capsys.readouterr().err


def test_the_same_again_names_cameras_that_were_added(masks, again, capsys):
    file = again / "network.json"
    net = epibar.Network.load(file)
    first = net.cameras["cam1"]
    ninth = dataclasses.replace(first, name="cam9", translation=np.add(first.translation, [0.1, 0, 0]))
    with_added(net, Extension(net, {"cam9": ninth}, {"cam9": NetworkClock(0.0, 0.0, 0.0)})).save(file)
    assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 0
    err = capsys.readouterr().err
    assert "network.json: made anew, without cam9; 'epibar check --update' adds a camera again" in err
    assert list(epibar.Network.load(file).cameras) == list(net.cameras)


def test_a_network_that_cannot_be_made_is_an_error(masks, again, monkeypatch, capsys):
    def lost(*_):
        raise EpibarError("the worker was lost")

    monkeypatch.setattr(runner, "join_cameras", lost)
    words = ["calibrate", *masks, "--out", str(again), *WORDS, "--person-height", "1.7"]
    assert main(words) == 3
    err = capsys.readouterr().err
    assert "the worker was lost" in err
    assert "network.json: the network of an earlier run is removed" in err
    result = json.loads((again / "calibration.json").read_text())
    assert "the worker was lost" in result["network_reason"]
    assert len(result["pairs"]) == 3


def test_where_no_two_cameras_can_be_read_the_earlier_run_stays(masks, again, capsys):
    before = written(again)
    words = ["calibrate", masks[0], "none2.npz", "none3.npz", "--out", str(again), *WORDS]
    assert main(words) == 2
    assert "stays as it is" in capsys.readouterr().err
    assert written(again) == before


def test_recordings_of_a_run_that_was_interrupted_are_not_taken_for_those_of_the_network(again, capsys):
    path = again / "recordings" / "cam2.npz"
    recording = epibar.Recording.load(path)
    recording.first_frame = 250
    recording.save(path)
    assert main(["sync", str(again)]) == 2
    assert "cam2.npz is of another run than" in capsys.readouterr().err


def test_lenses_of_somebody_else_are_not_ignored(again, tmp_path, capsys):
    words = ["export", str(again), "--format", "anipose", "--out", str(tmp_path / "cameras.toml")]
    assert main([*words, "--intrinsics", "none.toml"]) == 2
    assert "was made without intrinsics" in capsys.readouterr().err
    assert main([*words, "--quiet"]) == 0
