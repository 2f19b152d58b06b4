"""The glTF scene of a network: parsed and projected by the words of the specification."""

import base64
import json
import struct
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_formats_input import HOSTILE, POINTS, expected, network, pixels, walkers

from epibar import EpibarError
from epibar.errors import printable
from epibar.lens import Intrinsics


def read_gltf(path):
    """The document and the buffer of a .gltf or .glb file."""
    content = path.read_bytes()
    if path.suffix == ".gltf":
        document = json.loads(content)
        kind, data = document["buffers"][0]["uri"].split(",")
        assert kind == "data:application/octet-stream;base64"
        return document, base64.b64decode(data)
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    chunks, at = [], 12
    while at < len(content):
        size, kind = struct.unpack_from("<II", content, at)
        assert size % 4 == 0
        chunks.append((kind, content[at + 8 : at + 8 + size]))
        at += 8 + size
    assert [kind for kind, _ in chunks] == [0x4E4F534A, 0x004E4942]
    return json.loads(chunks[0][1]), chunks[1][1]


def local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = node["rotation"]
        angle = 2 * np.arctan2(np.linalg.norm([x, y, z]), w)
        matrix[:3, :3] = cv2.Rodrigues(angle * np.array([x, y, z]) / np.linalg.norm([x, y, z]))[0]
    return matrix


def placed_nodes(document):
    """Each node by its name, with node to world."""
    found = {}

    def walk(index, above):
        node = document["nodes"][index]
        here = above @ local_matrix(node)
        found[node["name"]] = node, here
        for child in node.get("children", ()):
            walk(child, here)

    for root in document["scenes"][document["scene"]]["nodes"]:
        walk(root, np.eye(4))
    assert len(found) == len(document["nodes"])
    return found


def vertices(document, buffer, node):
    (primitive,) = document["meshes"][node["mesh"]]["primitives"]
    assert primitive["mode"] in (1, 3)
    accessor = document["accessors"][primitive["attributes"]["POSITION"]]
    views = document["bufferViews"]
    assert accessor["byteOffset"] + 12 * accessor["count"] <= views[0]["byteLength"]
    assert sum(view["byteLength"] for view in views) == len(buffer)
    found = np.frombuffer(buffer, "<f4", 3 * accessor["count"], accessor["byteOffset"]).reshape(-1, 3)
    np.testing.assert_array_equal(found.min(axis=0), np.float32(accessor["min"]))
    np.testing.assert_array_equal(found.max(axis=0), np.float32(accessor["max"]))
    return found.astype(float)


@pytest.mark.parametrize("name", ["c.gltf", "c.glb"])
def test_gltf(name, tmp_path):
    net = network(distortions=np.zeros(5))
    net.export(tmp_path / name, format="gltf")
    document, buffer = read_gltf(tmp_path / name)
    nodes = placed_nodes(document)
    cameras = [node["name"] for node in document["nodes"] if "camera" in node]
    assert cameras == list(net.cameras)
    up = POINTS[:, [0, 2, 1]] * (1, 1, -1)  # y up
    for camera in net.cameras.values():
        node, to_world = nodes[camera.name]
        assert to_world[1, 3] == pytest.approx(camera.position[2])
        lens = document["cameras"][node["camera"]]["perspective"]
        local = (up - to_world[:3, 3]) @ to_world[:3, :3]
        # The projection matrix of the specification, without a far plane.
        y = local[:, 1] / np.tan(lens["yfov"] / 2) / -local[:, 2]
        x = local[:, 0] / (lens["aspectRatio"] * np.tan(lens["yfov"] / 2)) / -local[:, 2]
        found = np.column_stack([(x + 1) / 2 * 640, (1 - y) / 2 * 480]) - 0.5
        np.testing.assert_allclose(found, expected(camera), atol=1e-3)
        frustum, stands = nodes[f"{camera.name} frustum"]
        corners = vertices(document, buffer, frustum) @ stands[:3, :3].T + stands[:3, 3]
        back = corners[:, [0, 2, 1]] * (1, -1, 1)  # z up
        seen = pixels(camera.matrix, np.zeros(5), camera.rotation, camera.translation, back[1:8:2])
        np.testing.assert_allclose(
            seen, [(-0.5, -0.5), (639.5, -0.5), (639.5, 479.5), (-0.5, 479.5)], atol=0.01
        )
    grid, above = nodes["the floor, grid of 1 m"]
    floor = vertices(document, buffer, grid) @ above[:3, :3].T
    np.testing.assert_allclose(floor[:, 1], 0, atol=1e-6)
    places = np.array([camera.position for camera in net.cameras.values()])
    assert (floor[:, 0].min() <= places[:, 0].min()) & (floor[:, 0].max() >= places[:, 0].max())


def test_what_gltf_loses_stands_in_extras_and_is_told(tmp_path, caplog):
    net = network(3)
    net.export(tmp_path / "c.gltf", format="gltf")
    assert "lost: a camera of glTF has no lens" in caplog.text
    document, _ = read_gltf(tmp_path / "c.gltf")
    nodes = placed_nodes(document)
    for camera in net.cameras.values():
        extras = nodes[camera.name][0]["extras"]
        np.testing.assert_array_equal(extras["matrix"], camera.matrix)
        np.testing.assert_array_equal(extras["distortions"], camera.distortions)
    about = document["nodes"][0]["extras"]
    assert about["unit"] == "metre"
    assert any("px in cam3" in note for note in about["notes"])


def test_a_principal_point_off_the_middle_is_lost_in_gltf_and_told(tmp_path, caplog):
    net = network(3, distortions=np.zeros(5))
    off = np.add(net.cameras["cam2"].matrix, [[0, 0, 3], [0, 0, 4], [0, 0, 0]])
    net.cameras["cam2"] = replace(net.cameras["cam2"], matrix=off)
    net.export(tmp_path / "c.gltf", format="gltf")
    assert "5 px in cam2" in caplog.text
    assert "cam1" not in caplog.text


def test_names_are_text_in_gltf(tmp_path):
    net = network(len(HOSTILE), names=HOSTILE)
    net.export(tmp_path / "c.gltf", format="gltf")
    document, _ = read_gltf(tmp_path / "c.gltf")
    shown = [printable(name) for name in HOSTILE]
    assert [node["name"] for node in document["nodes"] if "camera" in node] == shown


def test_a_fisheye_lens_stands_in_extras(tmp_path):
    net = network(3)
    lens = Intrinsics("cam1", (640, 480), net.cameras["cam1"].matrix, [0.1, 0.02, 0.0, 0.01], fisheye=True)
    net.export(tmp_path / "c.glb", format="gltf", lenses={"cam1": lens})
    extras = [node["extras"] for node in read_gltf(tmp_path / "c.glb")[0]["nodes"] if "camera" in node]
    assert [one["fisheye"] for one in extras] == [True, False, False]


def samples(document, buffer, index):
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    assert "target" not in view
    width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    at = view["byteOffset"] + accessor["byteOffset"]
    found = np.frombuffer(buffer, "<f4", width * accessor["count"], at).reshape(-1, width)
    np.testing.assert_array_equal(found.min(axis=0), np.float32(accessor["min"]))
    np.testing.assert_array_equal(found.max(axis=0), np.float32(accessor["max"]))
    return found.astype(float)


@pytest.mark.parametrize("name", ["c.gltf", "c.glb"])
@pytest.mark.parametrize("began", [2.0, -3.0])
def test_walkers_in_gltf_are_lines_and_an_animation(name, began, tmp_path):
    net, tracks = network(3), walkers(began)
    net.export(tmp_path / name, format="gltf", tracks=tracks)
    document, buffer = read_gltf(tmp_path / name)
    nodes = placed_nodes(document)
    ways = [key for key in nodes if key.startswith("walker") and not key.endswith("moving")]
    assert ways == ["walker 0 part 1", "walker 0 part 2", "walker 4"]
    for way, rows in zip(ways, ([0, 1, 2], [3, 4], [5, 6, 7]), strict=True):
        node, above = nodes[way]
        feet = vertices(document, buffer, node) @ above[:3, :3].T
        np.testing.assert_allclose(feet, tracks.foot[rows][:, [0, 2, 1]] * (1, 1, -1), atol=1e-5)
    (animation,) = document["animations"]
    shift = -min(began, 0.0)
    moved = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        time = samples(document, buffer, sampler["input"])[:, 0]
        assert time[0] >= 0
        assert (np.diff(time) > 0).all()
        key = document["nodes"][channel["target"]["node"]]["name"], channel["target"]["path"]
        moved[key] = sampler["interpolation"], time, samples(document, buffer, sampler["output"])
    assert len(moved) == 6
    kind, time, place = moved["walker 4 moving", "translation"]
    assert kind == "LINEAR"
    np.testing.assert_allclose(time, tracks.time[5:8] + shift, atol=1e-5)
    np.testing.assert_allclose(place, tracks.foot[5:8], atol=1e-5)
    kind, time, size = moved["walker 4 moving", "scale"]
    assert kind == "STEP"
    assert size[:, 0].tolist() == [0, 1, 0]
    assert time[1] == pytest.approx(tracks.time[5] + shift)
    standing = vertices(document, buffer, nodes["walker 4 moving"][0])
    np.testing.assert_allclose(standing, [[0, 0, 0], [0, 0, 1.7]], atol=1e-6)
    notes = document["nodes"][0]["extras"]["notes"]
    assert any("3.000 s before the first frame" in note for note in notes) == (began < 0)


def test_walkers_without_a_place_are_refused(tmp_path):
    net = network(3)
    with pytest.raises(EpibarError, match=r"'anipose' has no place for walkers; .*: colmap, gltf, rerun"):
        net.export(tmp_path / "c.toml", format="anipose", tracks=walkers())
    with pytest.raises(EpibarError, match=r"in baselines and the network in metres.*scaled"):
        net.export(tmp_path / "c.gltf", format="gltf", tracks=walkers().scaled(1.0, "baseline"))
    assert not list(tmp_path.iterdir())
