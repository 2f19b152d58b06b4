"""The order of things: what is kept is reused, what is missing runs on the executor, results are written.

A task per camera, a task per pair; a pair is handed to the executor as soon as both its recordings are there.
What fails is noted and does not stop the rest, and a run that was stopped resumes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import suppress
from typing import Any

from ..calibration import Calibration
from ..errors import EpibarError, without_secrets
from ..network.offsets import ClockOffsets
from ..network.result import Network
from ..recording import Recording
from .folder import Folder
from .inputs import CameraInput, CameraPair, Job, PairOptions, pair_stems
from .keys import clocks_key, fingerprint, network_key, pair_key, recording_key
from .network_files import kept_network
from .network_stage import (
    JoinRequest,
    chosen_pairs,
    final_clocks,
    find_clocks,
    given_clocks,
    join_cameras,
    pair_options,
    why_no_network,
)
from .result_files import Results
from .returned import checked
from .stages import CLOCKS, NETWORK, STAGES, Stopped, Task
from .store import Store
from .tally import Tally, search_rounds, workers_of
from .tasks import calibrate_pair, record_camera
from .watch import Watch

__all__ = ["Runner"]

TICK = 0.25
"""Seconds between two looks at how far the tasks are."""

Progress = Callable[[str, float], None]


class Runner:
    """One run of a job.

    Parameters
    ----------
    job : Job
    folder : Folder
        Of the job, held.
    executor : Executor
        Where the tasks run. It may have more than others: ``fingerprint(path)``, for files that only workers
        can see, ``news()``, what happened since it was last asked, ``workers``, how many tasks run at a time.
    watch : Watch
    at_once : int, optional
        How many cameras are handed over at a time, so that pairs need not queue behind all of them.
    reporting : callable, optional
        Wraps the function that a task is to call with its progress; only for tasks that run in this process.
    """

    def __init__(
        self,
        job: Job,
        folder: Folder,
        executor: Executor,
        watch: Watch,
        at_once: int | None = None,
        reporting: Callable[[Progress], Progress] | None = None,
    ) -> None:
        self.results = Results(job, folder)
        self._job = job
        self._executor = executor
        self._watch = watch
        self._at_once = at_once or len(job.cameras)
        self._reporting = reporting
        self._news: Callable[[], Iterable[str]] = getattr(executor, "news", tuple)
        self._store = Store(folder)
        self._stems = pair_stems(job.cameras)
        seen = getattr(executor, "fingerprint", fingerprint)
        self._keys = {camera: recording_key(camera.located(), job.record, seen) for camera in job.cameras}
        self._queue: deque[CameraInput] = deque()
        self._kept: dict[CameraPair, tuple[Calibration, float]] = {}
        self._running: dict[Future[Any], Task] = {}
        self.tally = Tally(job, watch, at_once or workers_of(executor), together=reporting is not None)
        self._pairs = job.pairs
        self._offsets: ClockOffsets | None = None
        self._clocks_asked = self._network_asked = False
        self._reused = False
        self._network_key: str | None = None
        self._no_clocks: str | None = None
        self._bug: Exception | None = None

    @property
    def searched(self) -> list[tuple[str, str]]:
        """Names of the pairs that are to be done: all, or those that a network of many cameras needs."""
        return [(a.name, b.name) for a, b in (self._pairs if self._job.chooses_pairs else self._job.pairs)]

    def run(self) -> None:
        """Do what is missing and write everything.

        Raises
        ------
        EpibarError
            The executor, or the folder of the results, cannot be used any more.
        """
        try:
            self._reuse()
            self._hand_over()
            while self._running or self._next_stage():
                done, _ = wait(self._running, timeout=TICK, return_when=FIRST_COMPLETED)
                for future in done:
                    self._take(self._running[future], future)
                    del self._running[future]  # only now: an interruption in between loses nothing
                self._hand_over()
                self._tell()
                self.results.write_now_and_then()
        except BaseException:
            self._keep_finished()
            if self._reused:  # what an earlier run wrote is not replaced by less
                self.results.write()
            raise
        self.results.write()
        if self._bug is not None:
            raise self._bug

    def _keep_finished(self) -> None:
        """Keep what has returned and nobody took yet, then list it; recordings first, which took longest."""
        in_order = sorted(self._running.items(), key=lambda item: STAGES.index(item[1].stage))
        finished = [(future, task) for future, task in in_order if not future.cancel() and future.done()]
        for listed in (False, True):
            for future, task in finished:
                with suppress(Exception):  # what ended the run is told
                    found = self._kept_return(task, future)
                    if listed and isinstance(task.of, tuple):
                        self.results.add(task.of, self._stem(task.of), *found)
                    elif listed and task.stage == NETWORK:
                        self.results.network = found
                        self.results.write_network(self._network_key, tables=False)

    def _reuse(self) -> None:
        """Take what an earlier run kept; queue the other cameras."""
        cameras = self._job.cameras
        reused = () if self._job.fresh else cameras
        recordings = {camera: self._store.recording(camera.name, self._keys[camera]) for camera in reused}
        self._tell_damaged()
        self._queue.extend(camera for camera in cameras if recordings.get(camera) is None)
        self.tally.plan(self._queue)
        if not self._waits_for_clocks:
            self._reuse_pairs()
        for camera, recording in recordings.items():
            if recording is not None:
                self._recorded(camera, recording, None)
        self._reused = not self._waits_for_clocks

    def _reuse_pairs(self) -> None:
        """Take the pairs that an earlier run kept, whose options are known now."""
        cameras, pairs = self._job.cameras, self._pairs
        if not self._job.fresh:
            for pair in pairs:
                kept = self._store.pair(self._stem(pair), self._pair_key(pair))
                if kept is not None:
                    self._kept[pair] = kept
            self._tell_damaged()
        self.tally.matching({p: search_rounds(self._options(p)) for p in pairs if p not in self._kept})
        reused = len(cameras) - self.tally.to_record
        if reused or self._kept:
            self._watch.note(
                f"kept from an earlier run in {self._job.out}: {reused} of {len(cameras)} recordings, "
                f"{len(self._kept)} of {len(pairs)} pairs"
            )

    def _tell_damaged(self) -> None:
        for text in self._store.damaged:
            self._watch.warning(text)
        self._store.damaged.clear()

    @property
    def _waits_for_clocks(self) -> bool:
        """Whether no pair can start before the clocks of all cameras are known."""
        asked = self._job.pair.time_offset == "auto" or self._job.chooses_pairs
        return asked and self._offsets is None

    def _stem(self, pair: CameraPair) -> str:
        return self._stems[pair[0].name, pair[1].name]

    def _pair_key(self, pair: CameraPair) -> str | None:
        return pair_key(self._keys[pair[0]], self._keys[pair[1]], self._options(pair))

    def _options(self, pair: CameraPair) -> PairOptions:
        """Options of one pair, with its offset where the clocks of all cameras were found."""
        films = self._films
        if not all(camera in films for camera in pair):
            return self._job.pair
        return pair_options(self._job.pair, self._offsets, [*films.values()], *map([*films].index, pair))

    @property
    def _films(self) -> dict[CameraInput, Recording]:
        """What was recorded so far, in the order of the cameras."""
        recordings = self.results.recordings
        return {camera: recordings[camera] for camera in self._job.cameras if camera in recordings}

    def _next_stage(self) -> bool:
        """Start what waits for all that ran, and say whether there was something."""
        cameras, films = [*self._films], [*self._films.values()]
        no_network = why_no_network(self._job, self.results.recordings)
        if not self._clocks_asked:
            self._clocks_asked = True
            given = given_clocks(self._job, films)
            if given is not None:
                self._clocks_found(given)
                return True
            wanted = self._job.pair.time_offset == "auto" or no_network is None
            if wanted and len(films) > 1:
                kept = None if self._job.fresh else self._store.clocks(self._clocks_key(), len(cameras))
                if kept is None:
                    self._submit(Task(CLOCKS), find_clocks, self._job.pair.search_seconds, *films)
                else:
                    self._clocks_found(kept)
                return True
        if not self._network_asked:
            self._network_asked = True
            if no_network is None and self._offsets is not None:
                return self._start_network(cameras, films, self._offsets)
            self._joined(None, no_network or self._no_clocks)
        return bool(self._running)

    def _clocks_key(self) -> str | None:
        return clocks_key([self._keys[camera] for camera in self._films], self._job.pair.search_seconds)

    def _clocks_found(self, offsets: ClockOffsets) -> None:
        """Take the offsets of all clocks, and start the pairs that waited for them."""
        waited = self._waits_for_clocks
        self._offsets = offsets
        if not waited:
            return
        self._pairs, note = chosen_pairs(self._job, self._films, offsets)
        if note is not None:
            self._watch.note(note)
        self._reuse_pairs()
        for pair in self._pairs:
            self._start_pair(pair)
        self._reused = True

    def _start_network(
        self, cameras: Sequence[CameraInput], films: Sequence[Recording], offsets: ClockOffsets
    ) -> bool:
        """Join all pairs, unless a network of the same was kept."""
        self.results.write()  # what is finished is safe, whatever comes of the network
        names = [camera.name for camera in cameras]
        found = self.results.calibrations
        pairs = [pair for pair in self._job.pairs if pair in found]
        if not pairs:
            self._joined(None, "no pair could be calibrated")
            return False
        offsets = final_clocks(offsets, films, found[pairs[0]])
        keys = [self._pair_key(pair) for pair in pairs]
        self._network_key = network_key(keys, names, offsets.seconds, self._job.lengths)
        kept = None if self._job.fresh else kept_network(self._job.out, self._network_key, names)
        if kept is not None:
            self._joined(kept, None)
            return False
        calibrations = {(a.name, b.name): found[a, b] for a, b in pairs}
        request = JoinRequest(names, calibrations, offsets, self._job.lengths)
        self._submit(Task(NETWORK), join_cameras, request, *films)
        return True

    def _joined(self, network: Network | None, why: str | None) -> None:
        """Take the network, or why there is none."""
        self.results.network, self.results.no_network = network, why
        self.tally.writing()
        try:
            for text in self.results.write_network(self._network_key):
                self._watch.warning(text)
        except EpibarError as error:
            self._watch.error(self.results.failed(NETWORK, str(error)))
        self._watch.joined(network, why)

    def _hand_over(self) -> None:
        """Submit cameras, as many as may be recorded at once."""
        busy = sum(isinstance(task.of, CameraInput) for task in self._running.values())
        for camera in [self._queue.popleft() for _ in range(min(self._at_once - busy, len(self._queue)))]:
            self._submit(Task(camera), record_camera, camera.located(), self._job.record)

    def _submit(self, task: Task, function: Callable[..., Any], *arguments: Any) -> None:
        if self._reporting is not None:
            arguments = (*arguments, self._reporting(task.progress))
        try:
            self._running[self._executor.submit(function, *arguments)] = task
        except RuntimeError as error:  # it is broken, or was shut down
            raise Stopped(error, self._job.out) from error
        self.tally.started(task)

    def _take(self, task: Task, future: Future[Any]) -> None:
        """Take what a task returned or raised."""
        try:
            found = self._kept_return(task, future)
            self.tally.ended(task, found)
            self._go_on(task.of, found)
        except Stopped:
            raise
        except EpibarError as error:
            self._failed(task.of, str(error))
        except (CancelledError, BrokenExecutor) as error:
            raise Stopped(error, self._job.out) from error
        except Exception as error:  # a bug: raised at the end, when the rest is done
            self._bug = self._bug or error
            self._failed(task.of, f"{type(error).__name__}: {without_secrets(str(error))}")

    def _kept_return(self, task: Task, future: Future[Any]) -> Any:
        """Check what a task returned, and keep it for the next run, once."""
        of = task.of
        if task.kept is not None:
            return task.kept
        found = checked(future.result(), of, self._job, self.results.recordings)
        if isinstance(of, CameraInput):
            if not of.is_saved(self._job.record):
                self._keep(self._store.keep_recording, of.name, self._keys[of], *found)
        elif isinstance(of, tuple):
            # In this order a picture of an older calibration never stands beside a newer one.
            self.results.forget(self._stem(of))
            self._keep(self._store.keep_pair, self._stem(of), self._pair_key(of), *found)
        elif of == CLOCKS:
            self._keep(self._store.keep_clocks, self._clocks_key(), found)
        task.kept = found
        return found

    def _go_on(self, of: CameraInput | CameraPair | str, found: Any) -> None:
        """Use what a task returned."""
        if isinstance(of, CameraInput):
            self._recorded(of, *found)
        elif isinstance(of, tuple):
            calibration, seconds = found
            self._calibrated(of, calibration, seconds, kept=False)
        elif of == CLOCKS:
            self._clocks_found(found)
        else:
            self._joined(found, None)

    def _recorded(self, camera: CameraInput, recording: Recording, seconds: float | None) -> None:
        """Take a recording, made just now or kept, and go on to the pairs that waited for it."""
        self._watch.recorded(camera.name, recording, seconds)
        self.results.take(camera, recording)
        recordings = self.results.recordings
        for pair in self._job.pairs:
            both = camera in pair and all(one in recordings for one in pair)
            if both and not self._waits_for_clocks:
                self._start_pair(pair)

    def _start_pair(self, pair: CameraPair) -> None:
        """Take a pair that was kept, or hand it over."""
        if pair in self._kept:
            try:
                self._calibrated(pair, *self._kept[pair], kept=True)
            except EpibarError as error:
                self._failed(pair, str(error))
        else:
            a, b = (self.results.recordings[camera] for camera in pair)
            options = self._options(pair)
            self._submit(Task(pair, search_rounds(options)), calibrate_pair, a, b, options)

    def _calibrated(self, pair: CameraPair, calibration: Calibration, seconds: float, kept: bool) -> None:
        self.results.add(pair, self._stem(pair), calibration, seconds)
        self._watch.calibrated(pair[0].name, pair[1].name, calibration, None if kept else seconds)

    def _keep(self, write: Callable[..., None], *arguments: Any) -> None:
        """Keep something for the next run; this one can do without."""
        try:
            write(*arguments)
        except EpibarError as error:
            self._watch.warning(f"{error}; the next run has to do it again")

    def _failed(self, of: CameraInput | CameraPair | str, message: str) -> None:
        self.tally.failed(of)
        if isinstance(of, str):
            self._stage_failed(of, message)
            return
        self._watch.error(self.results.failed(of, message))

    def _stage_failed(self, stage: str, message: str) -> None:
        """Go on with what does not need a stage that failed."""
        self._watch.error(f"{stage}: {self.results.failed(stage, message)}")
        if stage == NETWORK:
            self._joined(None, f"it could not be made: {message}")
            return
        self._no_clocks = f"the clocks could not be compared: {message}"
        for pair in self._job.pairs if self._waits_for_clocks else ():
            if all(camera in self.results.recordings for camera in pair):
                self._failed(pair, self._no_clocks)

    def _tell(self) -> None:
        for text in self._news():
            self._watch.warning(text)
        self.tally.tell(self._running.values())
