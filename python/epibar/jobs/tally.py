"""What a run has done and what is before it, and what it tells of that.

The priors of :class:`~epibar.jobs.pace.Pace` are here: seconds on one machine, of which only the ratios count
once something is measured. ``benchmarks/time_left.py`` with its stages prints what they rest on.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import Executor
from typing import Any

from .camera_sizes import frames_and_pixels
from .inputs import (
    CLOCKS_FILE,
    NETWORK_FILE,
    CameraInput,
    CameraPair,
    Job,
    PairOptions,
    pair_file,
    pair_stems,
)
from .pace import JobProgress, Pace, Row
from .stages import CLOCKS, MATCHING, NETWORK, RECORDING, STAGES, Task
from .watch import Watch

__all__ = ["Tally", "search_rounds", "workers_of"]

WRITING = "writing"

SHARING = {RECORDING: 0.3, MATCHING: 0.95}
"""What tasks in threads of one process take from each other, see :class:`Pace`: pairs share one pool."""

A_FRAME, A_MEGAPIXEL = 0.0105, 0.07
"""Seconds to record a frame, and a megapixel of it."""
A_MASK = 0.3
"""Share of that which ready masks take."""
A_SAVED = 0.1
"""Seconds to load a recording."""
SEARCHES = {1: 10.0, 2: 11.0, 3: 25.0}
"""Seconds of the search of a pair, by its rounds."""
BY_LINES = 0.2
"""Share of that which the paper's method takes."""
CLOCKS_OF_TWO = 0.0025
"""Seconds to compare the clocks of two cameras, for each frame."""
A_NETWORK = 4.0, 0.4
"""Seconds to join pairs: of the network, and of each of its pairs."""
TO_WRITE = 1.0, 0.5
"""Seconds to write tables and report: of the run, and of each camera."""
ONLY_TABLES = 0.3
"""Share of that where no report is written."""

FRAMES = 600
"""Of a recording of which nothing is known."""

LATELY = 10.0
"""Seconds over which frames a second are counted."""

PAIRS_A_CAMERA = 3
"""Pairs that are searched at most for each of many cameras."""


def search_rounds(options: PairOptions) -> int:
    """How often the search of a pair goes through its stages: again by each clock that it learns."""
    if isinstance(options.time_offset, str):
        return 3
    return 2 if options.sharpen_offset else 1


def workers_of(executor: Executor) -> int:
    """How many tasks an executor does at a time, as far as it tells."""
    if isinstance(found := getattr(executor, "workers", None), int):
        return max(found, 1)
    found = getattr(executor, "_max_workers", None)
    return found if isinstance(found, int) else os.cpu_count() or 1


class Tally:
    """What is done of one run, and what it tells.

    Parameters
    ----------
    job : Job
    watch : Watch
    workers : int
        Tasks that run at a time.
    together : bool
        They are threads of this process, which take time from each other and tell how far they are.
    """

    def __init__(
        self,
        job: Job,
        watch: Watch,
        workers: int,
        together: bool,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._job = job
        self._watch = watch
        self._clock = clock
        self._together = together
        self._waits = job.pair.time_offset == "auto" or job.chooses_pairs
        pairs_wait = ((RECORDING,), (CLOCKS,), (MATCHING,))
        phases = pairs_wait if self._waits else ((RECORDING, MATCHING), (CLOCKS,))
        self._pace = Pace((*phases, (NETWORK,), (WRITING,)), workers, SHARING if together else None, clock)
        self._done = dict.fromkeys(STAGES, 0)
        self._total = dict.fromkeys(STAGES, 0)
        self.to_record = 0
        self._recorded: list[int] = []
        self._frames: dict[CameraInput | CameraPair | str, deque[tuple[float, int]]] = {}

    def plan(self, cameras: Collection[CameraInput]) -> None:
        """Expect that these cameras are recorded, and of what follows all that seems not to be kept."""
        job, new = self._job, set(cameras)
        count = len(job.cameras)
        self.to_record = self._total[RECORDING] = len(cameras)
        self._pace.expect(RECORDING, {camera: self._of_camera(camera) for camera in cameras})
        stems = pair_stems(job.cameras)
        pairs = [
            (a, b)
            for a, b in job.pairs
            if job.fresh or a in new or b in new or not pair_file(job.out, stems[a.name, b.name]).exists()
        ]
        if job.chooses_pairs:
            pairs = pairs[: PAIRS_A_CAMERA * count]
        searched = self._search(search_rounds(job.pair) if count == 2 else min(search_rounds(job.pair), 2))
        self._pace.expect(MATCHING, dict.fromkeys(pairs, searched))
        self._stage(CLOCKS, self._all_clocks if self._seeks_clocks and self._misses(CLOCKS_FILE) else None)
        alone, each = A_NETWORK
        joins = job.pair.method == "frontier" and (pairs or self._misses(NETWORK_FILE))
        self._stage(NETWORK, alone + each * len(job.pairs) if joins else None)
        alone, each = TO_WRITE
        self._stage(WRITING, (alone + each * count) * (1.0 if job.report else ONLY_TABLES))

    def matching(self, rounds: Mapping[CameraPair, int]) -> None:
        """Expect these pairs and no others, by the rounds of their searches."""
        self._total[MATCHING] = len(rounds)
        self._pace.expect(MATCHING, {pair: self._search(number) for pair, number in rounds.items()})
        if self._waits:
            self._stage(CLOCKS, None)

    def started(self, task: Task) -> None:
        """Take a task that is handed over."""
        if isinstance(task.of, str):
            self._total[task.stage] = 1
        if task.stage == NETWORK:
            self._stage(CLOCKS, None)
        self._pace.started(task.stage, task.of)

    def ended(self, task: Task, found: Any) -> None:
        """Take a task that was done, and what it returned."""
        self._over(task.of)
        # Elsewhere only the task knows when it began; here its seconds are those of its neighbours too.
        seconds = found[1] if isinstance(found, tuple) and not self._together else None
        self._pace.ended(task.of, seconds)

    def failed(self, of: CameraInput | CameraPair | str) -> None:
        """Take a task that failed, or never began, and with a camera its pairs."""
        if self._pace.failed(of):
            self._over(of)
        if isinstance(of, CameraInput):
            for pair in self._job.pairs:
                if of in pair:
                    self._pace.failed(pair)

    def _over(self, of: CameraInput | CameraPair | str) -> None:
        self._done[Task(of).stage] += 1
        self._frames.pop(of, None)

    def writing(self) -> None:
        """All tasks are done; what is left is written."""
        for stage in (CLOCKS, MATCHING, NETWORK):
            self._pace.expect(stage, {})
        self._pace.started(WRITING, WRITING)
        self.tell(())

    def finished(self) -> None:
        """Nothing is left."""
        self._pace.finish()
        self._watch.pace(JobProgress(1.0, 0.0, "done"))

    def tell(self, running: Collection[Task]) -> None:
        """Tell how far everything is."""
        for stage, total in self._total.items():
            if total:
                share = sum(task.share for task in running if task.stage == stage)
                self._watch.progress(stage, self._done[stage] + share, total)
        share, left = self._pace.look({task.of: task.share for task in running})
        rows = tuple(
            Row(task.of.name, task.share, self._rate(task))
            for task in running
            if isinstance(task.of, CameraInput) and task.frames
        )
        self._watch.pace(JobProgress(share, left, self._doing(running), rows))

    def _rate(self, task: Task) -> float | None:
        """Frames a second at which a camera is recorded, lately."""
        seen = self._frames.setdefault(task.of, deque())
        seen.append((self._clock(), task.frames))
        while seen[-1][0] - seen[0][0] > LATELY:
            seen.popleft()
        (before, first), (now, last) = seen[0], seen[-1]
        return (last - first) / (now - before) if now > before else None

    def _doing(self, running: Collection[Task]) -> str:
        """What is going on, in a few words."""
        stages = {task.stage for task in running}
        done, total = self._done, self._total
        words = {
            RECORDING: f"recorded {done[RECORDING]} of {total[RECORDING]} cameras",
            CLOCKS: "comparing clocks",
            MATCHING: f"matched {done[MATCHING]} of {total[MATCHING]} pairs",
            NETWORK: "joining all pairs",
        }
        return ", ".join(words[stage] for stage in STAGES if stage in stages) or "writing"

    def _stage(self, name: str, prior: float | None) -> None:
        """Expect the one task of a stage, None where there is none."""
        self._pace.expect(name, {} if prior is None else {name: prior})

    def _of_camera(self, camera: CameraInput) -> float | None:
        options = self._job.record
        if camera.is_saved(options):
            return A_SAVED
        size = frames_and_pixels(camera, options)
        if size is None:
            return None
        frames, pixels = size
        self._recorded.append(frames)
        return frames * (A_FRAME + A_MEGAPIXEL * pixels / 1e6) * (A_MASK if options.masks else 1.0)

    def _search(self, rounds: int) -> float:
        return SEARCHES[rounds] * (BY_LINES if self._job.pair.method == "lines" else 1.0)

    @property
    def _seeks_clocks(self) -> bool:
        """Whether a task finds the clocks of all cameras, see :meth:`Runner._next_stage`."""
        pair = self._job.pair
        if len(self._job.cameras) == 2 or not isinstance(pair.time_offset, str):
            return False
        return pair.time_offset == "auto" or pair.method == "frontier"

    @property
    def _all_clocks(self) -> float:
        frames = sum(self._recorded) / len(self._recorded) if self._recorded else FRAMES
        return CLOCKS_OF_TWO * frames * len(self._job.pairs)

    def _misses(self, file: str) -> bool:
        """Whether a file of an earlier run cannot be of use."""
        return self._job.fresh or self.to_record > 0 or not (self._job.out / file).exists()
