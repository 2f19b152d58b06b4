"""Cameras that ``check.py`` put where they stand: beside the truth, and beside a fresh calibration."""

from __future__ import annotations

import time
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import numpy as np
from check_networks import CHECKED, joined, recorded


def update_error(made: Any, network: Any, name: str) -> list[float]:
    """Errors of what was solved for again and those stated: focal length, rotation (°), share of the rig."""
    from epibar import synthetic
    from epibar.synthetic.camera import Camera

    found = {
        key: Camera(c.matrix, c.rotation, c.translation, (1, 1), key) for key, c in network.cameras.items()
    }
    wrong = synthetic.network_errors(made, found)[name]
    stated = stated_errors(network.cameras[name], rig_of(found))
    return [abs(wrong.focal), wrong.rotation, wrong.position, *stated.tolist()]


def rig_of(cameras: Any) -> float:
    """The largest distance between two cameras."""
    places = [camera.centre for camera in cameras.values()]
    return float(max(np.linalg.norm(one - other) for one, other in combinations(places, 2)))


def beside_fresh(made: Any, stored: Any, check: Any, films: Any) -> dict[str, Any]:
    """Calibrate new footage by itself, in how many seconds, and hold the updated cameras against that.

    Cameras that were solved for again and have no place in the fresh network are named as ``missing``.
    """
    started = time.perf_counter()
    fresh = joined(made, films)
    seconds = time.perf_counter() - started
    again = [name for name, one in check.cameras.items() if one.place is not None]
    found = differences(stored.updated(check), fresh, again) if again else {}
    return {
        "seconds": seconds,
        "reason": fresh.reason,
        "differences": found,
        "missing": [name for name in again if name not in found],
    }


def searched(made: Any, first: int, lines: int, seed: int) -> dict[str, Any]:
    """Calibrate a minute in which nothing was done, and search its pairs too: in how many seconds."""
    import epibar

    films = {
        film.camera.name: recorded(film, first, first + CHECKED, k, lines)
        for k, film in enumerate(made.films)
    }
    started = time.perf_counter()
    network = epibar.calibrate_network(films, seed % 2**32, 0.0)
    return {"seconds": time.perf_counter() - started, "reason": network.reason}


def differences(updated: Any, fresh: Any, names: list[str]) -> dict[str, list[float]]:
    """By how much two networks differ in some cameras, and the stated errors of both together.

    Focal length, rotation (°) and share of the rig, after the similarity that lays the fresh network best
    over the updated one, as for errors of networks. The two stated errors are added as independent ones.
    """
    from epibar.synthetic.network_errors import accepted_cameras, network_errors

    one, other = accepted_cameras(updated), accepted_cameras(fresh)
    both = [name for name in one if name in other]
    if len(both) < 2:
        return {}
    one, other = ({name: cameras[name] for name in both} for cameras in (one, other))
    apart = network_errors(SimpleNamespace(cameras=list(one.values())), other)
    sides = ((updated, rig_of(one)), (fresh, rig_of(other)))
    found = {}
    for name in names:
        if name in both:
            stated = [stated_errors(network.cameras[name], rig) for network, rig in sides]
            away = apart[name]
            found[name] = [abs(away.focal), away.rotation, away.position, *np.hypot(*stated).tolist()]
    return found


def stated_errors(camera: Any, rig: float) -> np.ndarray:
    """Of focal length, rotation (°) and position, this as a share of the rig."""
    expected = camera.expected
    return np.array([expected["focal"], expected["rotation"], expected["position"] / rig])


HEAD_FRESH = (
    *("what was done", "cameras", "checks", "updates held against it", "equal, %", "equal, % (f R C)"),
    *("f differs by, stated, %", "R, °", "C, % of the rig"),
    *("check, s", "fresh calibration, s", "check : fresh", "pairs searched too, s", "check : that"),
)


def fresh_row(what: str, count: int, outcomes: list[dict[str, Any]]) -> list[str]:
    """One kind of damage: how far updated cameras are from where a fresh calibration has them; both times."""
    fresh = [o["fresh"] for o in outcomes]
    rows = np.array([one for beside in fresh for one in beside["differences"].values()]).reshape(-1, 6)
    cells = [what, str(count), str(len(fresh)), str(len(rows))]
    if len(rows):
        away, stated = rows[:, :3], rows[:, 3:]
        within = away <= stated + 1e-9
        cells.append(f"{100 * within.all(axis=1).mean():.0f}")
        cells.append(" ".join(f"{100 * share:.0f}" for share in within.mean(axis=0)))
        for k, unit in enumerate((100, 1, 100)):
            cells.append(f"{unit * np.median(away[:, k]):.2f}, {unit * np.median(stated[:, k]):.2f}")
    else:
        cells += [""] * 5
    cells += times_cells([(o["seconds"], o["fresh"]["seconds"]) for o in outcomes])
    return (
        cells
        + times_cells([(o["seconds"], o["searched"]["seconds"]) for o in outcomes if "searched" in o])[1:]
    )


def times_cells(seconds: list[tuple[float, float]]) -> list[str]:
    """Medians of the times of checks and of calibrations, and of their ratios."""
    if not seconds:
        return [""] * 3
    check, calibration = np.array(seconds).T
    times = [f"{np.median(check):.1f}", f"{np.median(calibration):.1f}"]
    return [*times, f"{np.median(check / calibration):.2f}"]
