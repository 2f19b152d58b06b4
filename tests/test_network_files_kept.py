"""Files of a network from the command line: what is never lost, never replaced, and what is made again."""

import json
from pathlib import Path

import pytest
from network_input import WORDS, read

import epibar
from epibar.cli import main
from epibar.jobs import network_stage, runner
from epibar.lens import Intrinsics, write_cameras
from epibar.network.tracks_csv import load_tracks


@pytest.fixture(scope="module")
def done(network_run):
    return network_run


def test_tables_of_the_user_are_refused(masks, tmp_path, capsys):
    (tmp_path / "tracks.csv").write_text("mine")
    assert main(["calibrate", *masks, "--out", str(tmp_path), *WORDS]) == 2
    assert "not written by epibar" in capsys.readouterr().err
    assert (tmp_path / "tracks.csv").read_text() == "mine"


def test_a_camera_file_of_the_user_stays(masks, again, capsys):
    path = again / "cameras.toml"
    write_cameras(path, [Intrinsics("mine", (64, 48), [[50, 0, 32], [0, 50, 24], [0, 0, 1]])])
    mine = path.read_bytes()
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, "--person-height", "1.7"]) == 0
    assert path.read_bytes() == mine
    told = capsys.readouterr().err
    assert "stays as it is" in told
    assert "cameras.toml" not in told.splitlines()[-1]


def test_a_camera_file_that_was_exported_stays(masks, again, capsys):
    """The list of what runs wrote decides, not only what the file says of itself."""
    path = again / "cameras.toml"
    listed = json.loads((again / ".epibar" / "written.json").read_text())
    assert {"network.json", "cameras.toml", "recordings/clocks.json"} <= set(listed["files"])
    listed["files"].remove("cameras.toml")
    (again / ".epibar" / "written.json").write_text(json.dumps(listed))
    mine = path.read_bytes()
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, "--person-height", "1.7"]) == 0
    assert main(["scale", str(again), "--person-height", "1.6"]) == 0
    assert path.read_bytes() == mine
    assert capsys.readouterr().err.count("stays as it is") == 2


def test_a_network_of_a_stranger_in_the_folder_is_refused(masks, tmp_path, capsys):
    (tmp_path / "network.json").write_text("mine")
    assert main(["calibrate", *masks, "--out", str(tmp_path), *WORDS]) == 2
    assert "not written by epibar" in capsys.readouterr().err
    assert (tmp_path / "network.json").read_text() == "mine"


@pytest.mark.parametrize("text", ["{", "[]", "[" * 100_000])
def test_kept_files_that_are_damaged_are_made_again(text, masks, again):
    before = (again / "calibration.json").read_bytes()
    (again / "network.json").write_text(text)
    (again / "recordings" / "clocks.json").write_text(text)
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, "--quiet"]) == 0
    assert (again / "calibration.json").read_bytes() == before


def test_files_of_a_network_that_is_no_more_are_removed(masks, again):
    words = ["--method", "lines", "--quiet"]
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, *words]) == 0
    assert not (again / "network.json").exists()
    assert not (again / "cameras.toml").exists()
    assert "frontier points" in read(again)["network_reason"]


@pytest.mark.parametrize("stage", ["find_clocks", "join_cameras"])
def test_a_failure_loses_no_pair(stage, masks, again, monkeypatch, capsys):
    """A bug is raised when all else is written; what was finished stays."""

    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr(runner, stage, broken)
    monkeypatch.setattr(network_stage, stage, broken)
    (again / "recordings" / "clocks.json").unlink()
    words = ["calibrate", *masks, "--out", str(again), *WORDS, "--person-height", "1.7"]
    with pytest.raises(RuntimeError, match="broken"):
        main(words)
    assert "broken" in capsys.readouterr().err
    result = read(again)
    assert result["network"] is None
    assert "broken" in result["network_reason"]
    assert len(result["pairs"]) == (3 if stage == "join_cameras" else 0)
    monkeypatch.undo()
    assert main([*words, "--quiet"]) == 0
    assert read(again)["network"]["accepted"]


def test_a_network_that_cannot_be_written_is_an_error(masks, again, capsys):
    """What is still of an earlier one is named."""
    assert main(["scale", str(again), "--distance", "cam1", "cam2", "4.2", "--quiet"]) == 0
    (again / "network.json").unlink()
    (again / "network.json").mkdir()
    assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 3
    err = capsys.readouterr().err
    assert "network.json: cannot be written" in err
    assert "of an earlier run: cameras.toml" in err
    assert read(again)["network"]["unit"] == "baseline"
    (again / "network.json").rmdir()
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, "--quiet"]) == 0
    assert epibar.Network.load(again / "network.json").unit == "baseline"


def test_a_table_that_cannot_be_removed_is_never_taken_for_the_new_networks(
    masks, again, capsys, monkeypatch
):
    assert main(["scale", str(again), "--distance", "cam1", "cam2", "4.2", "--quiet"]) == 0
    unlink = Path.unlink

    def held(path, missing_ok=False):
        if path.name == "tracks.csv":
            raise PermissionError(13, "in use")
        unlink(path, missing_ok=missing_ok)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", held)
        assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 3
    assert "tracks.csv: cannot be removed (in use)" in capsys.readouterr().err
    assert epibar.Network.load(again / "network.json").unit == "baseline"
    assert load_tracks(again / "tracks.csv").unit == "metre"
    assert not (again / "sync.csv").exists()
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, "--quiet"]) == 0
    assert load_tracks(again / "tracks.csv").unit == "baseline"
    assert (again / "sync.csv").exists()
