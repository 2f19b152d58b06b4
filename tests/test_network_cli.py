"""Networks from the command line: what is printed and written."""

import csv
import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from network_input import WORDS, made_up, read, situation
from test_report import Page
from test_schema import strict

import epibar
from epibar.cli import main
from epibar.files.calibration_json import schema
from epibar.jobs import runner
from epibar.jobs.folder import Folder
from epibar.jobs.network_tables import write_tables
from epibar.lens import Intrinsics, write_cameras
from epibar.network.prose import network_table
from epibar.network.tracks_csv import load_tracks


@pytest.fixture(scope="module")
def done(network_run):
    return network_run


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
    # A focal length that was given is not found to be right to 0 %.
    for row in network_table(epibar.Network.load(out / "network.json"))[1:]:
        assert "given, " in row
        assert "0 %" not in row
    assert "with the focal length that is given" in network["cameras"][0]["reason"]


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
