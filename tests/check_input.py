"""A network put together by hand, what its cameras filmed, and verdicts on them that are made up."""

import numpy as np
from network_input import made_up

from epibar import Recording, _core
from epibar.files.json_file import write_json
from epibar.jobs.folder import Folder

SIZE = (640, 480)
FEW = ["--masks", "--lines", "50", "--time-offset", "0"]
"""Options of the command line for masks of few pixels."""


def network():
    """cam1, cam2 and cam3 stand; cam4 was refused when the network was made."""
    return made_up(4, refused=(), lost=("cam4",))


def some_masks(seed=0, size=SIZE):
    masks = np.zeros((30, size[1], size[0]), bool)
    for t in range(30):
        masks[t, 100 + seed : 200, 8 * t : 8 * t + 40] = True
    return masks


def films(*names, size=SIZE, matrix=None):
    return {
        name: Recording.from_masks(some_masks(k, size), lines=50, matrix=matrix)
        for k, name in enumerate(names)
    }


UNMOVED = {
    "status": "unmoved",
    "reason": "what moves fits the stored camera",
    "turned": 0.01,
    "turned_error": 0.05,
    "shifted": 0.001,
    "shifted_error": 0.004,
    "focal": 0.0,
    "focal_error": 0.004,
    "deviate": 0.3,
    "since": None,
    "place": None,
    "rivals": [],
}
MOVED = {
    "status": "moved",
    "reason": "it is turned by 3.0 degrees",
    "turned": 3.0123,
    "turned_error": 0.061,
    "shifted": 0.02,
    "shifted_error": float("inf"),
    "focal": 0.012,
    "focal_error": 0.003,
    "deviate": 25.0,
    "since": 12.34,
    "place": None,
    "rivals": [],
}
UNSURE = {
    **dict.fromkeys(UNMOVED),
    "status": "unsure",
    "reason": "too little moves in it",
    "deviate": float("nan"),
    "rivals": [],
}


def suspect(*rivals):
    """MOVED, or one of these did."""
    return {**MOVED, "status": "suspect", "reason": f"it or {' or '.join(rivals)} moved", "rivals": [*rivals]}


def replaced(camera, others, zoomed=True):
    """MOVED, with a new place beside that of a camera of :func:`network`."""
    half = np.deg2rad(3.0)
    turn = np.array([[np.cos(half), -np.sin(half), 0], [np.sin(half), np.cos(half), 0], [0, 0, 1.0]])
    place = {
        "matrix": camera.matrix * [[1.012], [1.012], [1.0]] if zoomed else camera.matrix,
        "rotation": turn @ camera.rotation,
        "translation": turn @ camera.translation,
        "zoomed": zoomed,
        "reposed": True,
        "expected": {"focal": 0.003 if zoomed else 0.0, "rotation": 0.04, "position": 0.001},
        "position_covariance": np.diag([4.0, 1.0, 1.0]) * 1e-8,
        "pairs": dict.fromkeys(others, (12.0, 4.0)),
    }
    return {**MOVED, "place": place}


class Stub:
    """Stands for the compiled module: says what it is told to say, and keeps what it was asked."""

    def __init__(self, **verdicts):
        self.verdicts = verdicts

    def __call__(self, recordings, names, cameras, clocks, progress):
        self.recordings, self.names, self.cameras, self.clocks = recordings, names, cameras, clocks
        if progress is not None:
            progress("anything", 1.0)
        return [{"name": name, **self.verdicts.get(name, UNMOVED)} for name in names]


def stand_in(monkeypatch):
    stub = Stub()
    monkeypatch.setattr(_core, "check_network", stub, raising=False)
    return stub


def write_run(path, net, pairs):
    """Write what a run of a network's cameras leaves, as far as a check touches it, with these pairs."""
    with Folder(path) as held:
        for name in ("network.json", "cameras.toml", "calibration.json"):
            held.will_write(path / name)
        net.save(path / "network.json")
        net.export(path / "cameras.toml")
    cameras = [
        {"name": name, "width": 640, "height": 480, "matrix": None, "index": k}
        for k, name in enumerate(net.cameras)
    ]
    content = {"format": 1, "cameras": cameras, "pairs": pairs, "intrinsics": None}
    write_json(path / "calibration.json", {**content, "network": net.as_dict()})
