"""What docs/use_in/ tells to do in each program is done, by its own reader where that is installed.

The command of a page writes the files, from a run whose network has twelve cameras; its Python then runs as
it stands, and what it read is projected. Programs that need other libraries than epibar's (`make readers`
installs them) run in an environment of their own, or are skipped. EasyMocap and MultiNeRF are no packages:
they are skipped unless a variable names a checkout.
"""

import importlib.util
import itertools
import json
import re
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_formats_input import POINTS, expected, inside, network, pixels, rerun_entities, rerun_pixels
from readers_input import (
    AFTER,
    BEFORE,
    FOUR,
    LENS,
    MULTINERF,
    NEEDS,
    NERFBASELINES,
    OF_OURS,
    PROBES,
    READERS,
    ROOT,
    STUBS,
    TOLD,
    blocks,
    checkout,
    executed,
    installed,
)

from epibar import FrontierPoints
from epibar.cli import main
from epibar.files.frontier_csv import write_frontier_points
from epibar.files.json_file import write_json
from epibar.geometry.cameras import opengl_pose

PAGE = (ROOT / "docs" / "exports.md").read_text()
ON_AXES = (ROOT / "docs" / "axes.md").read_text()
OF_A_PIXEL = 1e-3


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Make the folder ``calibrated`` of a run with a network, beside which commands and code run."""

    def made(net):
        folder = tmp_path / "calibrated"
        folder.mkdir()
        cameras = [
            {"name": name, "index": k, "width": 640, "height": 480, "matrix": None}
            for k, name in enumerate(net.cameras)
        ]
        content = {"format": 1, "intrinsics": None, "cameras": cameras, "errors": []}
        pairs = [seen_by(net, a, b, folder) for a, b in itertools.pairwise(net.cameras)]
        write_json(folder / "calibration.json", {**content, "pairs": pairs, "network": net.as_dict()})
        net.save(folder / "network.json")
        np.save(tmp_path / "points.npy", POINTS)
        (tmp_path / "images").mkdir()
        for name in net.cameras:
            cv2.imwrite(str(tmp_path / "images" / f"{name}.png"), np.zeros((480, 640, 3), np.uint8))
        return tmp_path

    monkeypatch.chdir(tmp_path)
    return made


def seen_by(net, a, b, folder):
    """An accepted pair with what both cameras see of the points, as it stands in a run."""
    seen = [expected(net.cameras[name]) for name in (a, b)]
    good = inside(seen[0], net.cameras[a]) & inside(seen[1], net.cameras[b])
    points = FrontierPoints(np.arange(good.sum()), seen[0][good], seen[1][good], np.zeros(good.sum()))
    file = write_frontier_points(folder / f"{a}_{b}.csv", points).name
    F = net.pairs[a, b].F.tolist()
    known = {"a": a, "b": b, "kind": "accepted", "accepted": True, "reason": "", "F": F}
    return {**known, "expected_error": None, "time_offset": 0.0, "frontier_points": file}


def export(program):
    """Run the command of a page."""
    command = blocks(program, "sh")[0].split()
    assert command[:2] == ["epibar", "export"]
    assert main(command[1:]) == 0


def of_this_environment(program):
    pytest.importorskip(OF_OURS[program])
    return sys.executable


@pytest.mark.parametrize("program", PROBES)
def test_it_projects_in_the_program_as_in_the_network(program, run):
    path = checkout(program) if program == "EasyMocap" else None
    if program in NEEDS:
        python = installed(NEEDS[program])
    else:
        python = of_this_environment(program) if path is None else sys.executable
    net = network(distortions=FOUR if program == "Pose2Sim" else LENS)
    folder = run(net)
    export(program)
    code = BEFORE + STUBS.get(program, "") + blocks(program, "python")[0] + PROBES[program] + AFTER
    executed(python, program, code, path)
    found = json.loads((folder / "found.json").read_text())
    assert list(found) == list(net.cameras)
    for name, seen in found.items():
        seen = np.reshape(seen, (-1, 2))
        np.testing.assert_allclose(seen, expected(net.cameras[name]), atol=OF_A_PIXEL, err_msg=name)


def test_nerfbaselines_projects_as_the_network_without_k3(run):
    python = installed(NEEDS["nerfstudio"])
    net = network(distortions=FOUR)
    folder = run(net)
    export("nerfstudio")
    executed(python, "NerfBaselines", BEFORE + blocks("nerfstudio", "python")[0] + NERFBASELINES + AFTER)
    found = json.loads((folder / "found.json").read_text())
    assert set(found) == set(net.cameras)
    for name, seen in found.items():
        np.testing.assert_allclose(seen, expected(net.cameras[name]), atol=OF_A_PIXEL, err_msg=name)


def test_what_fits_stays_in_colmaps_own_adjustment(run):
    """The page's second block, after the first: points that all cameras see where they are move nothing."""
    python = of_this_environment("COLMAP")
    net = network(distortions=LENS)
    folder = run(net)
    export("COLMAP")
    code = "\n".join(blocks("COLMAP", "python"))
    asked = "\nassert model.num_points3D() > 1000\n"
    executed(python, "COLMAP", BEFORE + code + asked + PROBES["COLMAP"] + AFTER)
    found = json.loads((folder / "found.json").read_text())
    assert list(found) == list(net.cameras)
    for name, seen in found.items():
        seen = np.reshape(seen, (-1, 2))
        np.testing.assert_allclose(seen, expected(net.cameras[name]), atol=OF_A_PIXEL, err_msg=name)


def test_multinerf_looks_where_the_network_looks(run):
    """Through one lens without k3, of all cameras: its rays meet what was seen."""
    path, python = checkout("MultiNeRF"), installed("scipy")
    net = network(distortions=FOUR)
    matrix = net.cameras["cam1"].matrix
    net = replace(net, cameras={name: replace(c, matrix=matrix) for name, c in net.cameras.items()})
    folder = run(net)
    np.save(folder / "seen.npy", [expected(camera) for camera in net.cameras.values()])
    export("nerfstudio")
    code = BEFORE + STUBS["MultiNeRF"] + blocks("nerfstudio", "python")[1] + MULTINERF + AFTER
    executed(python, "MultiNeRF", code, path)
    found = json.loads((folder / "found.json").read_text())
    assert list(found) == list(net.cameras)
    for name, places in found.items():
        camera = net.cameras[name]
        again = pixels(
            camera.matrix, camera.distortions, camera.rotation, camera.translation, np.array(places)
        )
        np.testing.assert_allclose(again, expected(camera), atol=OF_A_PIXEL, err_msg=name)


IN_BLENDER = """
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 640, 480, 100
from mathutils import Vector
from bpy_extras.object_utils import world_to_camera_view
for one in (one for one in bpy.data.objects if one.type == "CAMERA"):
    # Blender's pixels have one width and one height: those of focal lengths that differ are in the aspect.
    extras = [list(row) for row in one["matrix"]]
    ratio = extras[1][1] / extras[0][0]
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = (ratio, 1) if ratio > 1 else (1, 1 / ratio)
    view = [world_to_camera_view(scene, one, Vector(point)) for point in points]
    found[one.name] = [(x * 640 - 0.5, (1 - y) * 480 - 0.5) for x, y, _ in view]
    assert f"{one.name} frustum" in bpy.data.objects
assert "the floor, grid of 1 m" in bpy.data.objects
"""


def test_blender_sees_what_the_network_sees(run):
    """Its lens apart, which glTF loses, and in single precision; z is up again."""
    python = installed("bpy", READERS / "blender")
    net = network(distortions=LENS)
    folder = run(net)
    export("Blender and game engines")
    code = BEFORE + "import bpy\nbpy.ops.wm.read_factory_settings(use_empty=True)\n"
    code += blocks("Blender and game engines", "python")[0] + IN_BLENDER + AFTER
    executed(python, "Blender", code)
    found = json.loads((folder / "found.json").read_text())
    assert set(found) == set(net.cameras)
    for name, seen in found.items():
        np.testing.assert_allclose(
            seen, expected(net.cameras[name], np.zeros(5)), atol=OF_A_PIXEL, err_msg=name
        )


def test_rerun_loads_what_the_network_sees(run):
    """The page's command, with an option that saves what it loaded instead of opening a window."""
    if importlib.util.find_spec("rerun") is None:
        pytest.skip("rerun-sdk, the extra 'live', is not installed")
    net = network(distortions=LENS)
    folder = run(net)
    export("Rerun")
    command = blocks("Rerun", "sh")[1].split()
    assert command == ["rerun", "cameras.rrd"]
    words = ["-m", "rerun_cli", *command[1:], "--save", "loaded.rrd", "--port", "auto"]
    code = f"import subprocess, sys; sys.exit(subprocess.run([sys.executable, *{words}]).returncode)"
    executed(sys.executable, "Rerun", code)
    logged = rerun_entities(folder / "loaded.rrd")
    for name, camera in net.cameras.items():
        seen = rerun_pixels(logged[f"/world/{name}"])
        np.testing.assert_allclose(seen, expected(camera, np.zeros(5)), atol=OF_A_PIXEL, err_msg=name)


@pytest.mark.parametrize("program", ["EasyMocap", "Rerun"])
def test_what_is_no_package_is_written_by_its_command(program, run):
    """What is in it, `test_camera_formats.py` reads."""
    if program == "Rerun" and importlib.util.find_spec("rerun") is None:
        pytest.skip("rerun-sdk, the extra 'live', is not installed")
    folder = run(network(distortions=LENS))
    export(program)
    out = blocks(program, "sh")[0].split()[-1]
    assert (folder / out).exists()
    for code in re.findall(r"[\w/]+\.(?:yml|json|rrd)", TOLD[program]):
        assert (folder / code).exists(), code


def test_every_block_of_python_is_run():
    """Each page has the blocks that the tests here run, and no more."""
    found = {program: len(blocks(program, "python")) for program in TOLD}
    more = {"COLMAP": 2, "nerfstudio": 2, "Blender and game engines": 1, "Rerun": 0}
    assert found == {**dict.fromkeys(PROBES, 1), **more}


def test_every_format_of_cameras_is_told_of():
    from epibar.camera_export.formats import CAMERA_FORMATS

    written = {blocks(program, "sh")[0].split()[4] for program in TOLD}
    assert written == set(CAMERA_FORMATS)


def table_rows(page):
    """Cells of each row that begins with a name."""
    lines = [line for line in page.splitlines() if line[:3] == "| `"]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_the_page_on_axes_is_that_of_the_program():
    from epibar.camera_export.formats import CAMERA_FORMATS

    units = {"network": "that of the network"}
    wanted = [
        [f"`{one.name}`", one.program, one.axes, units.get(one.unit, one.unit)]
        for one in CAMERA_FORMATS.values()
    ]
    assert table_rows(ON_AXES) == wanted
    (code,) = re.findall(r"^```python\n(.*?)^```$", ON_AXES, re.MULTILINE | re.DOTALL)
    for camera in network().cameras.values():
        names = {"np": np, "R": camera.rotation, "t": camera.translation}
        exec(code, names)
        np.testing.assert_allclose(names["place"], camera.position, atol=1e-9)
        in_image = camera.rotation @ names["ahead"]
        np.testing.assert_allclose(in_image, (0, 0, 1), atol=1e-9)
        turn, place = opengl_pose(camera.intrinsics().posed())
        np.testing.assert_allclose(names["of_opengl"], np.column_stack([turn, place]), atol=1e-9)


def test_the_tables_of_the_page_are_those_of_the_program():
    from epibar.camera_export.formats import CAMERA_FORMATS
    from epibar.export import PAIR_FORMATS

    rows = table_rows(PAGE)
    cameras = [row for row in rows if len(row) == 5]
    expected_rows = [
        [
            f"`{one.name}`",
            one.program,
            one.files,
            one.unit.replace("network", "that of the network"),
            one.loses,
        ]
        for one in CAMERA_FORMATS.values()
    ]
    assert cameras == expected_rows
    assert [row[0].strip("`") for row in rows if len(row) == 2] == list(PAIR_FORMATS)
