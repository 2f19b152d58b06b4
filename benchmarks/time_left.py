"""Does the stated time left hold? Whole jobs, each look at its progress held against what was really left.

Videos of made-up crowds (as those of ``epibar demo``) are rendered once, into ``--cache``. Printed are, of
each job, stated over real seconds left at 25, 50 and 75 % of its time, their middle 90 % from 25 to 95 %, and
how many of those looks were between 0.6 and 1.6. With ``--stages`` also what the priors of ``jobs/tally.py``
and ``jobs/shares.py`` rest on: seconds of each task, and where in a search its stages begin.

With ``--clock cpu`` seconds are those that the process computes, in the estimate as in the truth: what else
the machine is doing does not count then, nor how well tasks run beside each other.
"""

from __future__ import annotations

import os
import time
from argparse import ArgumentParser
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from tables import mean, progress, table, write_json

import epibar
from epibar.jobs import JobProgress, Watch
from epibar.jobs import runner as runners
from epibar.jobs import tally as tallies
from epibar.jobs.pace import Pace
from epibar.jobs.shares import BEGINS
from epibar.jobs.stages import MATCHING, Task
from epibar.synthetic.staging import stage

WITHIN = (0.6, 1.6)
FROM, UNTIL = 0.25, 0.95
AT = (0.25, 0.5, 0.75)
PROCESSES = 2

Clock = Callable[[], float]


@dataclass(frozen=True)
class Case:
    """A job: the width of each camera's frames, which are 4:3, and how long each films people.

    With ``before`` only so many cameras are done first, whose results are then kept.
    """

    widths: tuple[int, ...]
    seconds: float
    before: int = 0
    processes: bool = False
    time_offset: Any = "auto"


CASES = {
    "two cameras": Case((480, 480), 20.0),
    "three small": Case((320, 320, 320), 15.0),
    "three, long": Case((320, 320, 320), 80.0),
    "three large": Case((960, 960, 960), 12.0),
    "four": Case((480,) * 4, 20.0),
    "four, of three sizes": Case((240, 320, 480, 960), 15.0),
    "four, synchronised": Case((320,) * 4, 20.0, time_offset=0.0),
    "a fourth camera, three kept": Case((480,) * 4, 20.0, before=3),
    "pairs only, recordings kept": Case((480,) * 4, 20.0, before=-1),
    "everything kept": Case((480,) * 4, 20.0, before=4),
    "three, in two processes": Case((320, 320, 320), 15.0, processes=True),
}


class Follower(Watch):
    """Keeps what is told of a job, with its times."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.began = clock()
        self.shown: list[tuple[float, float, float | None]] = []

    def pace(self, progress: JobProgress) -> None:
        """Keep it."""
        self.shown.append((self.clock() - self.began, progress.share, progress.seconds_left))


@dataclass(frozen=True)
class Held:
    """What became of one job."""

    case: str
    seconds: float
    at: dict[float, float | None]
    ratios: list[float]
    monotone: bool
    ends_at_one: bool
    load: float

    @property
    def within(self) -> float:
        """Share of looks whose stated time is within the bounds."""
        return mean(WITHIN[0] <= ratio <= WITHIN[1] for ratio in self.ratios) if self.ratios else float("nan")

    def row(self) -> list[str]:
        """One line of the table."""
        low, high = np.quantile(self.ratios, (0.05, 0.95)) if self.ratios else (np.nan, np.nan)
        at = ["-" if self.at[share] is None else f"{self.at[share]:.2f}" for share in AT]
        spread = f"{low:.2f} to {high:.2f}"
        sound = "yes" if self.monotone and self.ends_at_one else "NO"
        return [self.case, f"{self.seconds:.0f}", *at, spread, f"{100 * self.within:.0f} %", sound]


def videos(case: Case, seed: int, cache: Path) -> list[Path]:
    """Render the videos of a case that are not there yet."""
    paths = []
    for index, width in enumerate(case.widths):
        path = cache / f"{len(case.widths)}x{case.seconds:g}s_{width}_{seed}" / f"cam{index + 1}.mp4"
        paths.append(path)
        if path.exists():
            continue
        progress(f"rendering {path}")
        path.parent.mkdir(parents=True, exist_ok=True)
        staging = stage(
            seed,
            cameras=len(case.widths),
            walkers=6,
            seconds=case.seconds,
            size=(width, width * 3 // 4),
            unsynchronised=case.time_offset != 0.0,
        )
        unfinished = path.with_name(f"unfinished_{path.name}")
        staging.render(index, unfinished)
        unfinished.rename(path)
    return paths


def held(name: str, case: Case, seed: int, cache: Path, out: Path, clock: Clock) -> Held:
    """Run a job, and hold what it said against what was."""
    paths = videos(case, seed, cache)
    options: dict[str, Any] = {"time_offset": case.time_offset}
    if case.before:
        epibar.calibrate_all(
            paths[: case.before] if case.before > 0 else paths, out, watch=Watch(), **options
        )
    if case.before < 0:
        for path in [*out.glob("pairs/*.npz"), out / "network.json"]:
            path.unlink()
    follower = Follower(clock)
    executor: Executor | None = None
    if case.processes:
        executor = ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn"))
    epibar.calibrate_all(paths, out, watch=follower, executor=executor, **options)
    if executor is not None:
        executor.shutdown()
    end = follower.shown[-1][0]
    shares = [share for _, share, _ in follower.shown]
    ratios = [
        (at / end, left / (end - at))
        for at, _, left in follower.shown
        if left is not None and FROM * end <= at <= UNTIL * end
    ]
    # What is shown at a moment was told last before it.
    at = {share: next((r for t, r in reversed(ratios) if t <= share + 0.01), None) for share in AT}
    return Held(
        name,
        end,
        at,
        [ratio for _, ratio in ratios],
        all(a <= b for a, b in pairwise(shares)),
        shares[-1] == 1.0,
        os.getloadavg()[0],
    )


@contextmanager
def tasks_timed(clock: Clock) -> Iterator[tuple[dict[str, list[str]], dict[str, list[float]]]]:
    """Seconds of tasks, by stage, beside their priors, and where in a round of a search its stages began."""
    seconds: dict[str, list[str]] = defaultdict(list)
    begins: dict[str, list[float]] = defaultdict(list)
    heard: dict[Any, list[tuple[float, str]]] = defaultdict(list)
    ended, tell = Pace.ended, Task.progress

    def keep(self: Task, at: str, share: float) -> None:
        tell(self, at, share)
        if self.stage == MATCHING and share == 0.0 and at in BEGINS:
            heard[self.of].append((clock(), at))

    def over(self: Pace, task: Any, took: float | None = None) -> None:
        work = self._running[task]
        ended(self, task, took)
        seconds[work.stage].append(f"{took or work.elapsed:.1f} ({self._prior(work.stage, work.prior):.1f})")
        rounds = [at for at, what in heard[task] if what == "candidates"] + [clock()]
        for first, after in pairwise(rounds):
            for at, what in heard[task]:
                if first <= at < after:
                    begins[what].append((at - first) / (after - first))

    Pace.ended, Task.progress = over, keep  # type: ignore[method-assign]
    try:
        yield seconds, begins
    finally:
        Pace.ended, Task.progress = ended, tell  # type: ignore[method-assign]


@contextmanager
def timed_by(clock: Clock) -> Iterator[None]:
    """Jobs estimate by another clock than the usual one, which runs the faster the more compute."""
    usual, sharing = runners.Tally, tallies.SHARING
    runners.Tally = partial(usual, clock=clock)  # type: ignore[misc, assignment]
    tallies.SHARING = dict.fromkeys(sharing, 1.0)
    try:
        yield
    finally:
        runners.Tally, tallies.SHARING = usual, sharing  # type: ignore[misc]


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), metavar="CASE")
    parser.add_argument("--seed", type=int, default=1, help="of the crowd (default %(default)s)")
    parser.add_argument("--cache", type=Path, default=Path("build/time_left"), help="default %(default)s")
    parser.add_argument("--stages", action="store_true", help="seconds of tasks, stages of searches")
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall", help="default %(default)s")
    parser.add_argument("--json", type=Path, metavar="FILE")
    args = parser.parse_args()
    clock = time.process_time if args.clock == "cpu" else time.monotonic
    found: list[Held] = []
    for name in args.cases:
        case = CASES[name]
        with ExitStack() as stack:
            if args.clock == "cpu":
                stack.enter_context(timed_by(clock))
            timed = stack.enter_context(tasks_timed(clock)) if args.stages else ({}, {})
            folder = stack.enter_context(TemporaryDirectory())
            found.append(held(name, case, args.seed, args.cache, Path(folder) / "out", clock))
        progress(" ".join(found[-1].row()) + f", load {found[-1].load:.1f}")
        for of_what, of_it in timed[0].items():
            progress(f"  {of_what}, seconds (and prior): " + ", ".join(of_it))
        for what, shares in timed[1].items():
            progress(f"  {what} begins at {mean(shares):.2f} of a round, mean of {len(shares)}")
        if args.json:
            write_json(args.json, args, found, {one.case: one.within for one in found})
    bounds = f"between {WITHIN[0]} and {WITHIN[1]}"
    columns = ["job", "seconds", "at 25 %", "at 50 %", "at 75 %", "90 % of looks", bounds, "share sound"]
    print(table(columns, [one.row() for one in found]))


if __name__ == "__main__":
    main()
