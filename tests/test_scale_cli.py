"""Metres from the command line: lengths that are given, combined, contradict each other or are forgotten."""

import json
import tomllib

import numpy as np
import pytest
from network_input import WORDS, made_up, read

import epibar
from epibar.cli import main
from epibar.jobs.folder import Folder
from epibar.outcome.run import Run


@pytest.fixture(scope="module")
def done(network_run):
    return network_run


def test_metres(masks, again, capsys):
    words = ["--person-height", "1.75", "--distance", "cam1", "cam2", "13.50+-0.03"]
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, *words]) == 0
    printed = capsys.readouterr()
    net = epibar.Network.load(again / "network.json")
    assert net.unit == "metre"
    one, other = net.cameras["cam1"].position, net.cameras["cam2"].position
    assert np.linalg.norm(one - other) == pytest.approx(13.5, rel=0.005)
    assert read(again)["network"]["unit"] == "metre"
    assert tomllib.loads((again / "cameras.toml").read_text())["metadata"]["unit"] == "metre"
    assert "13.5 m between cam1 and cam2" in printed.err


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--distance", "cam1", "cam2", "5"], 1.645 * 0.01),
        (["--distance", "cam1", "cam2", "5.00+-0.01"], 1.645 * 0.002),
        (["--distance", "cam1", "cam2", "5.00±0.01"], 1.645 * 0.002),
        (["--camera-height", "cam1", "2.6+-0.26"], 1.645 * 0.1),
        (["--person-height", "1.75±0.35"], 1.645 * 0.2),
        (["--person-height", "1.75"], 1.645 * 0.03),
    ],
)
def test_lengths_are_as_good_as_it_is_said(words, error, again):
    made_up(3, refused=(), lost=()).save(again / "network.json")
    assert main(["scale", str(again), *words, "--quiet"]) == 0
    # What the network itself is wrong by comes on top.
    assert epibar.Network.load(again / "network.json").scale.error == pytest.approx(error, rel=0.1)


def test_a_contradiction_is_one_by_what_is_said_of_the_lengths(again, capsys):
    """5 m between the first two cameras are people of 1.01 m; 1.10 m is wrong if it is known well."""
    made_up(3, refused=(), lost=()).save(again / "network.json")
    words = ["scale", str(again), "--distance", "cam1", "cam2", "5.00+-0.01", "--person-height"]
    assert main([*words, "1.10+-0.02"]) == 2
    assert "people contradict each other: they differ by" in capsys.readouterr().err
    assert epibar.Network.load(again / "network.json").unit == "baseline"
    assert main([*words, "1.10+-0.1"]) == 0


def test_lengths_that_contradict_lose_nothing(masks, again, capsys):
    words = ["--distance", "cam1", "cam2", "13.5", "--distance", "cam1", "cam3", "1"]
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, *words]) == 0
    printed = capsys.readouterr()
    assert "not in metres: " in printed.out
    assert "contradict each other" in printed.out
    assert read(again)["network"]["unit"] == "baseline"


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--distance", "cam1", "cam9", "4.2"], "cam9"),
        (["--distance", "cam1", "cam2", "far"], "--distance: 'far' is not a positive number of metres"),
        (["--distance", "cam1", "cam2", "4.2+-"], "such as 4.20, or 4.20+-0.01"),
        (["--distance", "cam1", "cam2", "4.2±0"], "such as 4.20, or 4.20+-0.01"),
        (["--camera-height", "cam1", "2.6+-0.1+-0.1"], "--camera-height: '2.6+-0.1+-0.1'"),
        (["--camera-height", "cam1", "2.6+-260"], "less than the length itself"),
        (["--person-height", "1.75+-tall"], "--person-height: '1.75+-tall'"),
        (["--distance", "cam1", "cam2"], "--distance"),
        (["--person-height", "-1"], "--person-height"),
        (["--camera-height", "cam9", "2"], "cam9"),
    ],
)
def test_bad_lengths(words, named, masks, tmp_path, capsys):
    assert main(["calibrate", *masks, "--out", str(tmp_path / "out"), *WORDS, *words]) == 2
    assert named in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_one_at_a_time_scales_a_network(again, capsys):
    with Folder(again):
        assert main(["scale", str(again), "--person-height", "1.6"]) == 2
    assert "at work" in capsys.readouterr().err


def test_a_length_counts_on_until_it_is_forgotten(again, capsys):
    scale = ["scale", str(again)]
    assert main([*scale, "--distance", "cam1", "cam2", "4.2", "--quiet"]) == 0
    assert main([*scale, "--distance", "cam1", "cam3", "40"]) == 2
    assert "contradict each other" in capsys.readouterr().err
    kept = epibar.Network.load(again / "network.json").scale
    assert len(kept.lengths) == 1
    assert main([*scale, "--distance", "cam1", "cam3", "40", "--forget", "--quiet"]) == 0
    assert "40 m between cam1 and cam3" in " ".join(epibar.Network.load(again / "network.json").scale.sources)


@pytest.mark.parametrize(
    "command", [["scale", "--distance", "cam1", "cam2", "5"], ["sync"], ["export", "--format", "anipose"]]
)
def test_a_network_of_an_earlier_run_is_not_taken_for_this_one(command, again, capsys):
    result, network = again / "calibration.json", again / "network.json"
    told = read(again)
    told["network"], told["network_reason"] = None, "the run was not finished"
    result.write_text(json.dumps(told))
    before = network.read_bytes(), result.read_bytes()
    verb, *words = command
    out = ["--out", str(again.parent / "cameras.toml")] if verb == "export" else []
    assert main([verb, str(again), *words, *out]) == 2
    assert "is of an earlier run than" in (error := capsys.readouterr().err)
    assert "which has no network: the run was not finished; 'epibar calibrate'" in error
    assert (network.read_bytes(), result.read_bytes()) == before


def test_a_file_in_the_folder_stands_for_it(again, capsys):
    made_up(3, refused=(), lost=()).save(again / "network.json")
    for name in ("network.json", "calibration.json"):
        assert main(["scale", str(again / name), "--distance", "cam1", "cam2", "5", "--quiet"]) == 0
        assert main(["sync", str(again / name)]) == 0
    assert epibar.Network.load(again / "network.json").unit == "metre"
    capsys.readouterr()
    assert main(["sync", str(again / "report.html")]) == 2
    assert "report.html" in capsys.readouterr().err


def test_a_network_is_not_called_a_damaged_calibration(tmp_path):
    made_up(3, refused=(), lost=()).save(tmp_path / "network.json")
    with pytest.raises(epibar.EpibarError, match=r"network.json: a network by itself.*give calibration.json"):
        Run.load(tmp_path / "network.json")
