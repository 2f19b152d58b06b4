"""Cameras of networks for other programs: each file is read back, and projects as the network does."""

import importlib.util
import json
import tomllib

import cv2
import numpy as np
import pytest
from camera_formats_input import walkers
from network_input import made_up

import epibar
from epibar import EpibarError, Network
from epibar.camera_export.formats import CAMERA_FORMATS
from epibar.cli import main
from epibar.files.json_file import write_json
from epibar.lens import Intrinsics, write_cameras
from epibar.network.tracks_csv import load_tracks

RNG = np.random.default_rng(0)
LIBRARIES = {"colmap": "pycolmap", "live": "rerun"}
POINTS = RNG.uniform((-0.5, -0.5, 0), (0.5, 0.5, 0.6), (1000, 3))


def pixels(K, distortions, R, t, points=POINTS):
    return cv2.projectPoints(points, cv2.Rodrigues(R)[0], np.asarray(t), K, np.asarray(distortions))[0][:, 0]


def expected(camera):
    return pixels(camera.matrix, camera.distortions, camera.rotation, camera.translation)


def whole(count):
    return made_up(count, refused=(), lost=())


def assert_projects(net, found):
    """Whatever is found by name projects to the same pixels."""
    assert list(found) == [name for name in net.cameras if name not in net.left_out]
    for name, (K, distortions, R, t) in found.items():
        np.testing.assert_allclose(
            pixels(K, distortions, R, t), expected(net.cameras[name]), atol=1e-3, err_msg=name
        )


@pytest.mark.parametrize("count", [3, 10, 12, 101])
def test_anipose_sorts_its_tables(count, tmp_path):
    """As CameraGroup.load of aniposelib reads it: tables sorted by their names, metadata apart."""
    net = whole(count)
    assert net.export(tmp_path / "c.toml") == [tmp_path / "c.toml"]
    tables = tomllib.loads((tmp_path / "c.toml").read_text())
    assert "not metres" in tables["metadata"]["unit"]
    found = {}
    for key in sorted(tables):
        if key != "metadata":
            table = tables[key]
            assert set(table) == {"name", "size", "matrix", "distortions", "rotation", "translation"}
            assert len(table["rotation"]) == len(table["translation"]) == 3
            R = cv2.Rodrigues(np.array(table["rotation"]))[0]
            found[table["name"]] = np.array(table["matrix"]), table["distortions"], R, table["translation"]
    assert_projects(net, found)


def test_what_is_refused_is_left_out_and_named(tmp_path, caplog):
    net = made_up()
    net.export(tmp_path / "c.toml", format="anipose")
    assert "left out: cam3" in caplog.text
    cameras = epibar.load_cameras(tmp_path / "c.toml")
    assert (
        [camera.name for camera in cameras]
        == ["cam1", "cam2"]
        == [name for name in net.cameras if name not in net.left_out]
    )
    found = {c.name: (c.matrix, c.distortions, c.posed().R, c.posed().t) for c in cameras}
    assert_projects(net, found)
    notes = tomllib.loads((tmp_path / "c.toml").read_text())["metadata"]["notes"]
    assert any("left out: cam3" in note for note in notes)
    assert any("left out: cam4" in note for note in notes)


def test_caliscope(tmp_path):
    net = whole(12).scaled(person_height=1.7)
    net.export(tmp_path / "camera_array.toml", format="caliscope")
    content = tomllib.loads((tmp_path / "camera_array.toml").read_text())
    assert [table["cam_id"] for table in content["cameras"].values()] == list(range(12))
    assert content["metadata"]["unit"] == "metre"
    found = {
        table["name"]: (
            np.array(table["matrix"]),
            table["distortions"],
            cv2.Rodrigues(np.array(table["rotation"]))[0],
            table["translation"],
        )
        for table in content["cameras"].values()
    }
    assert_projects(net, found)


def test_opencv(tmp_path):
    net = made_up()
    net.export(tmp_path / "c.yaml", format="opencv")
    storage = cv2.FileStorage(str(tmp_path / "c.yaml"), cv2.FILE_STORAGE_READ)
    assert "not metres" in storage.getNode("unit").string()
    nodes = storage.getNode("cameras")
    found = {}
    for k in range(nodes.size()):
        node = nodes.at(k)
        assert int(node.getNode("width").real()) == 640
        arrays = (node.getNode(key).mat() for key in ("camera_matrix", "distortion_coefficients", "R", "t"))
        found[node.getNode("name").string()] = tuple(arrays)
    storage.release()
    assert_projects(net, found)


def test_npz(tmp_path):
    net = made_up()
    net.export(tmp_path / "c.npz", format="npz")
    with np.load(tmp_path / "c.npz", allow_pickle=False) as found:
        parts = zip(
            found["matrices"], found["distortions"], found["rotations"], found["translations"], strict=True
        )
        assert_projects(net, dict(zip(found["names"].tolist(), parts, strict=True)))
        assert "not metres" in json.loads(str(found["metadata"]))["unit"]
        assert found["sizes"].tolist() == [[640, 480]] * 2


def test_colmap(tmp_path):
    pycolmap = pytest.importorskip("pycolmap")
    net = whole(12)
    net.export(tmp_path / "model", format="colmap")
    model = pycolmap.Reconstruction(str(tmp_path / "model"))
    images = {image.name: image for image in model.images.values()}
    assert list(net.cameras) == sorted(images, key=lambda name: int(name[3:]))
    for name, image in images.items():
        camera, pose = model.cameras[image.camera_id], image.cam_from_world()
        seen = POINTS @ pose.rotation.matrix().T + pose.translation
        found = np.array([camera.img_from_cam(point) for point in seen]) - 0.5
        np.testing.assert_allclose(found, expected(net.cameras[name]), atol=1e-3)
    assert "not metres" in (tmp_path / "model" / "README.txt").read_text()


def test_lenses_that_were_taken_out(tmp_path):
    net = made_up()
    lens = Intrinsics("cam2", (640, 480), net.cameras["cam2"].matrix, [0.1, 0.02, 0.0, 0.01], fisheye=True)
    net.export(tmp_path / "c.toml", lenses={"cam2": lens})
    one, other = epibar.load_cameras(tmp_path / "c.toml")
    assert not one.fisheye
    assert other.fisheye
    assert other.distortions.tolist() == [0.1, 0.02, 0.0, 0.01]


def test_lenses_of_other_cameras_are_refused(tmp_path):
    net = made_up()
    lens = Intrinsics("cam2", (800, 600), net.cameras["cam2"].matrix, [0.1, 0.02, 0.0, 0.0, 0.0])
    for lenses, told in (
        ({"cam2": lens}, r"lenses\['cam2'\] is of 800x600 images, and the camera films 640x480"),
        ({"typo": lens}, "lenses has 'typo', which is none of the cameras: cam1"),
        ({"cam2": 3}, r"lenses\['cam2'\] is a int, expected Intrinsics"),
        ([lens], "lenses is a list, expected a mapping"),
    ):
        with pytest.raises(EpibarError, match=told):
            net.export(tmp_path / "c.toml", lenses=lenses)
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_exported(tmp_path):
    with pytest.raises(EpibarError, match="no camera is accepted"):
        made_up(refused=("cam1", "cam2", "cam3")).export(tmp_path / "c.toml")
    with pytest.raises(EpibarError, match="anipose, caliscope"):
        made_up().export(tmp_path / "c.toml", format="blender")
    (tmp_path / "file").write_text("")
    for name, one in CAMERA_FORMATS.items():
        if one.extra and not importlib.util.find_spec(LIBRARIES[one.extra]):
            continue
        with pytest.raises(EpibarError, match="cannot be"):
            made_up().export(tmp_path / "file" / "c", format=name)


# --- epibar export, epibar scale ---


@pytest.fixture
def run(tmp_path):
    """The folder of a run of which nothing but the network is left."""
    net = made_up()
    cameras = [
        {"name": name, "index": k, "width": 640, "height": 480, "matrix": None}
        for k, name in enumerate(net.cameras)
    ]
    content = {"format": 1, "intrinsics": None, "cameras": cameras, "pairs": [], "errors": []}
    write_json(tmp_path / "calibration.json", {**content, "network": net.as_dict()})
    net.save(tmp_path / "network.json")
    net.export(tmp_path / "cameras.toml")
    return tmp_path


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["anipose"], "c.toml"),
        (["toml"], "c.toml"),
        (["caliscope"], "c.toml"),
        (["opencv", "--cameras"], "c.yaml"),
        (["npz", "--cameras"], "c.npz"),
    ],
)
def test_export_from_the_command_line(words, name, run, capsys):
    assert main(["export", str(run), "--out", str(run / name), "--format", *words]) == 0
    printed = capsys.readouterr()
    assert (run / name).exists()
    assert "left out: cam3" in printed.err
    assert "left out: left out" not in printed.err
    assert printed.err.count("cam3: nothing moves in it") == printed.err.count("left out: cam3")
    assert "not in metres" in printed.err


def test_exports_that_cannot_be(run, capsys):
    for words, named in (
        (["csv", "--cameras"], "no cameras"),
        (["anipose", "--out", str(run / "network.json")], "part of the run"),
    ):
        out = ["--out", str(run / "c")] if "--out" not in words else []
        assert main(["export", str(run), *out, "--format", *words]) == 2
        assert named in capsys.readouterr().err
    (run / "network.json").unlink()
    assert main(["export", str(run), "--out", str(run / "c"), "--format", "npz", "--cameras"]) == 2
    assert "no network" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["t.npz", "t.csv"])
def test_walkers_are_exported_as_tracks(name, run, capsys):
    walkers().scaled(1.0, "baseline").save(run / "tracks.csv")
    assert main(["export", str(run), "--format", "tracks", "--out", str(run / name)]) == 0
    assert "not in metres" in capsys.readouterr().err
    table = load_tracks(run / "tracks.csv")
    if name.endswith(".csv"):
        assert (run / name).read_bytes() == (run / "tracks.csv").read_bytes()
        return
    with np.load(run / name, allow_pickle=False) as found:
        assert (found["names"].tolist(), str(found["unit"])) == (["cam1", "cam2"], "baseline")
        for key in ("time", "track", "foot", "top", "height", "cameras", "residual"):
            np.testing.assert_array_equal(found[key], getattr(table, key), err_msg=key)
        assert found["foot"].shape == (8, 3)


def test_tracks_that_cannot_be_exported(run, capsys):
    words = ["export", str(run), "--format", "tracks", "--out"]
    assert main([*words, str(run / "t.npz")]) == 2
    assert "tracks.csv: this run followed no walkers" in capsys.readouterr().err
    walkers().save(run / "tracks.csv")
    assert main([*words, str(run / "t.npz")]) == 2
    assert "tracks.csv: in metres, and the network in baselines" in capsys.readouterr().err
    walkers().scaled(1.0, "baseline").save(run / "tracks.csv")
    before = (run / "tracks.csv").read_bytes()
    for out, named in (("t.json", "written as .csv or .npz"), ("tracks.csv", "part of the run")):
        assert main([*words, str(run / out)]) == 2
        assert named in capsys.readouterr().err
    assert main([*words, str(run / "t.npz"), "--cameras"]) == 2
    assert "tracks has no cameras" in capsys.readouterr().err
    assert (run / "tracks.csv").read_bytes() == before
    assert not (run / "t.npz").exists()
    (run / "network.json").unlink()
    assert main([*words, str(run / "t.npz")]) == 2
    assert "no network" in capsys.readouterr().err


def test_scale(run, capsys):
    words = ["scale", str(run), "--camera-height", "cam2", "2.4"]
    assert main([*words, "--person-height", "1.05"]) == 0
    printed = capsys.readouterr()
    assert "2.40) m" in printed.out
    assert "metres to" in printed.err
    net = Network.load(run / "network.json")
    assert net.unit == "metre"
    assert net.cameras["cam2"].position[2] == pytest.approx(2.4)
    assert json.loads((run / "calibration.json").read_text())["network"]["unit"] == "metre"
    assert tomllib.loads((run / "cameras.toml").read_text())["metadata"]["unit"] == "metre"
    for given, named in (
        ([], "give a distance"),
        (["--distance", "cam1", "nobody", "2"], "nobody"),
        (["--distance", "cam1", "cam3", "2"], "not accepted"),
        (["--distance", "cam1", "cam2", "4", "--person-height", "1.7"], "contradict"),
    ):
        before = (run / "network.json").read_bytes()
        assert main(["scale", str(run), *given]) == 2
        assert named in capsys.readouterr().err
        assert (run / "network.json").read_bytes() == before


def test_scale_needs_the_lenses_of_the_run(run, capsys):
    content = json.loads((run / "calibration.json").read_text())
    for camera in content["cameras"]:
        camera["matrix"] = [[700.0, 0, 319.5], [0, 701, 239.5], [0, 0, 1]]
    known = [
        Intrinsics(camera["name"], (640, 480), camera["matrix"], [-0.3, 0.1, 0, 0, 0])
        for camera in content["cameras"]
    ]
    write_json(run / "calibration.json", {**content, "intrinsics": str(run / "known.toml")})
    words = ["scale", str(run), "--person-height", "1.7"]
    assert main(words) == 2
    assert "known.toml" in capsys.readouterr().err
    write_cameras(run / "known.toml", known)
    assert main(words) == 0
    assert epibar.load_cameras(run / "cameras.toml")[0].distortions.tolist() == [-0.3, 0.1, 0, 0, 0]


def test_what_is_of_another_type_is_refused(tmp_path):
    net = made_up()
    for asked, told in (
        (lambda: net.export(tmp_path / "c.glb", "gltf", tracks=3), "tracks is a int, expected what"),
        (lambda: net.updated(None), "check is a NoneType, expected what Network.check returned"),
    ):
        with pytest.raises(EpibarError, match=told):
            asked()
