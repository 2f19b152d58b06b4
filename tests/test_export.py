"""Exports of pairs: each file is read back by the tool it is for, and what a run must be for that."""

import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
from known_poses import DEGREES, angle, between, true_pose
from pairs_input import write_camera_file, write_run

import epibar
from epibar import export
from epibar.cli import main
from epibar.lens.intrinsics import Intrinsics


@pytest.fixture(scope="module")
def folder(recordings, calibrations, tmp_path_factory):
    known = write_camera_file(tmp_path_factory.mktemp("cameras") / "cameras.toml")
    return write_run(tmp_path_factory.mktemp("run"), recordings, calibrations, str(known))


def test_opencv_reads_its_file(folder, calibrations, tmp_path, capsys):
    out = tmp_path / "pairs.yml"
    assert main(["export", str(folder), "--format", "opencv", "--out", str(out)]) == 0
    assert "1 of 3 pairs, not accepted" in capsys.readouterr().err
    storage = cv2.FileStorage(str(out), cv2.FILE_STORAGE_READ)
    pairs = storage.getNode("pairs")
    assert pairs.size() == 2
    pair = pairs.at(0)
    assert (pair.getNode("a").string(), pair.getNode("b").string()) == ("cam1", "cam3")
    assert int(pair.getNode("accepted").real()) == 1
    assert pair.getNode("reason").string() == calibrations[0, 2].reason
    np.testing.assert_array_equal(pair.getNode("F").mat(), calibrations[0, 2].F)
    points = calibrations[0, 2].frontier_points
    a, b = pair.getNode("points_a").mat(), pair.getNode("points_b").mat()
    np.testing.assert_allclose(a, points.a, atol=1e-3)
    distance = epibar.symmetric_epipolar_distance(pair.getNode("F").mat(), a, b)
    np.testing.assert_allclose(distance, points.residual, atol=1e-3)
    R, t = pair.getNode("R").mat(), pair.getNode("t").mat().ravel()
    np.testing.assert_allclose(np.cross(np.eye(3), t) @ R, pair.getNode("E").mat(), atol=1e-9)
    storage.release()


def test_npz(folder, calibrations, scene, tmp_path):
    out = tmp_path / "pairs.npz"
    given = str(folder / "calibration.json")  # as good as the folder
    assert main(["export", given, "--format", "npz", "--out", str(out), "--all", "--quiet"]) == 0
    with np.load(out, allow_pickle=False) as found:
        assert found["cameras"].tolist() == ["cam1", "cam2", "cam3"]
        assert found["sizes"].tolist() == [list(camera.size) for camera in scene.cameras]
        assert found["pairs"].tolist() == [[0, 1], [0, 2], [1, 2]]
        assert found["accepted"].tolist() == [False, True, True]
        assert found["kind"].tolist() == ["no_common_scene", "accepted", "accepted"]
        for row, calibration in enumerate(calibrations.values()):
            mine = found["point_pair"] == row
            np.testing.assert_array_equal(found["F"][row], calibration.F)
            np.testing.assert_array_equal(found["frame_a"][mine], calibration.frontier_points.frame)
            np.testing.assert_allclose(found["points_b"][mine], calibration.frontier_points.b, atol=1e-3)
        R, t = true_pose(scene.cameras[1], scene.cameras[2])
        assert angle(found["R"][2], R) < DEGREES
        assert between(found["t"][2], t) < DEGREES


def test_a_camera_file_by_place_counts_cameras_that_failed():
    matrices = [[[f, 0, 32], [0, f, 24], [0, 0, 1]] for f in (50.0, 60.0, 70.0)]
    known = [Intrinsics(f"port {k}", (64, 48), matrix) for k, matrix in enumerate(matrices)]
    left = export.Run([export.Camera("b", (64, 48), index=1), export.Camera("c", (64, 48), index=2)], [])
    given = left.with_intrinsics(known, "cameras.toml").cameras
    assert [camera.matrix[0, 0] for camera in given] == [60.0, 70.0]


def test_csv_keeps_the_verdict(run, calibrations, tmp_path):
    pairs = [replace(pair, time_offset=7.0) for pair in run.pairs]
    export.write_csv(replace(run, pairs=pairs).selected(every=True), tmp_path / "points.csv")
    table = np.genfromtxt(tmp_path / "points.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert len(table) == sum(len(calibration.frontier_points) for calibration in calibrations.values())
    assert set(table["verdict"]) == {"accepted", "no_common_scene"}
    mine = table[(table["a"] == "cam2") & (table["b"] == "cam3")]
    points = calibrations[1, 2].frontier_points
    np.testing.assert_array_equal(mine["frame_b"], points.frame + 7)
    np.testing.assert_allclose(np.column_stack([mine["x_b"], mine["y_b"]]), points.b, atol=1e-3)


def test_colmap_reads_its_database(folder, calibrations, scene, tmp_path):
    pycolmap = pytest.importorskip("pycolmap")
    out = tmp_path / "database.db"
    assert main(["export", str(folder), "--format", "colmap", "--out", str(out), "--quiet"]) == 0
    database = pycolmap.Database.open(out)
    images = {image.name: image for image in database.read_all_images()}
    assert set(images) == {"cam1", "cam2", "cam3"}
    assert database.num_verified_image_pairs() == 2
    for index, name in enumerate(sorted(images)):
        camera = database.read_camera(images[name].camera_id)
        assert (camera.width, camera.height) == scene.cameras[index].size
        assert camera.has_prior_focal_length
        # Pixel centres are at a half there.
        shifted = scene.cameras[index].K + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
        np.testing.assert_allclose(camera.calibration_matrix(), shifted)
    for i, j in ((0, 2), (1, 2)):
        first, second = images[f"cam{i + 1}"].image_id, images[f"cam{j + 1}"].image_id
        geometry = database.read_two_view_geometry(first, second)
        assert geometry.config == pycolmap.TwoViewGeometryConfiguration.CALIBRATED
        match = geometry.inlier_matches
        a = database.read_keypoints(first)[match[:, 0], :2].astype(float)
        b = database.read_keypoints(second)[match[:, 1], :2].astype(float)
        points = calibrations[i, j].frontier_points
        moments = np.column_stack([points.frame, points.a, points.b])
        assert len(match) == len(np.unique(moments, axis=0))
        assert {tuple(p) for p in np.hstack([a, b]) - 0.5} == {tuple(p) for p in moments[:, 1:]}
        distance = epibar.symmetric_epipolar_distance(geometry.F, a, b)
        assert distance.mean() == pytest.approx(points.residual.mean(), rel=0.02)
        R, t = true_pose(scene.cameras[i], scene.cameras[j])
        pose = geometry.cam2_from_cam1
        assert angle(pose.rotation.matrix(), R) < DEGREES
        assert between(pose.translation, t) < DEGREES
    # A corner that two pairs use is one keypoint.
    third = database.num_keypoints_for_image(images["cam3"].image_id)
    assert third < sum(len(calibrations[pair].frontier_points) for pair in ((0, 2), (1, 2)))
    database.close()


def test_colmap_places_the_cameras_from_its_database(run, scene, tmp_path):
    pycolmap = pytest.importorskip("pycolmap")
    export.write_colmap(run.selected(), tmp_path / "database.db")
    (tmp_path / "images").mkdir()
    options = pycolmap.IncrementalPipelineOptions()
    options.min_model_size = 3
    options.extract_colors = False
    options.ba_refine_focal_length = False
    models = pycolmap.incremental_mapping(
        tmp_path / "database.db", tmp_path / "images", tmp_path / "model", options
    )
    centres = {image.name: image.projection_center() for image in models[0].images.values()}
    assert sorted(centres) == ["cam1", "cam2", "cam3"]
    true = {f"cam{index + 1}": camera.centre for index, camera in enumerate(scene.cameras)}

    def shape(places):
        sides = [np.linalg.norm(places[a] - places[b]) for a, b in (("cam1", "cam3"), ("cam1", "cam2"))]
        return sides[1] / sides[0]

    assert shape(centres) == pytest.approx(shape(true), rel=0.01)


def test_colmap_without_intrinsics_has_no_prior(run, tmp_path):
    pycolmap = pytest.importorskip("pycolmap")
    cameras = [replace(camera, matrix=None) for camera in run.cameras]
    blind = replace(run, cameras=cameras).selected(every=True)
    export.write_colmap(blind, tmp_path / "database.db")
    database = pycolmap.Database.open(tmp_path / "database.db")
    assert [camera.has_prior_focal_length for camera in database.read_all_cameras()] == [False] * 3
    ids = {image.name: image.image_id for image in database.read_all_images()}
    kinds = pycolmap.TwoViewGeometryConfiguration
    assert database.read_two_view_geometry(ids["cam1"], ids["cam3"]).config == kinds.UNCALIBRATED
    refused = database.read_two_view_geometry(ids["cam1"], ids["cam2"])
    assert refused.config == kinds.UNDEFINED
    assert refused.F is not None
    database.close()


def test_a_run_without_an_accepted_pair(recordings, calibrations, tmp_path, capsys):
    folder = write_run(tmp_path / "run", recordings, {(0, 1): calibrations[0, 1]}, None)
    words = ["export", str(folder), "--format", "csv", "--out", str(tmp_path / "out.csv")]
    assert main(words) == 2
    assert "--all" in capsys.readouterr().err
    assert main([*words, "--all"]) == 0


def test_a_pair_without_f(recordings, calibrations, tmp_path):
    none = epibar.FrontierPoints(np.empty(0, int), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
    empty = replace(calibrations[0, 1], F=None, expected_error=None, frontier_points=none)
    folder = write_run(tmp_path / "run", recordings, {(0, 1): empty}, None)
    for kind in ("opencv", "npz", "csv", "colmap"):
        if kind == "colmap":
            pytest.importorskip("pycolmap")
        out = tmp_path / f"out.{kind}"
        assert main(["export", str(folder), "--format", kind, "--out", str(out), "--all", "--quiet"]) == 0
    storage = cv2.FileStorage(str(tmp_path / "out.opencv"), cv2.FILE_STORAGE_READ)
    assert storage.getNode("pairs").at(0).getNode("F").empty()
    storage.release()
    assert np.isnan(np.load(tmp_path / "out.npz")["F"]).all()


def test_damaged_runs_are_named(folder, tmp_path, capsys):
    words = ["export", str(tmp_path / "copy"), "--format", "csv", "--out", str(tmp_path / "out.csv")]
    assert main(words) == 2
    assert "calibration.json" in capsys.readouterr().err
    for damage in ({"F": [[1, 2], [3, 4]]}, {"a": "nobody"}, {"kind": None, "time_offset": "soon"}):
        shutil.rmtree(tmp_path / "copy", ignore_errors=True)
        shutil.copytree(folder, tmp_path / "copy")
        file = tmp_path / "copy" / "calibration.json"
        result = json.loads(file.read_text())
        result["pairs"][0].update(damage)
        file.write_text(json.dumps(result))
        assert main(words) == 2
        assert "calibration.json: damaged" in capsys.readouterr().err


def test_the_run_itself_is_not_overwritten(folder, capsys):
    for name in ("calibration.json", "cam1_cam3_frontier.csv"):
        before = (folder / name).read_bytes()
        assert main(["export", str(folder), "--format", "csv", "--out", str(folder / name)]) == 2
        assert "part of the run" in capsys.readouterr().err
        assert (folder / name).read_bytes() == before


def test_nor_is_anything_that_it_keeps_or_was_made_of(folder, scene, tmp_path, capsys):
    run = tmp_path / "run"
    shutil.copytree(folder, run)
    for name in (".epibar", "pairs", "recordings", "pictures"):
        (run / name).mkdir(exist_ok=True)
    (run / ".epibar/written.json").write_text('{"format": 1, "files": ["tracks.csv", "report.html"]}')
    content = json.loads((run / "calibration.json").read_text())
    content["cameras"][0]["file"] = str(tmp_path / "cam1.npz")
    content["intrinsics"] = str(tmp_path / "lenses.toml")
    (run / "calibration.json").write_text(json.dumps(content))
    words = ["export", str(run), "--format", "csv", "--quiet", "--out"]
    own = (
        "tracks.csv",
        "report.html",
        ".epibar/written.json",
        "pairs/cam1_cam2.npz",
        "recordings",
        "../cam1.npz",
        "../lenses.toml",
    )
    for name in own:
        assert main([*words, str(run / name)]) == 2, name
        assert "part of the run" in capsys.readouterr().err
    assert main([*words, str(run / "mine.csv")]) == 0


def test_colmap_names_are_those_of_the_model(run, tmp_path, caplog):
    pycolmap = pytest.importorskip("pycolmap")
    cameras = [replace(camera, name=camera.name.replace("m", "m ")) for camera in run.cameras]
    pairs = [replace(pair, a=pair.a.replace("m", "m "), b=pair.b.replace("m", "m ")) for pair in run.pairs]
    run = replace(run, cameras=cameras, pairs=pairs)
    export.write_colmap(run.selected(every=True), tmp_path / "database.db")
    database = pycolmap.Database.open(tmp_path / "database.db")
    assert sorted(image.name for image in database.read_all_images()) == ["cam_1", "cam_2", "cam_3"]
    database.close()
    assert "cam 1: it is cam_1" in caplog.text
