"""One network of many unknown cameras: how many searches, seconds by stage, memory, and how far off.

Made-up walkers, short footage, lenses and clocks unknown. Stages are those of ``calibrate_network``, called
one by one. The largest share of the time is that of searches, whose number is to grow with the cameras and
not with their pairs.
"""

from __future__ import annotations

import hashlib
import resource
import time
from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from options import natural, numbers
from tables import progress, table, write_json

import epibar
from epibar import Calibration, Recording, synthetic
from epibar.calibration import SEARCH_SECONDS
from epibar.network import ClockOffsets, find_offsets, join_pairs, pairs_to_search, search_pairs
from epibar.synthetic.networks import NETWORK, hand_started
from epibar.synthetic.settings import draw

Pairs = dict[tuple[str, str], tuple[Calibration, float]]
"""What the search of a pair found, and the seconds that it took."""

STAGES = ("record", "clocks", "choose", "searches", "network")
IN_A_ROOM = 20
"""Cameras about a room of 8 × 8 m; for more of them its sides grow as the root of their number."""


def situation(seed: int, cameras: int, walkers: int, frames: int) -> Any:
    """Draw cameras of 640×480 all around a room, started by hand."""
    side = 8.0 * max(1.0, cameras / IN_A_ROOM) ** 0.5
    return draw(
        seed,
        "network",
        replace(
            NETWORK,
            count=(walkers, walkers),
            area=((side, side), (side, side)),
            rig=replace(NETWORK.rig, layouts=("ring",), sizes=((640, 480),)),
            cameras=(cameras, cameras),
            frames=(frames, frames),
            clocks=hand_started,
            budget=np.inf,
        ),
    )


def recorded(made: Any, lines: int, keep: Path | None) -> dict[str, Recording]:
    """Record every camera, or load what an earlier run has kept."""
    found = {}
    for index, camera in enumerate(made.cameras):
        name = f"{len(made.cameras)}-{made.seed}-{made.clocks[index].frames}-{lines}-{camera.name}.npz"
        path = None if keep is None else keep / name
        if path is not None and path.exists():
            found[camera.name] = Recording.load(path)
            continue
        progress(f"{camera.name} of {len(made.cameras)}")
        found[camera.name] = made.recording(index, lines)
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            found[camera.name].save(path)
    return found


def searched(
    args: Namespace,
    made: Any,
    recordings: dict[str, Recording],
    chosen: list[tuple[int, int]],
    offsets: ClockOffsets,
) -> Pairs:
    """Search every chosen pair, or load what an earlier run has kept."""
    found: Pairs = {}
    made_by = hashlib.sha256(Path(epibar._core.__file__).read_bytes()).hexdigest()[:12]
    for a, b in chosen:
        names = made.cameras[a].name, made.cameras[b].name
        frames = offsets.between(list(recordings.values()), a, b)
        what = (len(recordings), made.seed, args.frames, args.lines, *names, f"{frames:.4f}", made_by)
        name = "-".join(map(str, what)) + ".npz"
        path = None if args.keep is None else args.keep / name
        if path is not None and path.exists():
            taken = float(path.with_suffix(".seconds").read_text())
            found[names] = Calibration.load(path), taken
            continue
        progress(f"{names[0]} {names[1]}, search {len(found) + 1} of {len(chosen)}")
        started = time.perf_counter()
        cal = search_pairs(recordings, [(a, b)], offsets, seed=made.seed)[names]
        found[names] = cal, time.perf_counter() - started
        if path is not None:
            path.with_suffix(".seconds").write_text(repr(found[names][1]))
            cal.save(path)
    return found


def run(args: Namespace, cameras: int, seed: int) -> dict[str, Any]:
    """Calibrate one network, stage by stage, and hold it against the truth."""
    made = situation(seed, cameras, args.walkers, args.frames)
    clock = [time.perf_counter()]

    def lap() -> None:
        clock.append(time.perf_counter())

    recordings = recorded(made, args.lines, args.keep)
    lap()
    offsets = find_offsets(recordings, SEARCH_SECONDS)
    lap()
    chosen = pairs_to_search(recordings, offsets)
    lap()
    timed = searched(args, made, recordings, chosen, offsets)
    pairs = {names: cal for names, (cal, _) in timed.items()}
    lap()
    network = join_pairs(recordings, pairs, offsets)
    lap()
    seconds = dict(zip(STAGES, map(float, np.diff(clock)), strict=True))
    seconds["searches"] = sum(taken for _, taken in timed.values())
    found = synthetic.accepted_cameras(network)
    wrong = synthetic.network_errors(made, found) if len(found) > 1 else {}
    stated = {name: (network.cameras[name].expected or {})["rotation"] for name in wrong}
    return {
        "cameras": cameras,
        "seed": seed,
        "pairs": len(network.pairs),
        "searched": len(chosen),
        "by_themselves": sum(pair.accepted for pair in pairs.values()),
        "confirmed": {
            where: sum(
                network.pairs[key].status == "confirmed" for key in network.pairs if (key in pairs) == first
            )
            for where, first in (("searched", True), ("predicted", False))
        },
        "left_out": {name: network.cameras[name].status for name in network.left_out},
        "wrong": sorted(n for n, e in wrong.items() if e.rotation > max(1.0, 3 * stated[n])),
        "errors": {n: [abs(e.focal), e.rotation, e.position] for n, e in wrong.items()},
        "seconds": seconds,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def cells(outcome: dict[str, Any]) -> list[str]:
    """One network in a row of the table."""
    seconds = outcome["seconds"]
    of_pairs = seconds["clocks"] + seconds["choose"] + seconds["searches"]
    errors = np.array(list(outcome["errors"].values())).reshape(-1, 3) * [100, 1, 100]
    others = outcome["pairs"] - outcome["searched"]
    return [
        str(outcome["cameras"]),
        str(outcome["pairs"]),
        str(outcome["searched"]),
        f"{outcome['confirmed']['searched']}, {outcome['confirmed']['predicted']} of {others}",
        *(f"{seconds[stage]:.0f}" for stage in STAGES),
        f"{100 * seconds['network'] / of_pairs:.0f} %",
        f"{outcome['memory']:.0f}",
        str(len(errors)),
        str(len(outcome["wrong"])),
        *(f"{np.median(e):.2f}, {max(e):.2f}" for e in errors.T if len(e)),
        *["-"] * (0 if len(errors) else 3),
    ]


HEAD = (
    *("cameras", "pairs", "searches", "confirmed: searched, others"),
    *(f"{stage}, s" for stage in STAGES),
    *("network : pairs", "memory, MB", "accepted", "wrong", "focal length %", "rotation °"),
    "position, % of the rig",
)


def main() -> None:
    """Run networks one after the other, and print the table."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--cameras", type=numbers, default=[8, 20], help="default: 8,20")
    parser.add_argument("--seeds", type=numbers, default=[1], help="such as 1-3 (default: 1)")
    parser.add_argument("--walkers", type=natural, default=5, help="default: %(default)s")
    parser.add_argument("--frames", type=natural, default=900, help="of each camera (default %(default)s)")
    parser.add_argument("--lines", type=natural, default=10_000, help="per camera (default %(default)s)")
    parser.add_argument(
        "--keep", type=Path, metavar="DIR", help="keep recordings and pairs there, and take them from it"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every outcome there too")
    args = parser.parse_args()
    outcomes = []
    for cameras in args.cameras:
        for seed in args.seeds:
            outcomes.append(run(args, cameras, seed))
            progress(str(outcomes[-1]))
            write_json(args.json, args, outcomes, {})
    print(table(HEAD, map(cells, outcomes)))


if __name__ == "__main__":
    main()
