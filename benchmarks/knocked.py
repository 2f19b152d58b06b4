"""One of four cameras is turned a little at half time: is it named, and what becomes of the others?

Made-up networks as those of ``networks.py``, with one clock at 12.5 frames a second and 900 frames each.
Errors are those of the cameras that are accepted, the turned one held against where it stood first.
"""

from __future__ import annotations

from argparse import ArgumentParser
from dataclasses import replace
from typing import Any

import numpy as np
from networks import errors
from options import add_seeds, natural
from tables import progress, table

import epibar
from epibar.synthetic.networks import NETWORK
from epibar.synthetic.settings import draw, turned


def situation(seed: int, frames: int) -> Any:
    """Draw four cameras that started together."""
    rig = replace(NETWORK.rig, sizes=((640, 480),))
    setting = replace(
        NETWORK, cameras=(4, 4), frames=(frames, frames), clocks=None, rates=(12.5,), rig=rig, budget=np.inf
    )
    return draw(seed, "network", setting)


def filmed(made: Any, camera: int, degrees: float) -> Any:
    """The same with one camera turned at half time."""
    film = made.films[camera]
    if degrees == 0:
        return made
    after = turned(film.camera, np.random.default_rng(5), degrees)
    film = replace(film, knocked=after, knocked_at=len(film.moments) // 2)
    return replace(made, films=[film if i == camera else one for i, one in enumerate(made.films)])


def run(seed: int, degrees: float, frames: int, lines: int) -> list[str]:
    """Calibrate one network; a row of the table."""
    made = situation(seed, frames)
    camera = int(np.random.default_rng(seed).integers(len(made.cameras)))
    film = filmed(made, camera, degrees)
    recordings = {c.name: film.recording(i, lines) for i, c in enumerate(film.cameras)}
    network = epibar.calibrate_network(recordings, seed=1, time_offset=0.0)
    found = errors(made, network)
    named = ", ".join(f"{name} {network.cameras[name].status}" for name in network.left_out)
    cells = [f"{seed}", f"{degrees:g}", made.cameras[camera].name, named or "nobody", str(len(found))]
    for k, unit in ((0, 100), (1, 1), (2, 100)):
        worst = max(found.values(), key=lambda e: e[k] / e[k + 3], default=None)
        cells.append("-" if worst is None else f"{unit * worst[k]:.2f} ({unit * worst[k + 3]:.2f})")
    return cells


def main() -> None:
    """Every seed with every turn, and one table."""
    parser = ArgumentParser(description=__doc__.splitlines()[0])
    add_seeds(parser, 4)
    parser.add_argument("--degrees", type=float, nargs="+", default=[0.0, 0.5, 1.0, 1.5])
    parser.add_argument("--frames", type=natural, default=900)
    parser.add_argument("--lines", type=natural, default=8000)
    args = parser.parse_args()
    rows = []
    for seed in args.seeds:
        for degrees in args.degrees:
            rows.append(run(seed, degrees, args.frames, args.lines))
            progress(" ".join(rows[-1]))
    head = ["seed", "turned by, °", "camera", "left out", "accepted", "worst focal length %, beside stated"]
    print(table([*head, "rotation °", "position, % of the rig"], rows))


if __name__ == "__main__":
    main()
