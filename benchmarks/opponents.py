"""Networks by COLMAP and Theia beside ours, from the same pairs: who places cameras how well?

Each program is given frontier points of all pairs that have a geometry, accepted or not. Neither COLMAP nor
Theia knows silhouettes; ours is given the recordings too, and finds tangents anew under the network. The
seeds of a reported table come from a commit's hash, as those of ``fresh.py``.
"""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures import TimeoutError as Late
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, replace
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from fresh_seeds import commit_seed, networks_asked_for
from networks_recordings import KNOWLEDGE as RECORDINGS
from networks_recordings import knowledge
from opponents_pairs import Rig, filmed, made_up
from opponents_views import KNOWLEDGE, Errors, Views, errors_of, views_of
from options import add_networks, natural
from tables import progress, table, write_json

from epibar.network import KnownCamera, Network, join_pairs
from epibar.synthetic import Camera

PROGRAMS = {"pycolmap": "pip install pycolmap", "pytheia": "pip install pytheia"}
"""What must be installed for the rows of the others."""
PATIENCE = 600.0
"""Seconds that a program may take for a network."""
FEWEST = 3
"""Cameras that are placed for figures: two have no position to be wrong in."""


@dataclass(frozen=True)
class Outcome:
    """One program with one kind of knowledge on one network.

    ``word`` says why there are no figures, or how many cameras ours refuses, which the figures have too.
    """

    network: str
    program: str
    knowledge: str
    cameras: int
    placed: int
    seconds: float
    errors: Errors | None
    word: str = ""

    def cell(self) -> str:
        """Focal length %, rotation °, position % of the rig: median, worst; how many placed, if not all."""
        some = "" if self.placed == self.cameras else f" ({self.placed} of {self.cameras})"
        if self.errors is None:
            return self.word + some
        some += f", {self.word}" if self.word else ""
        e = self.errors
        focal = [] if self.knowledge == "intrinsics" else [100 * e.focal]
        return "; ".join(map(middle_and_worst, [*focal, e.rotation, 100 * e.position])) + some


def middle_and_worst(values: Any) -> str:
    """Median and largest, for a table."""
    return f"{np.median(values):.2f}, {np.max(values):.2f}"


def beside(outcomes: list[Outcome]) -> str:
    """A row for each network and what is known of it, a column for each program, and their seconds."""
    programs = list(dict.fromkeys(one.program for one in outcomes))
    found = {(one.network, one.cameras, one.knowledge, one.program): one for one in outcomes}
    rows = []
    for network, cameras, words in dict.fromkeys(key[:3] for key in found):
        here = [found.get((network, cameras, words, program)) for program in programs]
        seconds = ", ".join("-" if one is None else f"{one.seconds:.0f}" for one in here)
        rows.append([network, cameras, words, *("" if one is None else one.cell() for one in here), seconds])
    return table(("network", "cameras", "known", *programs, "s"), rows)


CENTRED = "epibar, axis centred"
"""Ours solves for principal points unless it is told; COLMAP and Theia leave them in the middle."""


def known_to_us(true: Mapping[str, Camera], words: str, centred: bool) -> dict[str, KnownCamera]:
    """What ours is told, as the others are by `Views`."""
    if words == "intrinsics":
        return {n: replace(knowledge(one, "lens"), matrix=one.K) for n, one in true.items()}
    known = {name: knowledge(one, words) for name, one in true.items()}
    if centred:
        middles = {name: (np.array(one.size) - 1) / 2 for name, one in true.items()}
        return {name: replace(one, principal_point=middles[name]) for name, one in known.items()}
    return known


def standing(network: Network) -> dict[str, Camera]:
    """All cameras that stand, accepted or not."""
    return {
        name: Camera(one.matrix, one.rotation, one.translation, one.size, name)
        for name, one in network.cameras.items()
        if one.matrix is not None and one.rotation is not None and one.translation is not None
    }


def ours(rig: Rig, words: str, centred: bool = False) -> Outcome:
    """Join the pairs to one network."""
    known = known_to_us(rig.true, words, centred)
    started = time.perf_counter()
    network = join_pairs(rig.recordings, rig.pairs, rig.offsets, known=known)
    seconds = time.perf_counter() - started
    program = CENTRED if centred else "epibar"
    done = judged(rig, program, words, standing(network), seconds)
    refused = done.placed - sum(camera.accepted for camera in network.cameras.values())
    return replace(done, word=f"{refused} refused" if refused else "")


def by_colmap(views: Views, way: str) -> dict[str, Camera]:
    """Cameras that COLMAP places; in a process of its own."""
    from opponents_colmap import mapped

    return mapped(views, way)


def by_theia(views: Views, way: str) -> dict[str, Camera]:
    """Cameras that Theia places, with COLMAP's focal lengths where none are known; in its own process."""
    from opponents_colmap import view_graph
    from opponents_theia import placed

    return placed(view_graph(views), way, views.matrices is not None)


WAYS: dict[str, tuple[Callable[[Views, str], dict[str, Camera]], str, tuple[str, ...]]] = {
    "COLMAP, global": (by_colmap, "global", ("pycolmap",)),
    "COLMAP, incremental": (by_colmap, "incremental", ("pycolmap",)),
    "Theia, averaging": (by_theia, "averaging", ("pycolmap", "pytheia")),
    "Theia, global": (by_theia, "global", ("pycolmap", "pytheia")),
}


def missing(programs: Mapping[str, str] = PROGRAMS) -> set[str]:
    """Programs that are not installed; says how to install them."""
    absent = {name for name in programs if find_spec(name) is None}
    for name in sorted(absent):
        progress(f"{name} is not installed, so its rows are left out: {programs[name]}")
    return absent


def theirs(rig: Rig, words: str, arguments: Namespace, absent: set[str]) -> Iterator[Outcome]:
    """Let every other program place the cameras, each in a process that may fail."""
    pairs = {key: pair for key, pair in rig.pairs.items() if pair.accepted or not arguments.accepted}
    views = views_of(rig.true, pairs, words, arguments.points)
    for name, (place, way, needs) in WAYS.items():
        if absent & set(needs):
            continue
        started, found, word = time.perf_counter(), {}, ""
        worker = ProcessPoolExecutor(1, get_context("spawn"))
        try:
            found = worker.submit(place, views, way).result(PATIENCE)
        except BrokenProcessPool:
            word = "crashed"
        except Late:
            word = "slow"
            for process in list(worker._processes.values()):
                process.kill()
        except Exception as error:
            said = isinstance(error, RuntimeError) and len(str(error).split()) == 1
            word = str(error) if said else type(error).__name__
            progress(f"{rig.name}, {name}, {words}: {error}")
        worker.shutdown(cancel_futures=True)
        yield judged(rig, name, words, found, time.perf_counter() - started, word)


def judged(
    rig: Rig,
    program: str,
    words: str,
    found: dict[str, Camera],
    seconds: float,
    word: str = "",
) -> Outcome:
    """Hold what a program found against the truth."""
    enough = len(found) >= FEWEST
    errors = errors_of(rig.true, found) if enough else None
    why = word or ("" if enough else "fewer")
    done = Outcome(rig.name, program, words, len(rig.true), len(found), seconds, errors, why)
    progress(f"{rig.name}, {program}, {words}: {done.cell()}, {seconds:.0f} s")
    return done


def rigs_of(arguments: Namespace) -> Iterator[Rig]:
    """Made-up networks, or the real recordings of a folder."""
    if arguments.data:
        for name in RECORDINGS:
            folder = arguments.data / name
            if folder.is_dir():
                yield filmed(folder, arguments.lines, arguments.cache)
            else:
                progress(f"{folder}: not there, left out")
        return
    for family, seed in asked_for(arguments)[1]:
        yield made_up(family, seed, arguments.lines, arguments.cache)


def asked_for(arguments: Namespace) -> tuple[str | None, list[tuple[str, int]]]:
    """Networks by the seeds of HEAD, of another commit whose pairs are kept, or by hand."""
    if not arguments.commit:
        return networks_asked_for(arguments, OWN)
    return arguments.commit, [
        (family, commit_seed(arguments.commit, OWN + family, index))
        for family in arguments.families.split(",")
        for index in range(arguments.networks)
    ]


OWN = "opponents "
"""Makes the seeds this program's own."""


def main(arguments: Namespace) -> None:
    """Run all programs on all networks, one after the other, and print the table."""
    absent = missing()
    outcomes: list[Outcome] = []
    for rig in rigs_of(arguments):
        for words in KNOWLEDGE:
            outcomes.append(ours(rig, words))
            if words != "intrinsics":
                outcomes.append(ours(rig, words, centred=True))
            outcomes += theirs(rig, words, arguments, absent)
            write_json(arguments.json, arguments, [asdict(one) for one in outcomes], {})
    if not arguments.data:
        origin = asked_for(arguments)[0]
        print(f"seeds of commit {origin}" if origin else "seeds by hand: no table to report")
    print(beside(outcomes))


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    add_networks(parser, "network_plain,network", 2)
    parser.add_argument("--data", type=Path, metavar="DIR", help="real recordings, instead of networks")
    parser.add_argument(
        "--points", type=natural, default=1000, help="of each pair, for the others (default %(default)s)"
    )
    parser.add_argument("--accepted", action="store_true", help="the others are given accepted pairs alone")
    parser.add_argument(
        "--commit", metavar="HASH", help="seeds of this commit, in full, instead of those of HEAD"
    )
    parser.add_argument(
        "--cache",
        type=Path,
        metavar="DIR",
        default=Path("/tmp/epibar-opponents"),
        help="keep recordings and pairs there, and take them from it (default %(default)s)",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every outcome there too")
    main(parser.parse_args())
