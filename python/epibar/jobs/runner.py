"""The order of things: what is kept is reused, what is missing runs on the executor, results are written.

A task per camera, a task per pair; a pair is handed to the executor as soon as both its recordings are there.
What fails is noted and does not stop the rest.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from typing import Any

from ..calibration import Calibration
from ..errors import EpibarError, without_secrets
from ..recording import Recording
from .folder import Folder
from .inputs import CameraInput, Job, Pair, pair_stems
from .keys import fingerprint, pair_key, recording_key
from .results import Results
from .returned import checked_calibration, checked_recording
from .store import Store
from .tasks import calibrate_pair, record_camera
from .watch import Watch

__all__ = ["Runner"]

TICK = 0.25
"""Seconds between two looks at how far the tasks are."""

Progress = Callable[[str, float], None]


class _Stopped(EpibarError):
    """No task runs any more."""


@dataclass(eq=False)
class _Task:
    """What one future stands for."""

    of: CameraInput | Pair
    share: float = 0.0

    @property
    def stage(self) -> str:
        return "recording" if isinstance(self.of, CameraInput) else "matching"

    def progress(self, _: str, share: float) -> None:
        """Note how far the task is; called in the thread that runs it."""
        self.share = share


class Runner:
    """One run of a job.

    Parameters
    ----------
    job : Job
    folder : Folder
        Of the job, held.
    executor : Executor
        Where the tasks run. It may have two methods more than others: ``fingerprint(path)``, for files that
        only its workers can see, and ``news()``, which returns what happened since it was last asked.
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
        self._kept: dict[Pair, tuple[Calibration, float]] = {}
        self._running: dict[Future[Any], _Task] = {}
        self._done = {"recording": 0, "matching": 0}
        self._total = {"recording": 0, "matching": 0}
        self._reused = False
        self._bug: Exception | None = None

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
            while self._running:
                done, _ = wait(self._running, timeout=TICK, return_when=FIRST_COMPLETED)
                for future in done:
                    self._take(self._running.pop(future), future)
                self._hand_over()
                self._tell()
                self.results.write_now_and_then()
        except BaseException:
            for future in self._running:
                future.cancel()
            if self._reused:  # what an earlier run wrote is not replaced by less
                self.results.write()
            raise
        self.results.write()
        if self._bug is not None:
            raise self._bug

    def _reuse(self) -> None:
        """Take what an earlier run kept; queue the other cameras."""
        cameras, pairs = self._job.cameras, self._job.pairs
        recordings = {}
        if not self._job.fresh:
            recordings = {c: self._store.recording(c.name, self._keys[c]) for c in cameras}
            for pair in pairs:
                kept = self._store.pair(self._stem(pair), self._pair_key(pair))
                if kept is not None:
                    self._kept[pair] = kept
        for text in self._store.damaged:
            self._watch.warning(f"{text}; it is made again")
        self._queue.extend(camera for camera in cameras if recordings.get(camera) is None)
        self._total = {"recording": len(self._queue), "matching": len(pairs) - len(self._kept)}
        reused = len(cameras) - len(self._queue)
        if reused or self._kept:
            self._watch.note(
                f"kept from an earlier run in {self._job.out}: {reused} of {len(cameras)} recordings, "
                f"{len(self._kept)} of {len(pairs)} pairs"
            )
        for camera, recording in recordings.items():
            if recording is not None:
                self._recorded(camera, recording, None)
        self._reused = True

    def _stem(self, pair: Pair) -> str:
        return self._stems[pair[0].name, pair[1].name]

    def _pair_key(self, pair: Pair) -> str | None:
        return pair_key(self._keys[pair[0]], self._keys[pair[1]], self._job.pair)

    def _hand_over(self) -> None:
        """Submit cameras, as many as may be recorded at once."""
        busy = sum(isinstance(task.of, CameraInput) for task in self._running.values())
        for _ in range(min(self._at_once - busy, len(self._queue))):
            camera = self._queue.popleft()
            self._submit(_Task(camera), record_camera, camera.located(), self._job.record)

    def _submit(self, task: _Task, function: Callable[..., Any], *arguments: Any) -> None:
        if self._reporting is not None:
            arguments = (*arguments, self._reporting(task.progress))
        try:
            self._running[self._executor.submit(function, *arguments)] = task
        except RuntimeError as error:  # it is broken, or was shut down
            raise self._stopped(error) from error

    def _take(self, task: _Task, future: Future[Any]) -> None:
        """Take what a task returned or raised."""
        self._done[task.stage] += 1
        try:
            returned = future.result()
            if isinstance(task.of, CameraInput):
                value, seconds = checked_recording(returned, task.of, self._job.record)
                if not task.of.is_saved(self._job.record):
                    self._keep(self._store.keep_recording, task.of.name, self._keys[task.of], value, seconds)
                self._recorded(task.of, value, seconds)
            else:
                a, b = (self.results.recordings[camera] for camera in task.of)
                self._calibrated(task.of, *checked_calibration(returned, a, b, self._job.pair), kept=False)
        except _Stopped:
            raise
        except EpibarError as error:
            self._failed(task.of, str(error))
        except (CancelledError, BrokenExecutor) as error:
            raise self._stopped(error) from error
        except Exception as error:  # a bug: raised at the end, when the rest is done
            self._bug = self._bug or error
            self._failed(task.of, f"{type(error).__name__}: {without_secrets(str(error))}")

    def _stopped(self, error: Exception) -> _Stopped:
        return _Stopped(
            f"what runs the tasks has stopped ({str(error) or type(error).__name__}); what was finished is "
            f"kept in {self._job.out}, and the same run started again goes on from there"
        )

    def _recorded(self, camera: CameraInput, recording: Recording, seconds: float | None) -> None:
        """Take a recording, made just now or kept, and go on to the pairs that waited for it."""
        self._watch.recorded(camera.name, recording, seconds)
        recordings = self.results.recordings
        recordings[camera] = recording
        for pair in self._job.pairs:
            if camera not in pair or not all(one in recordings for one in pair):
                continue
            if pair in self._kept:
                try:
                    self._calibrated(pair, *self._kept[pair], kept=True)
                except EpibarError as error:
                    self._failed(pair, str(error))
            else:
                a, b = pair
                self._submit(_Task(pair), calibrate_pair, recordings[a], recordings[b], self._job.pair)

    def _calibrated(self, pair: Pair, calibration: Calibration, seconds: float, kept: bool) -> None:
        stem = self._stem(pair)
        if not kept:
            # In this order a picture of an older calibration never stands beside a newer one.
            self.results.forget(stem)
            self._keep(self._store.keep_pair, stem, self._pair_key(pair), calibration, seconds)
        self.results.add(pair, stem, calibration, seconds)
        self._watch.calibrated(pair[0].name, pair[1].name, calibration, None if kept else seconds)

    def _keep(self, write: Callable[..., None], *arguments: Any) -> None:
        """Keep something for the next run; this one can do without."""
        try:
            write(*arguments)
        except EpibarError as error:
            self._watch.warning(f"{error}; the next run has to do it again")

    def _failed(self, of: CameraInput | Pair, message: str) -> None:
        if isinstance(of, CameraInput):
            self.results.errors[of] = {
                "camera": of.name,
                "file": of.shown,
                "message": without_secrets(message),
            }
        else:
            a, b = of
            message = f"{a.name} - {b.name}: {message}"
            self.results.errors[of] = {"a": a.name, "b": b.name, "message": message}
        self._watch.error(message)

    def _tell(self) -> None:
        for text in self._news():
            self._watch.warning(text)
        for stage, total in self._total.items():
            running = sum(task.share for task in self._running.values() if task.stage == stage)
            if total:
                self._watch.progress(stage, self._done[stage] + running, total)
