"""Exports of cameras of a run without a network: put into one world, whose poses are those of the scene."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from known_poses import DEGREES, world_error
from pairs_input import write_camera_file, write_run

import epibar
from epibar import export
from epibar.cli import main
from epibar.lens.cameras_toml import load_cameras, write_cameras
from epibar.lens.intrinsics import Intrinsics


@pytest.fixture(scope="module")
def camera_file(tmp_path_factory):
    return write_camera_file(tmp_path_factory.mktemp("cameras") / "cameras.toml")


@pytest.fixture(scope="module")
def folder(recordings, calibrations, camera_file, tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("run"), recordings, calibrations, str(camera_file))


def test_a_chain_of_pairs_is_scaled_by_shared_frontier_points(scene, run):
    chain = run.selected()
    poses, reasons = chain.poses()
    assert reasons == []
    assert len(poses) == 2
    placed = export.place_cameras(chain, poses)
    rotation, direction, distance = world_error(scene, placed, [0, 1, 2])
    assert rotation < DEGREES
    assert direction < DEGREES
    assert distance < 0.02
    R, t = placed["cam3"]
    assert np.linalg.norm(R.T @ t) == pytest.approx(1)  # the first pair is cam1 and cam3


def test_toml_of_a_world(folder, scene, tmp_path):
    out = tmp_path / "placed.toml"
    assert main(["export", str(folder), "--format", "toml", "--out", str(out), "--quiet"]) == 0
    cameras = load_cameras(out)
    assert [camera.name for camera in cameras] == ["cam1", "cam2", "cam3"]
    placed = {camera.name: (camera.posed().R, camera.posed().t) for camera in cameras}
    rotation, direction, distance = world_error(scene, placed, [0, 1, 2])
    assert max(rotation, direction) < DEGREES
    assert distance < 0.02
    assert "[metadata]" in out.read_text()


def test_caliscope_numbers_its_cameras(folder, tmp_path):
    import tomllib

    out = tmp_path / "camera_array.toml"
    assert main(["export", str(folder), "--format", "caliscope", "--out", str(out), "--quiet"]) == 0
    tables = tomllib.loads(out.read_text())["cameras"]
    assert {key: table["cam_id"] for key, table in tables.items()} == {"0": 0, "1": 1, "2": 2}
    assert len(tables["1"]["rotation"]) == 3


def test_pairs_that_make_no_world_go_to_files_of_their_own(
    recordings, calibrations, camera_file, tmp_path, capsys
):
    """Four cameras, the fourth being the first under another name: two pairs with no camera in common."""
    twins = [*recordings, epibar.Recording(recordings[2]._core, name="cam4", matrix=recordings[2].matrix)]
    pairs = {(0, 3): calibrations[0, 2], (1, 2): calibrations[1, 2]}
    folder = write_run(tmp_path / "run", twins, pairs, None)
    known = load_cameras(camera_file)
    path = tmp_path / "four.toml"
    write_cameras(path, [*known, replace(known[2], name="cam4")])
    out = tmp_path / "placed.toml"
    words = ["export", str(folder), "--format", "toml", "--out", str(out), "--intrinsics", str(path)]
    assert main(words) == 0
    assert not out.exists()
    assert "a file for each" in capsys.readouterr().err
    written = load_cameras(tmp_path / "placed_cam1_cam4.toml")
    assert np.linalg.norm(written[1].translation) == pytest.approx(1)
    assert "no chain of pairs" in (tmp_path / "placed_cam2_cam3.toml").read_text()


@pytest.mark.parametrize("kind", ["toml", "caliscope"])
def test_camera_files_need_intrinsics(recordings, calibrations, tmp_path, capsys, kind):
    blind = [epibar.Recording(recording._core, name=recording.name) for recording in recordings]
    folder = write_run(tmp_path / "run", blind, calibrations, None)
    out = tmp_path / "out.toml"
    assert main(["export", str(folder), "--format", kind, "--out", str(out)]) == 2
    assert "--intrinsics" in capsys.readouterr().err
    assert not out.exists()


def test_intrinsics_that_do_not_fit(recordings, calibrations, folder, scene, tmp_path, capsys):
    cameras = [Intrinsics(f"cam{i + 1}", c.size, c.K) for i, c in enumerate(scene.cameras)]
    path = tmp_path / "other.toml"
    blind = [epibar.Recording(recording._core, name=recording.name) for recording in recordings]
    without = write_run(tmp_path / "run", blind, calibrations, None)
    for change, run_folder, words in (
        ({"size": (64, 48)}, folder, "64x48"),
        ({"matrix": cameras[0].matrix * [[2], [2], [1]]}, folder, "another camera matrix"),
        ({"distortions": np.array([0.1, 0, 0, 0, 0])}, without, "lens distortion"),
    ):
        write_cameras(path, [replace(cameras[0], **change), *cameras[1:]])
        out = str(tmp_path / "out.toml")
        code = main(["export", str(run_folder), "--format", "toml", "--out", out, "--intrinsics", str(path)])
        assert code == 2
        assert words in capsys.readouterr().err


def test_cameras_without_a_network_are_placed_for_any_program(folder, scene, tmp_path, capsys):
    """The first camera is the world; its up is that of glTF."""
    json_of = {}
    for name, file in (("pose2sim", "Calib.toml"), ("gltf", "c.gltf"), ("nerfstudio", "transforms.json")):
        out = tmp_path / file
        assert main(["export", str(folder), "--format", name, "--out", str(out)]) == 0
        assert str(out) in capsys.readouterr().out
        json_of[name] = json.loads(out.read_text()) if name != "pose2sim" else None
    cameras = load_cameras(tmp_path / "Calib.toml")
    placed = {camera.name: (camera.posed().R, camera.posed().t) for camera in cameras}
    rotation, direction, _ = world_error(scene, placed, [0, 1, 2])
    assert max(rotation, direction) < DEGREES
    nodes = json_of["gltf"]["nodes"]
    assert nodes[0]["rotation"] == [1, 0, 0, 0]
    assert [node["name"] for node in nodes if "camera" in node] == ["cam1", "cam2", "cam3"]
    assert not any("grid" in node["name"] for node in nodes)
    (frame, *_) = json_of["nerfstudio"]["frames"]
    np.testing.assert_allclose(frame["transform_matrix"], np.diag([1, -1, -1, 1]), atol=1e-12)
    assert main(["export", str(folder), "--format", "easymocap", "--out", str(tmp_path / "data"), "-q"]) == 0
    assert sorted(path.name for path in (tmp_path / "data").iterdir()) == ["extri.yml", "intri.yml"]
    assert capsys.readouterr().err == ""


def test_cameras_of_which_only_the_matrix_is_known_are_said_to_be(recordings, calibrations, scene, tmp_path):
    """Recordings that were saved with intrinsics, in a run that was given none, or those of one camera."""
    folder = write_run(tmp_path / "run", recordings, calibrations, None)
    out = tmp_path / "cameras.toml"
    words = ["export", str(folder), "--format", "anipose", "--out", str(out), "--quiet"]
    for given, told in ((None, ["cam1", "cam2", "cam3"]), ("cam2", ["cam1", "cam3"])):
        if given is not None:
            bent = Intrinsics(given, scene.cameras[1].size, scene.cameras[1].K, [1e-3, 0.0, 0.0, 0.0])
            write_cameras(tmp_path / "one.toml", [bent])
            words += ["--intrinsics", str(tmp_path / "one.toml")]
        assert main(words) == 0
        written = {camera.name: camera for camera in load_cameras(out)}
        assert list(written) == ["cam1", "cam2", "cam3"]
        assert [name for name, camera in written.items() if camera.distorted] == ([given] if given else [])
        notes = tomllib.loads(out.read_text())["metadata"]["notes"]
        assert [note.partition(":")[0] for note in notes if "in undistorted pixels" in note] == told
