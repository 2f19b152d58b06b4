"""Camera files of other programs: parsed as these do, and projected as the network does.

What the programs themselves make of them, `test_readers.py` asks.
"""

import json
import sys
import tomllib
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_formats_input import (
    HOSTILE,
    POINTS,
    assert_projects,
    expected,
    inside,
    network,
    pixels,
    rerun_entities,
    rerun_pixels,
    walkers,
)
from network_input import made_up

from epibar import EpibarError
from epibar.camera_export import losses
from epibar.camera_export.formats import ALIASES
from epibar.camera_export.formats import CAMERA_FORMATS as CAMERAS
from epibar.cli import main
from epibar.errors import printable
from epibar.export import FORMATS, PAIR_FORMATS
from epibar.lens import Intrinsics

# --- Pose2Sim and FreeMoCap ---


def as_pose2sim(path):
    """As its computeP: every table is a camera, but for four, in the order of the file."""
    tables = tomllib.loads(path.read_text())
    apart = ("metadata", "capture_volume", "charuco", "checkerboard")
    found = {}
    for table in (table for key, table in tables.items() if key not in apart):
        R = cv2.Rodrigues(np.array(table["rotation"]))[0]
        assert len(table["distortions"]) == 4
        assert table["size"] == [640, 480]
        found[table["name"]] = np.array(table["matrix"]), table["distortions"], R, table["translation"]
    return found


def test_pose2sim(tmp_path, caplog):
    net = network(distortions=(-0.2, 0.05, 0.001, -0.002, 0))
    net.export(tmp_path / "Calib.toml", format="pose2sim")
    assert_projects(net, as_pose2sim(tmp_path / "Calib.toml"))
    metadata = tomllib.loads((tmp_path / "Calib.toml").read_text())["metadata"]
    assert metadata["unit"] == "metre"
    assert not any("lost" in note for note in metadata["notes"])
    assert caplog.text == ""


@pytest.mark.parametrize(
    "lens", [(-0.3, 0.1, 0.001, -0.002, 0.05), (-0.3, 0.1, 0, 0, 0.01, 0.05, -0.02, 0.003)]
)
def test_what_pose2sim_loses_is_fitted_and_told(lens, tmp_path, caplog):
    net = network(3, distortions=lens)
    net.export(tmp_path / "Calib.toml", format="pose2sim")
    assert "lost: Pose2Sim has four distortion coefficients" in caplog.text
    (note,) = (
        n for n in tomllib.loads((tmp_path / "Calib.toml").read_text())["metadata"]["notes"] if "lost" in n
    )
    told = {
        words[3]: float(words[0]) for words in (part.split() for part in note.split("up to ")[1].split(", "))
    }
    for name, values in as_pose2sim(tmp_path / "Calib.toml").items():
        true = expected(net.cameras[name])
        seen = inside(true, net.cameras[name])
        assert seen.sum() > 300
        off = np.hypot(*(pixels(*values) - true)[seen].T).max()
        cut = np.hypot(*(expected(net.cameras[name], lens[:4]) - true)[seen].T).max()
        assert off <= 1.1 * told[name] + 1e-3
        assert off < 0.3 * cut


def test_freemocap(tmp_path):
    net = network()
    net.export(tmp_path / "c.toml", format="freemocap")
    tables = tomllib.loads((tmp_path / "c.toml").read_text())
    assert tables["metadata"]["unit"] == "millimetre"
    found = {}
    for key in sorted(tables):
        if key == "metadata":
            continue
        table = tables[key]
        R = cv2.Rodrigues(np.array(table["rotation"]))[0]
        t = np.array(table["translation"]) / 1000
        found[table["name"]] = np.array(table["matrix"]), table["distortions"], R, t
        np.testing.assert_allclose(table["world_orientation"], R.T, atol=1e-9)
        np.testing.assert_allclose(table["world_position"], -1000 * R.T @ t, atol=1e-6)
    assert_projects(net, found)


def test_units_that_are_not_the_programs_are_told(tmp_path, caplog):
    net = made_up(3, refused=(), lost=())
    net.export(tmp_path / "f.toml", format="freemocap")
    assert "FreeMoCap counts in millimetres" in caplog.text
    assert "a thousandth of the distance between cam1 and cam2" in (tmp_path / "f.toml").read_text()
    caplog.clear()
    net.export(tmp_path / "a.toml", format="anipose")
    assert caplog.text == ""


@pytest.mark.parametrize(
    ("lens", "fisheye", "share"),
    [
        ((-0.3, 0.1, 0, 0, 0), False, 1.0),
        ((-0.6, 0.4, 0.01, -0.01, 0.2), False, 1.0),
        ((0.1, 0.02, 0, 0.01), True, 1.0),
        ((-0.9, 0, 0, 0, 0), False, 0.35),  # it folds over before the corners, which no ray comes to
    ],
)
def test_what_is_lost_is_looked_for_in_the_whole_image(lens, fisheye, share):
    K = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
    rays, seen = losses._view(Intrinsics("a", (640, 480), K, lens, fisheye=fisheye))
    assert len(seen) >= share * losses.GRID**2
    zero = np.zeros(3)
    if fisheye:
        true = cv2.fisheye.distortPoints(rays[:, None], K, np.array(lens))
    else:
        true = cv2.projectPoints(np.column_stack([rays, np.ones(len(rays))]), zero, zero, K, np.array(lens))[
            0
        ]
    np.testing.assert_allclose(seen, true[:, 0], atol=1e-6)
    if share < 1:
        assert len(seen) < losses.GRID**2
    else:
        assert seen.min() < 0.01
        np.testing.assert_allclose(seen.max(axis=0), (639, 479), atol=0.01)


# --- EasyMocap ---


def as_easymocap(folder):
    """As its read_camera."""
    intri, extri = (
        cv2.FileStorage(str(folder / f"{n}.yml"), cv2.FILE_STORAGE_READ) for n in ("intri", "extri")
    )
    listed = intri.getNode("names")
    found = {}
    for name in (listed.at(k).string() for k in range(listed.size())):
        assert (intri.getNode(f"W_{name}").real(), intri.getNode(f"H_{name}").real()) == (640, 480)
        R = cv2.Rodrigues(extri.getNode(f"R_{name}").mat())[0]
        np.testing.assert_allclose(extri.getNode(f"Rot_{name}").mat(), R, atol=1e-12)
        dist = intri.getNode(f"dist_{name}").mat()
        assert dist.shape == (1, 5)
        T = extri.getNode(f"T_{name}").mat()
        assert T.shape == (3, 1)
        found[name] = intri.getNode(f"K_{name}").mat(), dist, R, T
    assert [extri.getNode("names").at(k).string() for k in range(listed.size())] == list(found)
    return found


def test_easymocap(tmp_path):
    net = network()
    written = net.export(tmp_path / "data", format="easymocap")
    assert written == [tmp_path / "data" / "intri.yml", tmp_path / "data" / "extri.yml"]
    assert_projects(net, as_easymocap(tmp_path / "data"))


def test_numbers_as_names_are_names_in_easymocap(tmp_path):
    net = network(3, names=["01", "2", "true"])
    net.export(tmp_path / "data", format="easymocap")
    assert_projects(net, as_easymocap(tmp_path / "data"))


# --- nerfstudio ---


def as_nerfstudio(path):
    """Pixels of each camera, by a projection of our own: pixels from the corner, OpenGL's axes."""
    content = json.loads(path.read_text())
    found = {}
    for frame in content["frames"]:
        frame = {**content, **frame}
        local = (POINTS - np.array(frame["transform_matrix"])[:3, 3]) @ np.array(frame["transform_matrix"])[
            :3, :3
        ]
        assert (local[:, 2] < 0).all()
        plane = local[:, :2] * (1, -1) / -local[:, 2:]
        if content["camera_model"] == "OPENCV_FISHEYE":
            radius = np.hypot(*plane.T)
            angle = np.arctan(radius)
            k = [frame[f"k{n}"] for n in (1, 2, 3, 4)]
            bent = angle * (1 + sum(c * angle ** (2 * n) for n, c in enumerate(k, 1)))
            x, y = (plane * (bent / radius)[:, None]).T
        else:
            x, y = plane.T
            r = x * x + y * y
            d = 1 + r * (frame["k1"] + r * (frame["k2"] + r * frame["k3"]))
            p1, p2 = frame["p1"], frame["p2"]
            x, y = (
                x * d + 2 * p1 * x * y + p2 * (r + 2 * x * x),
                y * d + 2 * p2 * x * y + p1 * (r + 2 * y * y),
            )
        uv = np.column_stack([frame["fl_x"] * x + frame["cx"], frame["fl_y"] * y + frame["cy"]])
        assert (frame["w"], frame["h"]) == (640, 480)
        found[frame["file_path"]] = uv - 0.5
    return found


def test_nerfstudio(tmp_path):
    net = network(distortions=(-0.2, 0.05, 0.001, -0.002, 0.01))
    net.export(tmp_path / "transforms.json", format="nerfstudio")
    found = as_nerfstudio(tmp_path / "transforms.json")
    assert list(found) == [f"images/{name}.png" for name in net.cameras]
    for camera, uv in zip(net.cameras.values(), found.values(), strict=True):
        np.testing.assert_allclose(uv, expected(camera), atol=1e-3)
    content = json.loads((tmp_path / "transforms.json").read_text())
    assert content["camera_model"] == "OPENCV"
    # nerfstudio takes what stands at the top for that of every frame.
    assert not {"fl_x", "fl_y", "cx", "cy", "w", "h", "k1", "k2", "k3", "p1", "p2"} & set(content)


def test_one_lens_of_all_stands_at_the_top_for_multinerf(tmp_path):
    net = network(3, distortions=np.zeros(5))
    matrix = net.cameras["cam1"].matrix
    net = replace(net, cameras={name: replace(c, matrix=matrix) for name, c in net.cameras.items()})
    net.export(tmp_path / "transforms.json", format="nerfstudio")
    content = json.loads((tmp_path / "transforms.json").read_text())
    assert {"w", "h", "fl_x", "fl_y", "cx", "cy", "k1", "k2", "p1", "p2"} <= set(content)
    assert "fl_x" not in content["frames"][0]
    for camera, uv in zip(
        net.cameras.values(), as_nerfstudio(tmp_path / "transforms.json").values(), strict=True
    ):
        np.testing.assert_allclose(uv, expected(camera), atol=1e-3)


def fisheyes(net, names):
    k = [0.1, 0.02, 0.0, 0.01]
    return {name: Intrinsics(name, (640, 480), net.cameras[name].matrix, k, fisheye=True) for name in names}


def test_fisheye_lenses(tmp_path):
    net = network(3)
    some, every = fisheyes(net, ["cam2"]), fisheyes(net, net.cameras)
    for name in ("pose2sim", "easymocap"):
        with pytest.raises(EpibarError, match=r"cam2: .* has no fisheye lens"):
            net.export(tmp_path / "c", format=name, lenses=some)
    with pytest.raises(EpibarError, match="one camera_model"):
        net.export(tmp_path / "c", format="nerfstudio", lenses=some)
    assert not list(tmp_path.iterdir())
    net.export(tmp_path / "transforms.json", format="nerfstudio", lenses=every)
    for camera, uv in zip(
        net.cameras.values(), as_nerfstudio(tmp_path / "transforms.json").values(), strict=True
    ):
        rotation = cv2.Rodrigues(camera.rotation)[0]
        lens = every[camera.name]
        true = cv2.fisheye.projectPoints(
            POINTS[:, None], rotation, camera.translation, lens.matrix, lens.distortions
        )[0]
        np.testing.assert_allclose(uv, true[:, 0], atol=1e-3)


# --- Rerun ---


def test_rerun(tmp_path):
    pytest.importorskip("rerun", reason="rerun-sdk, the extra 'live', is not installed")
    net = network(distortions=np.zeros(5), names=["cam 1", *(f"c{k}" for k in range(11))])
    net.export(tmp_path / "c.rrd", format="rerun")
    logged = rerun_entities(tmp_path / "c.rrd")
    for camera in net.cameras.values():
        found = logged[f"/world/{camera.name}"]
        np.testing.assert_allclose(rerun_pixels(found), expected(camera), atol=1e-3)
        assert found["Pinhole:resolution"] == [[640, 480]]
    assert logged["/world/names"]["Points3D:labels"] == list(net.cameras)
    assert "unit: metre" in logged["/about"]["TextDocument:text"][0]


def test_walkers_in_rerun(tmp_path):
    pytest.importorskip("rerun", reason="rerun-sdk, the extra 'live', is not installed")
    from rerun.chunk import RrdReader

    tracks = walkers()
    network(3).export(tmp_path / "c.rrd", format="rerun", tracks=tracks)
    lines, there = {}, []
    for chunk in RrdReader(tmp_path / "c.rrd").stream():
        batch = chunk.to_record_batch()
        entity = str(chunk.entity_path).replace("\\", "")
        if not entity.startswith("/world/walkers/"):
            continue
        strips = batch.column(batch.schema.names.index("LineStrips3D:strips")).to_pylist()
        if entity.endswith("walker 4/there"):
            seconds = batch.column(batch.schema.names.index("time")).cast("int64").to_pylist()
            there += zip(seconds, strips, strict=True)
        elif not entity.endswith("/there"):
            lines[entity] = strips[-1]
    assert sorted(lines) == [f"/world/walkers/walker {w}" for w in ("0 part 1", "0 part 2", "4")]
    np.testing.assert_allclose(lines["/world/walkers/walker 4"][0], tracks.foot[5:8], atol=1e-6)
    there.sort(key=lambda one: one[0])
    assert [one[0] / 1e9 for one in there] == pytest.approx([*tracks.time[5:8], tracks.time[7] + 1e-3])
    for (_, (segment,)), foot, top in zip(there, tracks.foot[5:8], tracks.top[5:8], strict=False):
        np.testing.assert_allclose(segment, [foot, top], atol=1e-6)
    assert there[-1][1] == []


def test_rerun_that_is_not_installed_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(EpibarError, match=r"epibar\[live\]"):
        network(3).export(tmp_path / "c.rrd", format="rerun")


# --- names ---


def test_hostile_names_are_text_or_are_told(tmp_path, caplog):
    net = network(len(HOSTILE), names=HOSTILE)
    for name in ("pose2sim", "freemocap"):
        net.export(tmp_path / f"{name}.toml", format=name)
        tables = tomllib.loads((tmp_path / f"{name}.toml").read_text())
        assert [table["name"] for key, table in tables.items() if key != "metadata"] == HOSTILE
        assert list(tables) == [*(f"cam_{k}" for k in range(len(HOSTILE))), "metadata"]
    shown = [printable(name) for name in HOSTILE]
    net.export(tmp_path / "transforms.json", format="nerfstudio")
    frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    assert [frame["name"] for frame in frames] == shown
    files = [frame["file_path"] for frame in frames]
    assert len(set(files)) == len(files)
    assert all(file.count("/") == 1 and file.isprintable() and " " not in file for file in files)
    caplog.clear()
    net.export(tmp_path / "data", format="easymocap")
    found = as_easymocap(tmp_path / "data")
    assert len(found) == len(HOSTILE)
    assert "none" not in found
    assert "renamed: cam 1: it is cam_1 in these files" in caplog.text
    for camera, values in zip(net.cameras.values(), found.values(), strict=True):
        np.testing.assert_allclose(pixels(*values), expected(camera), atol=1e-3)
    assert not (tmp_path.parent / "up").exists()


# --- the table ---


def test_formats_are_listed(capsys):
    assert main(["formats", "--json"]) == 0
    entries = json.loads(capsys.readouterr().out)
    assert [(e["holds"], e["format"]) for e in entries] == [
        (h, n) for h, table in FORMATS.items() for n in table
    ]
    for entry in entries:
        assert all(entry[key] for key in ("program", "files", "unit", "axes", "loses"))
    assert main(["formats"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for entry in entries:
        assert f"{entry['format']} {entry['program']} writes {entry['files']}" in text
        assert f"loses: {entry['loses']}" in text


def test_every_format_has_its_writer():
    for table in FORMATS.values():
        for name, one in table.items():
            assert name == one.name
            assert callable(one.write)
    assert set(ALIASES.values()) <= set(CAMERAS)
    assert not set(ALIASES) & {*CAMERAS, *PAIR_FORMATS}
