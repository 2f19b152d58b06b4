"""Networks from the command line: what is printed and written, and what is never lost."""

import csv
import json
import tomllib
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from network_input import LINES, made_up, situation
from test_report import Page
from test_schema import strict

import epibar
from epibar.cli import main
from epibar.files.calibration_json import schema
from epibar.jobs import network_stage, runner
from epibar.jobs.folder import Folder
from epibar.jobs.network_tables import write_tables
from epibar.lens import Intrinsics, write_cameras
from epibar.network.tracks_csv import load_tracks

WORDS = ["--masks", "--lines", str(LINES), "--no-report"]


@pytest.fixture(scope="module")
def done(masks, tmp_path_factory):
    """A run of three cameras of which nothing is known."""
    out = tmp_path_factory.mktemp("run") / "out"
    assert main(["calibrate", *masks, "--out", str(out), *WORDS, "--quiet"]) == 0
    return out


def read(out):
    return json.loads((out / "calibration.json").read_text())


def test_what_is_written(done):
    result = read(done)
    jsonschema.Draft202012Validator(strict(schema())).validate(result)
    assert result["network_reason"] is None
    network = result["network"]
    assert network["accepted"]
    assert [camera["name"] for camera in network["cameras"]] == ["cam1", "cam2", "cam3"]
    saved = epibar.Network.load(done / "network.json")
    cameras = epibar.load_cameras(done / "cameras.toml")
    for camera in cameras:
        mine = saved.cameras[camera.name]
        np.testing.assert_array_equal(camera.matrix, mine.matrix)
        np.testing.assert_array_equal(camera.distortions, mine.distortions)
        np.testing.assert_allclose(camera.posed().R, mine.rotation, atol=1e-12)
        np.testing.assert_array_equal(camera.posed().t, mine.translation)
    assert all(abs(pair["time_offset"]) < 1 for pair in result["pairs"])


def test_tracks_and_start_times_are_written_kept_and_scaled(masks, again, capsys):
    """They are of this network: kept as long as it is, in its unit, and gone with it."""
    tracks, sync = again / "tracks.csv", again / "sync.csv"
    listed = json.loads((again / ".epibar" / "written.json").read_text())["files"]
    assert {"tracks.csv", "sync.csv"} <= set(listed)
    before = load_tracks(tracks)
    assert (before.names, before.unit) == (("cam1", "cam2", "cam3"), "baseline")
    assert len(before) > 100
    rows = list(csv.DictReader(sync.read_text().splitlines()))
    assert [row["camera"] for row in rows] == ["cam1", "cam2", "cam3"]
    assert all(abs(float(row["offset_seconds"])) < 0.05 and row["command"] == "" for row in rows)
    when = [path.stat().st_mtime_ns for path in (tracks, sync)]
    assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 0
    assert [path.stat().st_mtime_ns for path in (tracks, sync)] == when
    assert "tracks.csv" in capsys.readouterr().err.splitlines()[-1]
    height = epibar.Network.load(again / "network.json").ground.height
    assert main(["scale", str(again), "--person-height", "1.72", "--quiet"]) == 0
    after = load_tracks(tracks)
    assert after.unit == "metre"
    np.testing.assert_allclose(after.top, before.top * 1.72 / height, atol=2e-3)
    assert main(["sync", str(again), "--json"]) == 0
    starts = json.loads(capsys.readouterr().out)["cameras"]
    assert [one["first_frame"] for one in starts] == [int(row["first_frame"]) for row in rows]
    # Another network, in metres from the start: its own tables.
    words = ["--person-height", "1.6", "--quiet"]
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, *words]) == 0
    assert load_tracks(tracks).unit == "metre"
    assert main(["calibrate", *masks, "--out", str(again), *WORDS, "--method", "lines", "--quiet"]) == 0
    assert not tracks.exists()
    assert not sync.exists()


def test_a_table_that_cannot_be_made_is_told_of(tmp_path):
    """Where there can be none nothing is said; else why, and the rest is written."""
    random = np.random.default_rng(0)
    films = {
        f"cam{k + 1}": epibar.Recording.from_masks(random.random((frames, 48, 64)) < 0.1, lines=50)
        for k, frames in enumerate((40, 40, 10, 10))
    }
    sources = dict.fromkeys(films, "masks.npz")
    with Folder(tmp_path) as folder:
        one = made_up(refused=("cam2", "cam3"))
        assert write_tables(folder, one, films, sources) == ([], [])
        apart = made_up(lost=(), refused=(), floor=False)
        there, (told,) = write_tables(folder, apart, films, sources)
        assert there == []
        assert "sync.csv: not written: no moment is common" in told
        there, (told,) = write_tables(folder, made_up(), films, sources)
        assert there == [tmp_path / "sync.csv"]
        assert "tracks.csv: not written: cam1: 64x48 frames" in told


def test_tables_of_the_user_are_refused(masks, tmp_path, capsys):
    (tmp_path / "tracks.csv").write_text("mine")
    assert main(["calibrate", *masks, "--out", str(tmp_path), *WORDS]) == 2
    assert "not written by epibar" in capsys.readouterr().err
    assert (tmp_path / "tracks.csv").read_text() == "mine"


def test_a_second_run_does_nothing(masks, again, capsys):
    before = (again / "calibration.json").read_bytes()
    assert main(["calibrate", *masks, "--out", str(again), *WORDS]) == 0
    printed = capsys.readouterr()
    assert (again / "calibration.json").read_bytes() == before
    assert "3 of 3 recordings, 3 of 3 pairs" in printed.err
    assert printed.out.splitlines()[-1] == "network: all 3 cameras are calibrated"
    assert "cam2    accepted" in printed.out
    assert "they were found with the network" in printed.err
    assert "accepted: 3 of 3 cameras" in printed.err.splitlines()[-1]
    assert "cameras.toml" in printed.err.splitlines()[-1]


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


def test_the_report_has_the_network_and_its_walkers(masks, again, capsys):
    words = ["calibrate", *masks, "--out", str(again), *WORDS[:-1], "--quiet"]
    assert main(words) == 0
    space = Page(again / "report.html").data["space"]
    assert [camera["name"] for camera in space["cameras"]] == ["cam1", "cam2", "cam3"]
    tracks = load_tracks(again / "tracks.csv")
    assert len(space["tracks"]) >= len(np.unique(tracks.track)) > 0
    place = np.array(space["tracks"][0][0])
    assert np.abs(tracks.foot - place).max(axis=1).min() < 2e-3
    scene = again / "scene.gltf"
    export = ["export", str(again), "--format", "gltf", "--out", str(scene)]
    assert main(export) == 0
    names = [node["name"] for node in json.loads(scene.read_text())["nodes"]]
    ways = [way for way in tracks.ways() if len(way.time) > 1]
    assert {way.name for way in ways} == {
        name for name in names if name.startswith("walker") and not name.endswith("moving")
    }
    tracks.scaled(1.0, "metre").save(again / "tracks.csv")  # by hand: the network is in baselines
    capsys.readouterr()
    assert main(export) == 0
    assert "tracks.csv is in metres, and the network in baselines" in capsys.readouterr().err
    assert "animations" not in json.loads(scene.read_text())
    (again / "tracks.csv").write_text("something else\n")
    assert main(export) == 0
    assert "without walkers" in capsys.readouterr().err
    assert "animations" not in json.loads(scene.read_text())
    assert main(words) == 0
    page = Page(again / "report.html")
    assert page.data["space"]["tracks"] == []
    assert "tracks.csv: no table of tracks" in "".join(page.text)


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


def test_two_cameras_of_unknown_lens(masks, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["calibrate", *masks[:2], "--out", str(out), *WORDS]) == 0
    printed = capsys.readouterr()
    assert "no network of cameras: two cameras" in printed.err
    assert "without a lens model" in printed.err
    assert "accepted: 1 of 1 pairs" in printed.err.splitlines()[-1]
    result = read(out)
    assert result["network"] is None
    assert "two cameras" in result["network_reason"]
    assert result["pairs"][0]["F"] is not None
    assert not (out / "network.json").exists()
    assert not (out / "cameras.toml").exists()


def test_two_cameras_with_intrinsics(masks, tmp_path):
    """The lens of the intrinsics is in cameras.toml again, for what is filmed with it."""
    known = [
        Intrinsics(f"cam{k + 1}", camera.size, camera.K, np.array([1e-9, 0, 0, 0, 0]))
        for k, camera in enumerate(situation().cameras[:2])
    ]
    write_cameras(tmp_path / "known.toml", known)
    out = tmp_path / "out"
    words = ["--intrinsics", str(tmp_path / "known.toml"), "--quiet"]
    assert main(["calibrate", *masks[:2], "--out", str(out), *WORDS, *words]) == 0
    network = read(out)["network"]
    assert network["accepted"], network["reason"]
    assert network["cameras"][0]["distortions"] == [0] * 5
    written = epibar.load_cameras(out / "cameras.toml")
    assert written[0].distortions[0] == 1e-9
    np.testing.assert_allclose(written[1].matrix, known[1].matrix)


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


def test_one_at_a_time_scales_a_network(again, capsys):
    with Folder(again):
        assert main(["scale", str(again), "--person-height", "1.6"]) == 2
    assert "at work" in capsys.readouterr().err


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


def test_a_length_counts_on_until_it_is_forgotten(again, capsys):
    scale = ["scale", str(again)]
    assert main([*scale, "--distance", "cam1", "cam2", "4.2", "--quiet"]) == 0
    assert main([*scale, "--distance", "cam1", "cam3", "40"]) == 2
    assert "contradict each other" in capsys.readouterr().err
    kept = epibar.Network.load(again / "network.json").scale
    assert len(kept.lengths) == 1
    assert main([*scale, "--distance", "cam1", "cam3", "40", "--forget", "--quiet"]) == 0
    assert "40 m between cam1 and cam3" in " ".join(epibar.Network.load(again / "network.json").scale.sources)


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


def test_a_camera_that_cannot_be_recorded(masks, again, capsys):
    words = ["calibrate", *masks, "none.npz", "--out", str(again), *WORDS]
    assert main(words) == 3
    network = read(again)["network"]
    assert [camera["name"] for camera in network["cameras"]] == ["cam1", "cam2", "cam3"]
    assert "accepted: 3 of 4 cameras" in capsys.readouterr().err.splitlines()[-1]


def test_of_many_cameras_only_likely_pairs_are_searched(masks, tmp_path, monkeypatch, capsys):
    """Seven names for three cameras' masks, few lines: which pairs are searched, not how good they are."""

    def refused(*_):
        raise epibar.EpibarError("not here")

    def quick(a, b, *_):
        return replace(epibar.calibrate(a, b, method="lines", draws=100), method="frontier"), 0.0

    monkeypatch.setattr(runner, "join_cameras", refused)
    monkeypatch.setattr(runner, "calibrate_pair", quick)
    paths = []
    for k in range(7):
        with np.load(masks[k % 3]) as archive:
            paths.append(str(tmp_path / f"view{k}.npz"))
            np.savez_compressed(paths[-1], masks=archive["masks"][:60, ::4, ::4], fps=archive["fps"])
    words = ["--masks", "--lines", "200", "--no-report", "--time-offset", "0"]
    assert main(["calibrate", *paths, "--out", str(tmp_path / "out"), *words]) == 3  # for the network
    printed = capsys.readouterr()
    result = read(tmp_path / "out")
    searched = len(result["pairs"])
    assert searched < 21
    assert f"{searched} of 21 pairs are searched" in printed.err
    assert f"accepted: 0 of {searched} pairs" in printed.err.splitlines()[-1]
    assert len({name for pair in result["pairs"] for name in (pair["a"], pair["b"])}) == 7
    assert "not here" in result["network_reason"]
