"""The pages under docs/use_in/, and how each program is asked what it read, for the tests of readers."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs" / "use_in").glob("*.md"))
READERS = Path(os.environ.get("EPIBAR_READERS", ROOT / ".readers"))
"""An environment with what goes together, and in it one for Blender, which needs another NumPy."""

TITLE = "# Use it in "
TOLD = {text.splitlines()[0].removeprefix(TITLE): text for text in (page.read_text() for page in PAGES)}
"""What each page tells, by the program of its title."""

LENS = (-0.2, 0.05, 0.001, -0.002, 0.01)
FOUR = (*LENS[:4], 0)
"""For Pose2Sim, which has no place for k3."""

BEFORE = "import sys, json\nimport numpy as np\npoints = np.load('points.npy')\nfound = {}\n"
AFTER = """
found = {name: np.asarray(seen).tolist() for name, seen in found.items()}
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
    "EasyMocap": "\nkeys = 'K', 'dist', 'R', 'T'\n"
    "rows = {name: [cameras[name][key] for key in keys] for name in cameras['basenames']}\n"
    + FROM_ROWS
    + "for one in (cameras[name] for name in rows):\n"
    "    assert (one['W'], one['H']) == (640, 480)\n"
    "    assert np.allclose(one['P'], one['K'] @ np.hstack([one['R'], one['T']]))\n",
    "OpenCV": "\nassert pixels.shape == (1000, 1, 2)\n"
    "keys = ('camera_matrix', 'distortion_coefficients', 'R', 't')\n"
    "every = [cameras.at(k) for k in range(cameras.size())]\n"
    "rows = {one.getNode('name').string(): [one.getNode(key).mat() for key in keys] for one in every}\n"
    + FROM_ROWS,
    # What NerfBaselines read: it goes by pictures, camera to world, and its pixels begin at a corner.
    "nerfstudio": "\nfrom pathlib import Path\n"
    "rows = {}\n"
    "for part in parts:\n"
    "    for path, one in zip(part['image_paths'], part['cameras']):\n"
    "        fx, fy, cx, cy = one.intrinsics - np.array([0, 0, 0.5, 0.5])\n"
    "        K, R = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], one.poses[:, :3].T\n"
    "        rows[Path(path).stem] = K, one.distortion_parameters[:5], R, -R @ one.poses[:, 3]\n"
    "rows = {f'cam{k + 1}': rows[f'cam{k + 1}'] for k in range(len(rows))}\n" + FROM_ROWS,
    "COLMAP": "\nfor image in sorted(model.images.values(), key=lambda one: one.image_id):\n"
    "    camera, pose = model.cameras[image.camera_id], image.cam_from_world()\n"
    "    seen = points @ pose.rotation.matrix().T + pose.translation\n"
    "    found[image.name] = [camera.img_from_cam(one) - 0.5 for one in seen]\n",
    "NumPy": "\nwith np.load('cameras.npz') as cameras:\n    lenses = cameras['distortions']\n"
    "rows = dict(zip(names.tolist(), zip(matrices, lenses, rotations, translations)))\n" + FROM_ROWS,
}
"""What comes after the code of a page: pixels of the points, by camera."""

NERFBASELINES = """
from pathlib import Path
from nerfbaselines.cameras import project
for part in parts:
    for path, one in zip(part["image_paths"], part["cameras"]):
        found[Path(path).stem] = project(one, points.astype(np.float32)) - 0.5
"""
"""Its own projection, which has no k3."""

MULTINERF = """
from internal.camera_utils import pixels_to_rays
seen = np.load("seen.npy")
for name, pose, pixels in zip(names, poses, seen):
    x, y = pixels.T
    origins, directions, *_ = pixels_to_rays(x, y, pixtocam, pose, lens, camtype=kind)
    along = np.sum((points - origins) * directions, axis=1) / np.sum(directions**2, axis=1)
    found[name.removesuffix(".png")] = origins + along[:, None] * directions
"""
"""It goes from pixels to rays: of each, the place next to the point that was seen."""

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
""",
    # The package of its reader imports what draws and computes.
    "EasyMocap": """
import os, types
package = sys.modules["easymocap.mytools"] = types.ModuleType("easymocap.mytools")
package.__path__ = [os.path.join(os.environ["EPIBAR_EASYMOCAP"], "easymocap", "mytools")]
""",
    # Beside the reader stands the training, with jax, and a reader of COLMAP's files.
    "MultiNeRF": """
import types
from unittest.mock import MagicMock
parts = "absl", "dm_pix", "flax", "flax.core", "gin", "jax", "rawpy"
sys.modules.update({name: MagicMock(name=name) for name in parts})
sys.modules["jax.numpy"] = sys.modules["jax"].numpy = types.ModuleType("jax.numpy")
sys.modules["jax.numpy"].__dict__.update({k: v for k, v in vars(np).items() if k[:2] != "__"})
sys.modules["pycolmap"] = types.ModuleType("pycolmap")
sys.modules["pycolmap"].SceneManager = object
""",
}
"""What stands for libraries that a program imports beside its reader."""

NEEDS = {
    "aniposelib": "aniposelib",
    "Caliscope": "caliscope",
    "FreeMoCap": "freemocap",
    "Pose2Sim": "Pose2Sim",
    "nerfstudio": "nerfbaselines",
}
OF_OURS = {"OpenCV": "cv2", "COLMAP": "pycolmap", "NumPy": "numpy"}
CHECKOUTS = {
    "EasyMocap": ("EPIBAR_EASYMOCAP", "easymocap/mytools/camera_utils.py"),
    "MultiNeRF": ("EPIBAR_MULTINERF", "internal/datasets.py"),
}
"""Those that are no package: which variable names the folder, and where their reader is in it."""


def blocks(program, language):
    """Texts of the blocks of a page."""
    return re.findall(rf"^```{language}\n(.*?)^```$", TOLD[program], re.MULTILINE | re.DOTALL)


def executed(python, program, code, path=None):
    """Run code in another interpreter, where FreeMoCap makes its folders at home, and Rerun its own."""
    outside = {**os.environ, "HOME": str(Path.cwd())}
    if path is not None:
        outside["PYTHONPATH"] = str(path)
    found = subprocess.run(
        [python, "-c", code], capture_output=True, text=True, check=False, timeout=300, env=outside
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


def checkout(program):
    """The folder of a program that is no package."""
    variable, reader = CHECKOUTS[program]
    if not os.environ.get(variable):
        pytest.skip(f"{program} is no package: set {variable} to a checkout of it")
    folder = Path(os.environ[variable])
    assert (folder / reader).is_file(), f"{variable}={folder}: there is no {reader}"
    return folder
