"""A made-up network that is calibrated once, and one put together by hand, for the tests of networks."""

import functools
import json

import numpy as np

import epibar
from epibar import synthetic
from epibar.network import Ground, NetworkCamera, NetworkClock, NetworkPair
from epibar.network.parts import NetworkPairs

LINES, FRAMES = 1500, 500

WORDS = ["--masks", "--lines", str(LINES), "--no-report"]
"""Options of the command line for masks of these cameras."""


@functools.cache
def situation():
    return synthetic.situation(1, "network_plain")


@functools.cache
def recordings():
    """Three cameras of unknown lens and focal length before walkers."""
    return {f"cam{k + 1}": situation().recording(k, lines=LINES, frames=FRAMES) for k in range(3)}


@functools.cache
def calibrated():
    return epibar.calibrate_network(recordings())


def looking_at(place, target=(0.0, 0.0, 1.0)):
    """World to camera, z up, of a camera that is held level."""
    ahead = np.subtract(target, place) / np.linalg.norm(np.subtract(target, place))
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    R = np.array([right, np.cross(ahead, right), ahead])
    return R, -R @ place


COVARIANCE = np.array([[9.0, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, 0.5, 1.0]]) * 1e-7
"""That of the position of cam1, square of the baseline: three times as far along x as along y."""


def made_up(count=4, unit="baseline", refused=("cam3",), lost=("cam4",), floor=True, names=None):
    """A network on a circle; some cameras are refused, some have no place."""
    cameras, clocks, pairs = {}, {}, []
    names = names or [f"cam{k + 1}" for k in range(count)]
    for k, name in enumerate(names):
        angle = 2 * np.pi * k / count
        place = np.array([np.cos(angle), np.sin(angle), 0.8])
        R, t = looking_at(place)
        accepted = name not in (*refused, *lost)
        where = {
            "matrix": np.array([[700.0 + k, 0, 319.5], [0, 701.0 + k, 239.5], [0, 0, 1]]),
            "distortions": np.array([-0.2 - 0.01 * k, 0.05, 0.0, 0.0, -0.001]),
            "rotation": R,
            "translation": t,
            "expected": {"focal": 0.01, "rotation": 0.2, "position": 0.002 if accepted else np.inf},
            "position_covariance": COVARIANCE if name == "cam1" else None,
        }
        cameras[name] = NetworkCamera(
            name,
            (640, 480),
            accepted,
            "accepted" if accepted else "nothing_in_common",
            "calibrated" if accepted else "left out: nothing moves in it",
            **({} if name in lost else where),
            evidence={"tangents": 8.0},
        )
        clocks[name] = NetworkClock() if name in lost else NetworkClock(0.5 * k, 3.0 * k, 0.001)
    for a in range(count):
        for b in range(a + 1, count):
            gone = names[a] in lost or names[b] in lost
            F = None if gone else np.arange(9.0).reshape(3, 3) + a
            status = "outside" if gone else "confirmed"
            pairs.append(NetworkPair(names[a], names[b], not gone, status, F, {"tangents": 5.0}))
    ground = Ground("floor", 0.35, 0.2, 400, 0.05, level_error=1e-3) if floor else Ground("cameras")
    return epibar.Network(
        cameras, NetworkPairs(pairs), clocks, not (refused or lost), "made up", unit, ground, 1.2
    )


def write_masks(folder, count=3):
    """Ready masks of the cameras of :func:`situation`."""
    paths = []
    for k in range(count):
        paths.append(folder / f"cam{k + 1}.npz")
        if not paths[-1].exists():
            made = situation()
            np.savez_compressed(paths[-1], masks=made.masks(k, 0, FRAMES), fps=made.clocks[k].fps)
    return [str(path) for path in paths]


def read(out):
    """What the calibration.json of a run holds."""
    return json.loads((out / "calibration.json").read_text())
