"""What docs/use_in/ tells to do in each program is done, by its own reader where that is installed.

The command of a page writes the files, from a run whose network has twelve
cameras; its Python then runs as it stands, and what it read is projected. Programs that need other libraries
than epibar's (`make readers` installs them) run in an environment of their own, or are skipped.
"""

import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from camera_formats_input import POINTS, expected, network

from epibar.cli import main
from epibar.files.json_file import write_json

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "exports.md").read_text()
PAGES = sorted((ROOT / "docs" / "use_in").glob("*.md"))
READERS = Path(os.environ.get("EPIBAR_READERS", ROOT / ".readers"))
"""An environment with what goes together, and in it one for Blender, which needs another NumPy."""
LENS = (-0.2, 0.05, 0.001, -0.002, 0)
"""Its k3 is 0, for which Pose2Sim has no place."""

TITLE = "# Use it in "
TOLD = {text.splitlines()[0].removeprefix(TITLE): text for text in (page.read_text() for page in PAGES)}
"""What each page tells, by the program of its title."""

BEFORE = "import sys, json\nimport numpy as np\npoints = np.load('points.npy')\nfound = {}\n"
AFTER = """
found = {name: np.asarray(seen).reshape(-1, 2).tolist() for name, seen in found.items()}
json.dump(found, open("found.json", "w"))
"""

FROM_ROWS = """
import cv2
for name, (K, distortions, R, t) in rows.items():
    R = np.asarray(R, float)
    turn = cv2.Rodrigues(R)[0] if R.shape == (3, 3) else R
    t, K, distortions = (np.asarray(one, float) for one in (t, K, distortions))
    found[name] = cv2.projectPoints(points, turn, t, K, distortions)[0]
"""

PROBES = {
    "aniposelib": "\nfound = dict(zip(group.get_names(), pixels))\n",
    "Caliscope": "\nrows = {f'cam{k + 1}': (c.matrix, c.distortions, c.rotation, c.translation)"
    " for k, c in array.cameras.items()}\n" + FROM_ROWS,
    "FreeMoCap": "\nfound = dict(zip(group.get_names(), group.project(1000 * points)))\n"
    "stand = group.get_world_positions()\n"
    "turns = [cv2.Rodrigues(r)[0] for r in group.get_rotations()]\n"
    "ours = [-R.T @ t for R, t in zip(turns, group.get_translations())]\n"
    "assert np.allclose(stand, ours)\n",
    "Pose2Sim": "\nnames = [f'cam{k + 1}' for k in range(len(projections))]\n"
    "p = parameters\nrows = dict(zip(names, zip(p['K'], p['dist'], p['R'], p['T'])))\n"
    + FROM_ROWS
    + "for P, K, R, t in zip(projections, p['K'], p['R_mat'], p['T']):\n"
    "    assert np.allclose(P, K @ np.column_stack([R, t]))\n",
    "OpenCV": "\nassert pixels.shape == (1000, 1, 2)\n"
    "keys = ('camera_matrix', 'distortion_coefficients', 'R', 't')\n"
    "every = [cameras.at(k) for k in range(cameras.size())]\n"
    "rows = {one.getNode('name').string(): [one.getNode(key).mat() for key in keys] for one in every}\n"
    + FROM_ROWS,
    # It goes by pictures, and its pixels begin at a corner.
    "nerfstudio": "\nfrom pathlib import Path\nfrom nerfbaselines.cameras import project\n"
    "for part in parts:\n"
    "    for k, path in enumerate(part['image_paths']):\n"
    "        found[Path(path).stem] = project(part['cameras'][k], points.astype(np.float32)) - 0.5\n"
    "found = {f'cam{k + 1}': found[f'cam{k + 1}'] for k in range(len(found))}\n",
    "COLMAP": "\nfor image in sorted(model.images.values(), key=lambda one: one.image_id):\n"
    "    camera, pose = model.cameras[image.camera_id], image.cam_from_world()\n"
    "    seen = points @ pose.rotation.matrix().T + pose.translation\n"
    "    found[image.name] = [camera.img_from_cam(one) - 0.5 for one in seen]\n",
    "NumPy": "\nwith np.load('cameras.npz') as cameras:\n    lenses = cameras['distortions']\n"
    "rows = dict(zip(names.tolist(), zip(matrices, lenses, rotations, translations)))\n" + FROM_ROWS,
}

STUBS = {
    # Its readers import the trackers for types alone, which would bring torch and more.
    "FreeMoCap": """
import types
import cv2
class _Any:
    def __init__(self, *a, **k): pass
parts = "skellytracker", "trackers", "charuco_tracker", "charuco_model_info"
names = [".".join(parts[:k + 1]) for k in range(4)] + ["skellytracker.process_folder_of_videos"]
for name in names:
    sys.modules[name] = types.ModuleType(name)
sys.modules[names[-1]].process_list_of_videos = None
sys.modules[names[3]].CharucoModelInfo = sys.modules[names[3]].CharucoTrackingParams = _Any
"""
}

NEEDS = {
    "aniposelib": "aniposelib",
    "Caliscope": "caliscope",
    "FreeMoCap": "freemocap",
    "Pose2Sim": "Pose2Sim",
    "nerfstudio": "nerfbaselines",
}
OF_OURS = {"OpenCV": "cv2", "COLMAP": "pycolmap", "NumPy": "numpy"}


@pytest.fixture(scope="module")
def net():
    return network(distortions=LENS)


@pytest.fixture
def run(net, tmp_path, monkeypatch):
    """The folder ``calibrated`` of a run with a network, beside which commands and code run."""
    folder = tmp_path / "calibrated"
    folder.mkdir()
    cameras = [
        {"name": name, "index": k, "width": 640, "height": 480, "matrix": None}
        for k, name in enumerate(net.cameras)
    ]
    content = {"format": 1, "intrinsics": None, "cameras": cameras, "pairs": [], "errors": []}
    write_json(folder / "calibration.json", {**content, "network": net.as_dict()})
    net.save(folder / "network.json")
    np.save(tmp_path / "points.npy", POINTS)
    (tmp_path / "images").mkdir()
    for name in net.cameras:
        cv2.imwrite(str(tmp_path / "images" / f"{name}.png"), np.zeros((480, 640, 3), np.uint8))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def blocks(program, language):
    found = re.findall(rf"^```{language}\n(.*?)^```$", TOLD[program], re.MULTILINE | re.DOTALL)
    assert found, program
    return found


def export(program):
    """Run the command of a page."""
    command = blocks(program, "sh")[0].split()
    assert command[:2] == ["epibar", "export"]
    assert main(command[1:]) == 0


def executed(python, program, code):
    # FreeMoCap makes folders at home as soon as it is imported.
    home = {**os.environ, "HOME": str(Path.cwd())}
    found = subprocess.run(
        [python, "-c", code], capture_output=True, text=True, check=False, timeout=300, env=home
    )
    assert found.returncode == 0, f"{program}: {found.stderr}"


def installed(library, environment=READERS):
    """The interpreter that has a library of another program."""
    python = environment / "bin" / "python"
    if not python.exists():
        pytest.skip("the programs' own readers are not installed: make readers")
    ask = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({library!r}) is None)"
    if subprocess.run([python, "-c", ask], check=False).returncode:
        pytest.skip(f"{library} is not installed beside the other readers: make readers")
    return python


@pytest.mark.parametrize("program", PROBES)
def test_it_projects_in_the_program_as_in_the_network(program, net, run):
    if program in NEEDS:
        python = installed(NEEDS[program])
    else:
        pytest.importorskip(OF_OURS[program])
        python = sys.executable
    export(program)
    code = BEFORE + STUBS.get(program, "") + blocks(program, "python")[0] + PROBES[program] + AFTER
    executed(python, program, code)
    found = json.loads((run / "found.json").read_text())
    assert list(found) == list(net.cameras)
    for name, seen in found.items():
        np.testing.assert_allclose(seen, expected(net.cameras[name]), atol=1e-3, err_msg=name)


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


def test_blender_sees_what_the_network_sees(net, run):
    """Its lens apart, and in single precision, as Blender reckons; z is up again."""
    python = installed("bpy", READERS / "blender")
    export("Blender and game engines")
    code = BEFORE + "import bpy\nbpy.ops.wm.read_factory_settings(use_empty=True)\n"
    code += blocks("Blender and game engines", "python")[0] + IN_BLENDER + AFTER
    executed(python, "Blender", code)
    found = json.loads((run / "found.json").read_text())
    assert set(found) == set(net.cameras)
    for name, seen in found.items():
        np.testing.assert_allclose(seen, expected(net.cameras[name], np.zeros(5)), atol=0.01, err_msg=name)


@pytest.mark.parametrize("program", ["EasyMocap", "Rerun"])
def test_what_has_no_reader_here_is_written_by_its_command(program, run):
    """What is in it, `test_camera_formats.py` reads."""
    if program == "Rerun" and importlib.util.find_spec("rerun") is None:
        pytest.skip("rerun-sdk, the extra 'live', is not installed")
    export(program)
    out = blocks(program, "sh")[0].split()[-1]
    assert (run / out).exists()
    for code in re.findall(r"[\w/]+\.(?:yml|json|rrd)", TOLD[program]):
        assert (run / code).exists(), code


def test_every_format_of_cameras_is_told_of():
    from epibar.camera_export.formats import FORMATS

    written = {blocks(program, "sh")[0].split()[4] for program in TOLD}
    assert written == set(FORMATS)


def test_the_tables_of_the_page_are_those_of_the_program():
    from epibar.camera_export.formats import FORMATS
    from epibar.export import PAIR_FORMATS

    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in PAGE.splitlines()
        if line[:3] == "| `"
    ]
    cameras = [row for row in rows if len(row) == 5]
    expected_rows = [
        [
            f"`{one.name}`",
            one.program,
            one.files,
            one.unit.replace("network", "that of the network"),
            one.loses,
        ]
        for one in FORMATS.values()
    ]
    assert cameras == expected_rows
    assert [row[0].strip("`") for row in rows if len(row) == 2] == list(PAIR_FORMATS)
