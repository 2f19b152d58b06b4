"""One more camera for a network that stands: made-up networks of which one is left out, and then added.

The stored network is the true one, or (``--stored calibrated``) what the package makes of other footage of
the same cameras, nothing known of their lenses. All cameras start together, which is not told. Beside the
camera that belongs there one is offered that filmed other walkers, and one whose film runs backwards. Seeds
of a reported table come from the commit's own hash.
"""

from __future__ import annotations

import os
import time
from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from check_networks import (
    CALIBRATED,
    CHECKED,
    FPS,
    PAUSE,
    calibrated_network,
    recorded,
    situation,
    true_network,
)
from fresh_seeds import sizes_asked_for
from networks import outcomes_of
from options import names_of, natural, numbers
from tables import table

KINDS = ("right", "stranger", "reversed")


def without(network: Any, name: str) -> Any:
    """Return a network without a camera, as if it had never been one of it."""
    from epibar.network.parts import NetworkPairs

    pairs = [pair for pair in network.pairs.values() if name not in (pair.a, pair.b)]
    return replace(
        network,
        cameras={key: one for key, one in network.cameras.items() if key != name},
        clocks={key: one for key, one in network.clocks.items() if key != name},
        pairs=NetworkPairs(pairs),
    )


def film_of(made: Any, index: int, kind: str, first: int, last: int, arguments: Namespace) -> Any:
    """Record the camera that is to be added: before the others' walkers, before other ones, or backwards."""
    from epibar import Recording

    film = made.films[index]
    if kind == "stranger":
        other = situation(made.seed + 1, len(made.cameras), arguments.minutes)
        film = replace(other.films[index], camera=film.camera)
    if kind == "reversed":
        masks = np.stack([np.array(mask) for mask in film.iter_masks(first, last)])[::-1]
        return Recording.from_masks(masks, fps=FPS, lines=arguments.lines, seed=index)
    return recorded(film, first, last, index, arguments.lines)


def run(count: int, seed: int, arguments: Namespace) -> list[dict[str, Any]]:
    """Offer each kind of camera to one network."""
    made = situation(seed, count, arguments.minutes)
    whole = true_network(made)
    if arguments.stored == "calibrated":
        whole = calibrated_network(made, 100)
    index = int(np.random.default_rng((seed, 98)).integers(2, count))
    name = made.names[index]
    first = CALIBRATED + PAUSE
    last = first + arguments.minutes * CHECKED
    outcome: dict[str, Any] = {"cameras": count, "seed": seed, "name": name}
    left = [camera for key, camera in whole.cameras.items() if key != name]
    if not all(camera.accepted for camera in left):
        return [{**outcome, "kind": "not calibrated", "reason": whole.reason}]
    stored = without(whole, name)
    stored = replace(stored, accepted=True)
    films = {
        film.camera.name: recorded(film, first, last, k, arguments.lines) for k, film in enumerate(made.films)
    }
    outcomes = []
    for kind in arguments.kinds:
        offered = films
        if kind != "right":
            offered = {**films, name: film_of(made, index, kind, first, last, arguments)}
        began = time.perf_counter()
        extended = stored.extended(offered, seed=seed % 2**32)
        found = {**outcome, "kind": kind, "seconds": time.perf_counter() - began}
        found |= {"added": name in extended.cameras, "reason": extended.reason}
        if name in extended.cameras:
            found |= held_against(made, extended, name, arguments.stored)
            found["reason"] = extended.cameras[name].reason
        outcomes.append(found)
    return outcomes


def held_against(made: Any, network: Any, name: str, stored: str) -> dict[str, Any]:
    """Errors and those stated: focal length, rotation (°), share of the rig; and of the clock, seconds.

    Where the true network is stored the new camera is held against the truth as it stands; otherwise after
    the similarity that lays all cameras best over the true ones, as errors of networks are stated.
    """
    from epibar.geometry.vectors import angle_between
    from epibar.synthetic.network_errors import accepted_cameras, network_errors

    found = accepted_cameras(network)
    places = np.array([one.centre for one in found.values()])
    rig = max(np.linalg.norm(p - q) for p in places for q in places)
    wrong = network_errors(made, found)[name]
    errors = [abs(wrong.focal), wrong.rotation, wrong.position]
    if stored == "true":
        (truth,) = (camera for camera in made.cameras if camera.name == name)
        errors[1] = angle_between(found[name].R, truth.R)
        errors[2] = float(np.linalg.norm(found[name].centre - truth.centre) / rig)
    one, clock = network.cameras[name], network.clocks[name]
    pairs = [pair for pair in network.pairs.values() if name in (pair.a, pair.b)]
    return {
        "errors": errors,
        "stated": [one.expected["focal"], one.expected["rotation"], one.expected["position"] / rig],
        "offset": abs(clock.offset),
        "offset_stated": clock.offset_error,
        "confirmed": sum(pair.status == "confirmed" for pair in pairs),
        "evidence": one.evidence,
    }


HEAD = (
    *("camera", "cameras", "asked", "added", "focal length: error, stated, %", "rotation, °"),
    *("position, % of the rig", "within, % (f R C)", "clock off, s: median, most", "seconds"),
)


def row(kind: str, count: int, outcomes: list[dict[str, Any]]) -> list[str]:
    """One kind of camera in a row of the table: medians."""
    right = [one for one in outcomes if one["added"]]
    cells = [kind, str(count), str(len(outcomes)), str(len(right))]
    if right:
        errors, stated = (np.array([one[key] for one in right]) for key in ("errors", "stated"))
        for k, scale in enumerate((100, 1, 100)):
            both = (scale * np.median(values[:, k]) for values in (errors, stated))
            cells.append(", ".join(f"{value:.2g}" for value in both))
        cells.append(" ".join(f"{100 * share:.0f}" for share in (errors <= stated).mean(axis=0)))
        late = [one["offset"] for one in right]
        cells.append(f"{np.median(late):.3f}, {max(late):.3f}")
    else:
        cells += [""] * 5
    return [*cells, f"{np.median([one['seconds'] for one in outcomes]):.0f}"]


def main(arguments: Namespace) -> None:
    origin, jobs = sizes_asked_for(arguments, "added")
    outcomes = outcomes_of(run, [(*job, arguments) for job in jobs], arguments, origin)
    print(f"commit {origin}" if origin else "seeds by hand: no table to report")
    rows = [
        row(kind, count, chosen)
        for kind in arguments.kinds
        for count in arguments.cameras
        if (chosen := [o for o in outcomes if (o["kind"], o["cameras"]) == (kind, count)])
    ]
    print(table(HEAD, rows))
    lost = sum(one["kind"] == "not calibrated" for one in outcomes)
    if lost:
        print(f"{lost} networks were not accepted, and nothing was added to them")


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--networks", type=natural, default=10, help="of each size (default %(default)s)")
    parser.add_argument(
        "--cameras", type=numbers, default=[4, 6], help="sizes, with the new one (default 4,6)"
    )
    parser.add_argument("--minutes", type=natural, default=1, help="of new footage (default %(default)s)")
    parser.add_argument(
        "--kinds", type=names_of(KINDS), default=list(KINDS), help=f"some of: {', '.join(KINDS)}"
    )
    parser.add_argument("--stored", choices=("true", "calibrated"), default="true", help="what is stored")
    parser.add_argument("--seeds", type=numbers, help="such as 1-5: for a trial, instead of the commit's")
    parser.add_argument("--lines", type=natural, default=2500, help="per camera (default %(default)s)")
    parser.add_argument("--workers", type=natural, default=os.cpu_count() or 1)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every outcome there too")
    main(parser.parse_args())
