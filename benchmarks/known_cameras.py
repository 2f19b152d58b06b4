"""Fresh networks that are told true and false things of their cameras: is it noticed, and what comes of it?

Clocks and pairs are searched for once, as nothing told changes them; each telling is then joined on its own.
The camera that something false is told of is the last. Seeds come from the commit's own hash, as those of
``networks.py``, and are other ones.
"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from fresh_seeds import networks_asked_for
from networks import distortions, errors, outcomes_of, shares_held, wrong_cameras
from options import add_networks
from tables import table

FOCAL_ERROR = 0.001
"""Of a focal length that is told alone."""


def priors(cameras: dict[str, Any]) -> dict[str, tuple[dict[str, Any], set[str]]]:
    """What is known of true cameras, by its name in the table; and the cameras of which it is false."""
    from epibar import KnownCamera

    last = list(cameras)[-1]

    def whole(camera: Any, focal: float = 1.0, shift: float = 0.0) -> KnownCamera:
        matrix = np.array(camera.K) * [[focal, 1, 1], [1, focal, 1], [1, 1, 1]]
        matrix[0, 2] += shift * camera.size[0]
        return KnownCamera(matrix=matrix, distortions=distortions(camera))

    def of_all(tell: Callable[[Any], KnownCamera]) -> dict[str, KnownCamera]:
        return {name: tell(camera) for name, camera in cameras.items()}

    true = of_all(whole)
    unbent = {name for name, camera in cameras.items() if np.any(distortions(camera))}
    return {
        "nothing": ({}, set()),
        "true matrices and lenses": (true, set()),
        "true focal lengths": (
            of_all(lambda c: KnownCamera(focal=float(c.K[0, 0]), focal_error=FOCAL_ERROR)),
            set(),
        ),
        "true lenses": (of_all(lambda c: KnownCamera(distortions=distortions(c))), set()),
        "true principal points": (of_all(lambda c: KnownCamera(principal_point=c.K[:2, 2])), set()),
        "one focal length 5 % long": ({**true, last: whole(cameras[last], focal=1.05)}, {last}),
        "one focal length 15 % long": ({**true, last: whole(cameras[last], focal=1.15)}, {last}),
        "one principal point 3 % of the width aside": (
            {**true, last: whole(cameras[last], shift=0.03)},
            {last},
        ),
        "no lens bends": (of_all(lambda c: KnownCamera(distortions=np.zeros(5))), unbent),
    }


def run(family: str, seed: int, lines: int) -> list[dict[str, Any]]:
    """Draw a situation, record its cameras, search its pairs, and join them under each telling."""
    from epibar import synthetic
    from epibar.calibration import SEARCH_SECONDS
    from epibar.network import find_offsets, join_pairs, pairs_to_search, search_pairs

    situation = synthetic.situation(seed, family)
    recordings = {c.name: situation.recording(i, lines) for i, c in enumerate(situation.cameras)}
    offsets = find_offsets(recordings, SEARCH_SECONDS)
    pairs = search_pairs(recordings, pairs_to_search(recordings, offsets), offsets, seed=seed % 2**32)
    found = []
    for words, (known, false_of) in priors({c.name: c for c in situation.cameras}).items():
        network = join_pairs(recordings, pairs, offsets, known=known)
        found.append(
            {
                "family": family,
                "seed": seed,
                "known": words,
                "false_of": sorted(false_of),
                "cameras": len(recordings),
                "status": {name: camera.status for name, camera in network.cameras.items()},
                "errors": errors(situation, network),
                "between": between(situation, network),
            }
        )
    return found


def between(situation: Any, network: Any) -> list[float]:
    """How wrong the rotations between accepted cameras are, degrees, two by two."""
    from epibar import synthetic
    from epibar.geometry.vectors import angle_between

    found = synthetic.accepted_cameras(network)
    true = {c.name: c.R for c in situation.cameras}
    return [angle_between(found[p].R @ found[q].R.T, true[p] @ true[q].T) for p, q in combinations(found, 2)]


def row(words: str, outcomes: list[dict[str, Any]]) -> list[str]:
    """One telling in a row of the table."""
    contradicted = [{n for n, s in o["status"].items() if s == "contradicted"} for o in outcomes]
    named = sum(len(c & set(o["false_of"])) for c, o in zip(contradicted, outcomes, strict=True))
    others = sum(len(c - set(o["false_of"])) for c, o in zip(contradicted, outcomes, strict=True))
    cameras = np.array([e for o in outcomes for e in o["errors"].values()]).reshape(-1, 6)
    turned = [angle for o in outcomes for angle in o["between"]]
    return [
        words,
        str(len(outcomes)),
        f"{named} of {sum(len(o['false_of']) for o in outcomes)}",
        str(others),
        f"{len(cameras)} of {sum(o['cameras'] for o in outcomes)}",
        f"{np.median(turned):.2f}, {np.quantile(turned, 0.95):.2f}" if turned else "",
        shares_held(cameras) if len(cameras) else "",
        str(wrong_cameras(cameras)),
    ]


HEAD = [
    "known",
    "networks",
    "false ones contradicted",
    "true ones contradicted",
    "cameras accepted",
    "rotation between two °, median, 95 %",
    "stated errors hold, % (f R C)",
    "wrong",
]


def main(arguments: Namespace) -> None:
    origin, jobs = networks_asked_for(arguments, "told ")
    outcomes = outcomes_of(run, [(*job, arguments.lines) for job in jobs], arguments, origin)
    print(f"commit {origin}" if origin else "seeds by hand: no table to report")
    for family in arguments.families.split(","):
        of_family = [o for o in outcomes if o["family"] == family]
        priors_tried = dict.fromkeys(o["known"] for o in of_family)
        rows = [row(words, [o for o in of_family if o["known"] == words]) for words in priors_tried]
        print(f"\n{family}\n\n{table(HEAD, rows)}")


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    add_networks(parser, "network", 5)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every outcome there too")
    main(parser.parse_args())
