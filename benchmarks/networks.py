"""Fresh networks of unknown cameras: what is accepted, how wrong it is, and whether what is stated holds.

Nothing is known of the cameras, not even when they started. The seeds of a reported table come from
the commit's own hash, as those of ``fresh.py``.
"""

from __future__ import annotations

import json
import os
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from fresh_seeds import networks_asked_for
from network_worlds import world, worlds_table
from options import add_networks
from tables import progress

WRONG = 3.0
"""An accepted camera is wrong beyond so many times what is stated of it, and one of these:"""

TURNED, ASIDE = 1.0, 0.1
"""Degrees, and share of the rig."""


def start_worker() -> None:
    """One thread for each worker: there are as many workers as cores."""
    os.environ["RAYON_NUM_THREADS"] = "1"
    os.nice(10)


def outcomes_of(
    run: Callable[..., list[dict[str, Any]]], jobs: list[Any], arguments: Namespace, origin: str | None
) -> list[dict[str, Any]]:
    """Run jobs on ``--workers``, each of which gives some outcomes, and write those so far to ``--json``."""
    outcomes: list[dict[str, Any]] = []
    with ProcessPoolExecutor(arguments.workers, get_context("spawn"), start_worker) as pool:
        pending = [pool.submit(run, *job) for job in jobs]
        for number, done in enumerate(as_completed(pending), 1):
            outcomes += done.result()
            left_out = [name for outcome in done.result() for name in outcome.get("left_out", ())]
            progress(f"{number} of {len(jobs)}" + (f", left out {', '.join(left_out)}" if left_out else ""))
            if arguments.json:
                arguments.json.write_text(json.dumps({"commit": origin, "outcomes": outcomes}, indent=1))
    return outcomes


def run(family: str, seed: int, lines: int, known: bool = False) -> list[dict[str, Any]]:
    """Draw a situation, record its cameras as they film, calibrate the network, hold it against the truth."""
    import epibar
    from epibar import synthetic

    situation = synthetic.situation(seed, family)
    started = time.perf_counter()
    recordings = {c.name: situation.recording(i, lines) for i, c in enumerate(situation.cameras)}
    recorded = time.perf_counter()
    stages: dict[str, float] = {}

    def stage(name: str, _: float) -> None:
        stages.setdefault(name, time.perf_counter())

    lenses = {c.name: epibar.KnownCamera(matrix=c.K, distortions=distortions(c)) for c in situation.cameras}
    network = epibar.calibrate_network(
        recordings, seed=seed % 2**32, progress=stage, known=lenses if known else None
    )
    ended = time.perf_counter()
    blamed = sorted({situation.cameras[c].name for fault in situation.faults for c in fault.cameras})
    clocks = {
        c.name: abs(network.clocks[c.name].offset - situation.clock_between(0, i)[0])
        * situation.clocks[i].fps
        for i, c in enumerate(situation.cameras)
        if network.cameras[c.name].accepted
    }
    outcome = {
        "family": family,
        "seed": seed,
        "cameras": len(recordings),
        "blamed": blamed,
        "left_out": network.left_out,
        "status": {name: camera.status for name, camera in network.cameras.items()},
        "errors": errors(situation, network),
        "half_axes": half_axes(situation, network),
        "world": world(situation, network),
        "clocks": list(clocks.values()) if situation.cameras[0].name in clocks else [],
        "seconds": [
            recorded - started,
            stages.get("network", ended) - recorded,
            ended - stages.get("network", ended),
        ],
    }
    return [outcome]


def distortions(camera: Any) -> np.ndarray:
    """Return the five distortion coefficients of a true camera."""
    return np.array([*camera.distortions, *[0.0] * 5][:5])


def errors(situation: Any, network: Any) -> dict[str, list[float]]:
    """Errors of focal length, rotation (degrees), position (share of the rig), and those stated."""
    from epibar import synthetic

    found = synthetic.accepted_cameras(network)
    if len(found) < 2:
        return {}
    wrong = synthetic.network_errors(situation, found)
    places = np.array([camera.centre for camera in found.values()])
    rig = max(np.linalg.norm(p - q) for p in places for q in places)
    stated = {name: network.cameras[name].expected for name in found}
    return {
        name: [
            *(abs(wrong[name].focal), wrong[name].rotation, wrong[name].position),
            *(stated[name]["focal"], stated[name]["rotation"], stated[name]["position"] / rig),
        ]
        for name in found
    }


def half_axes(situation: Any, network: Any) -> list[float]:
    """How many half axes of its ellipsoid each accepted camera is from where it truly stands."""
    from epibar import synthetic
    from epibar.network.shared_errors import IN_SPACE

    found = synthetic.accepted_cameras(network)
    if len(found) < 2:
        return []
    return [
        float(np.sqrt(off @ np.linalg.solve(network.cameras[name].position_covariance, off)) / IN_SPACE)
        for name, off in synthetic.position_errors(situation, found).items()
    ]


def wrong_cameras(cameras: Any) -> int:
    """Count the accepted cameras that are :data:`WRONG`, of rows as those of :func:`errors`."""
    (_, rotation, position), (_, turned, aside) = cameras[:, :3].T, cameras[:, 3:].T
    is_turned = (rotation > WRONG * turned) & (rotation > TURNED)
    is_aside = (position > WRONG * aside) & (position > ASIDE)
    return int((is_turned | is_aside).sum())


def shares_held(cameras: Any) -> str:
    """Say of how many the errors are below those stated, %; what is held is wrong by rounding alone."""
    return " ".join(f"{100 * share:.0f}" for share in (cameras[:, :3] <= cameras[:, 3:] + 1e-9).mean(axis=0))


def row(outcomes: list[dict[str, Any]]) -> str:
    """One family in a row of the table."""
    cameras = [e for o in outcomes for e in o["errors"].values()]
    sound = sum(o["cameras"] - len(o["blamed"]) for o in outcomes)
    accepted = sum(len(o["errors"]) for o in outcomes)
    named = sum(set(o["blamed"]) <= set(o["left_out"]) for o in outcomes if o["blamed"])
    faulty = sum(bool(o["blamed"]) for o in outcomes)
    cells = [
        outcomes[0]["family"],
        str(len(outcomes)),
        f"{accepted} of {sound}",
        f"{named} of {faulty}" if faulty else "",
    ]
    if cameras:
        e = np.array(cameras)
        for k, unit in ((0, 100), (1, 1), (2, 100)):
            cells.append(f"{unit * np.median(e[:, k]):.2f}, {unit * np.quantile(e[:, k], 0.95):.2f}")
        cells.append(shares_held(e))
        away = np.concatenate([o["half_axes"] for o in outcomes])
        cells.append(f"{100 * (away <= 1).mean():.0f}")
        cells.append(str(wrong_cameras(e)))
        clocks = [c for o in outcomes for c in o["clocks"]]
        cells.append(f"{np.median(clocks):.3f}, {np.quantile(clocks, 0.95):.3f}" if clocks else "")
    else:
        cells += [""] * 7
    seconds = np.sum([o["seconds"] for o in outcomes], axis=0)
    cells.append(f"{seconds[2] / max(seconds[1], 1e-9):.2f}")
    return "| " + " | ".join(cells) + " |"


HEAD = (
    "| family | networks | cameras accepted, of sound ones | faults named | focal length %, median, 95 % "
    "| rotation ° | position, % of the rig | stated errors hold, % (f R C) | in their ellipsoids, % "
    "| wrong | clocks, frames | network : pairs |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


def main(arguments: Namespace) -> None:
    origin, jobs = networks_asked_for(arguments)
    of_all = (arguments.lines, arguments.known)
    outcomes = outcomes_of(run, [(*job, *of_all) for job in jobs], arguments, origin)
    print(f"commit {origin}" if origin else "seeds by hand: no table to report")
    print(HEAD)
    for family in arguments.families.split(","):
        of_family = sorted((o for o in outcomes if o["family"] == family), key=lambda o: o["seed"])
        if of_family:
            print(row(of_family))
    if any(o["world"] for o in outcomes):
        print(f"\nvertical, floor and metres\n\n{worlds_table(outcomes)}")


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    add_networks(parser, "network", 10)
    parser.add_argument("--known", action="store_true", help="tell matrices and lenses, not poses")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every outcome there too")
    main(parser.parse_args())
