"""Tasks on Dask distributed, the optional extra ``epibar[dask]``.

The scheduler keeps each recording that is sent to it, so a worker that dies takes nothing with it: Dask runs
its tasks again on another, and gives up on a task only after several workers died of it.
"""

from __future__ import annotations

import logging
import os
import pickle
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any

from ..errors import EpibarError, is_address
from ..recording import Recording
from .inputs import CameraInput
from .keys import fingerprint

__all__ = ["DaskExecutor", "dask_executor"]

TIME_LIMIT = 10.0
"""Seconds for a scheduler to answer, and again for it to have a worker."""

LOOK_EVERY = 2.0
"""Seconds between two looks at which workers are there."""

LOST = "the connection to the Dask scheduler is lost"

PAIRS_FIRST = 10
"""Priority of the pairs, so that they need not wait for all cameras."""


class DaskExecutor(Executor):
    """An executor on a Dask client, which outlives it.

    A :class:`Recording` among the arguments is sent once, however many tasks it is for. A
    :class:`CameraInput` is recorded on a host whose workers can read its files.

    Parameters
    ----------
    client : distributed.Client
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._sent: dict[int, tuple[Recording, Any]] = {}
        self._running: set[Any] = set()
        self._prints: dict[str, dict[str, str | None]] = {}
        self._workers = set(client.scheduler_info()["workers"])
        self._looked = time.monotonic()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run ``fn(*args, **kwargs)`` on a worker."""
        outcome: Future[Any] = Future()
        hosts = None
        for argument in args:
            if isinstance(argument, CameraInput):
                try:
                    hosts = self._hosts(argument)
                except EpibarError as error:
                    outcome.set_exception(error)
                    return outcome
        recordings = [argument for argument in args if isinstance(argument, Recording)]
        places = [_Place() if isinstance(argument, Recording) else argument for argument in args]
        try:
            task = self._client.submit(
                _run,
                _Packed(pickle.dumps((fn, places, kwargs))),
                *map(self._send, recordings),
                key=f"epibar-{getattr(fn, '__name__', 'task')}-{uuid.uuid4()}",
                workers=hosts,
                priority=PAIRS_FIRST if recordings else 0,
            )
        except Exception as error:
            if self._client.status == "running":
                raise
            raise RuntimeError(LOST) from error
        self._running.add(task)  # Dask drops a task that nobody holds

        def deliver(task: Any) -> None:
            self._running.discard(task)
            if not outcome.set_running_or_notify_cancel():
                return
            try:
                outcome.set_result(pickle.loads(task.result()))
            except BaseException as error:  # a future that never ends would hang the run
                lost = task.status in ("cancelled", "lost")
                outcome.set_exception(CancelledError(LOST) if lost else _translated(error))

        task.add_done_callback(deliver)
        return outcome

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let go of the tasks; those that run are cancelled, as nobody would take their results."""
        if self._running and self._client.status == "running":
            self._client.cancel(list(self._running))
        self._sent.clear()

    def fingerprint(self, path: str) -> str | None:
        """Fingerprint of a path where workers can see it; see :func:`epibar.jobs.keys.fingerprint`."""
        return next((seen for _, seen in sorted(self._seen(path).items()) if seen is not None), None)

    @property
    def workers(self) -> int:
        """How many tasks run at a time; 0 without workers, or a scheduler, as the tasks will say."""
        try:
            found = self._client.scheduler_info().get("workers") or {}
        except OSError:
            return 0
        return sum(worker["nthreads"] for worker in found.values())

    def news(self) -> list[str]:
        """Tell which workers have gone since the last call."""
        if time.monotonic() - self._looked < LOOK_EVERY:
            return []
        self._looked = time.monotonic()
        try:
            found = self._client.scheduler_info().get("workers")
        except OSError:
            found = None
        if found is None:  # there is no scheduler, as the tasks will say
            return []
        before, self._workers = self._workers, set(found)
        gone = sorted(before - self._workers)
        news = [f"the worker at {address} is gone; its tasks run again on another" for address in gone]
        if gone and not self._workers:
            news.append("no worker is left: waiting for a new one; Ctrl-C ends the run, what is done is kept")
        return news

    def _send(self, recording: Recording) -> Any:
        """Give a recording to the scheduler, as the argument of a task that can be repeated."""
        if id(recording) not in self._sent:
            key = f"epibar-recording-{uuid.uuid4()}"
            future = self._client.submit(_same, pickle.dumps(recording), key=key, priority=PAIRS_FIRST)
            self._sent[id(recording)] = recording, future
        return self._sent[id(recording)][1]

    def _hosts(self, camera: CameraInput) -> list[str] | None:
        """Hosts that can read all files of a camera, in the version of the key; None where all can.

        Raises
        ------
        EpibarError
            No host can.
        """
        files = [path for path in camera.files if not is_address(path)]
        every = {host for path in files for host in self._seen(path)}
        able = set(every)
        for path in files:
            known = self.fingerprint(path)
            able -= {host for host, seen in self._seen(path).items() if seen is None or seen != known}
            if not able:
                raise EpibarError(
                    f"{path}: no Dask worker can read it; is it there under the same path as here?"
                )
        return None if able == every else sorted(able)

    def _seen(self, path: str) -> dict[str, str | None]:
        """Fingerprint of a path on each host."""
        if path not in self._prints:
            from distributed.comm.addressing import get_address_host

            answers = self._client.run(fingerprint, path, on_error="ignore")
            self._prints[path] = {get_address_host(worker): seen for worker, seen in answers.items()}
        return self._prints[path]


class _Place:
    """Stands for a recording, which comes by itself."""


@dataclass(frozen=True)
class _Packed:
    """A task as bytes that no log shows: Dask's workers log the arguments of what failed."""

    data: bytes = field(repr=False)


# All travels as bytes that are unpickled within the task: what goes wrong there is an error of that task,
# while an error in Dask's own unpickling breaks the worker.


def _run(task: _Packed, *recordings: bytes) -> bytes:
    function, arguments, options = pickle.loads(task.data)
    unpacked = map(pickle.loads, recordings)
    filled = [next(unpacked) if isinstance(argument, _Place) else argument for argument in arguments]
    return pickle.dumps(function(*filled, **options))


def _same(recording: bytes) -> bytes:
    return recording


def _translated(error: BaseException) -> BaseException:
    """Turn what Dask says of a task into an error of that camera or pair."""
    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        return EpibarError(
            f"{error.allowed_failures + 1} Dask workers died of it, the last at {error.last_worker.address}; "
            "their logs say why, often because their memory was too small"
        )
    return error


@contextmanager
def dask_executor(scheduler: str, time_limit: float = TIME_LIMIT) -> Iterator[DaskExecutor]:
    """Connect to a Dask scheduler, or start one on this machine.

    Parameters
    ----------
    scheduler : str
        Address, ``tcp://host:port``, or ``tls://host:port`` with the certificates of Dask's settings; or
        ``local`` for one worker process per core of this machine.
    time_limit : float
        Seconds to wait for the scheduler, and again for its first worker.

    Raises
    ------
    EpibarError
        Dask is not installed, the scheduler does not answer or has no workers, or these have another epibar.

    Examples
    --------
    >>> import epibar
    >>> from epibar.jobs import dask_executor
    >>> with dask_executor("local") as executor:  # or "tcp://10.0.0.5:8786"
    ...     done = epibar.calibrate_all(["cam1.mp4", "cam2.mp4"], "calibrated", executor=executor)
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise EpibarError(
            f"scheduler {scheduler}: Dask is not installed; install it with: pip install 'epibar[dask]'"
        ) from error
    settings = {
        "distributed.admin.large-graph-warning-threshold": "1GiB",  # a recording may well be over 10 MB
        "distributed.comm.timeouts.connect": f"{time_limit}s",
    }
    with dask.config.set(settings), _silence("distributed", "distributed.client", "tornado", "asyncio"):
        if scheduler == "local":
            cores = os.cpu_count() or 1
            with (
                LocalCluster(
                    n_workers=cores,
                    threads_per_worker=1,
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.ERROR,
                    env={"RAYON_NUM_THREADS": "1"},
                ) as cluster,
                Client(cluster) as client,
            ):
                yield from _connected(client, scheduler, time_limit)
        else:
            try:
                client = _client(scheduler, time_limit)
            except TypeError as error:
                if not scheduler.startswith("tls://"):
                    raise
                raise EpibarError(
                    f"scheduler {scheduler}: no certificates; name them in Dask's settings, e.g. the "
                    "variables DASK_DISTRIBUTED__COMM__TLS__CA_FILE, ...__CLIENT__CERT and ...__CLIENT__KEY"
                ) from error
            except (OSError, ValueError, MemoryError) as error:  # the last where something else answers
                raise EpibarError(
                    f"scheduler {scheduler}: no answer within {time_limit:g} s ({error}); is 'dask "
                    "scheduler' running there, and the port open?"
                ) from error
            with client:
                yield from _connected(client, scheduler, time_limit)


def _client(address: str, time_limit: float) -> Any:
    """Connect to a scheduler.

    A client that fails on the way is closed here: the garbage collector would close it at any moment, also
    while the next one starts and holds the lock that closing needs, and both would wait for ever.
    """
    from distributed import Client

    client: Any = Client.__new__(Client)
    try:
        client.__init__(address, timeout=time_limit)
    except BaseException:
        with suppress(Exception):  # what is told is why it failed
            client.close()
        raise
    return client


@contextmanager
def _silence(*loggers: str) -> Iterator[None]:
    """Keep Dask from logging a lost connection with its tracebacks: that becomes an error of ours."""
    levels = {name: logging.getLogger(name).level for name in loggers}
    for name in loggers:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def _connected(client: Any, scheduler: str, time_limit: float) -> Iterator[DaskExecutor]:
    ours = _epibar_version()
    try:
        client.wait_for_workers(1, timeout=time_limit)
    except TimeoutError as error:
        raise EpibarError(
            f"scheduler {scheduler}: it has no worker after {time_limit:g} s; start some with "
            f"'dask worker {scheduler}'"
        ) from error
    for worker, found in client.run(_epibar_version, on_error="return").items():
        if found != ours:
            has = f"has epibar {found}" if isinstance(found, str) else f"cannot import epibar ({found})"
            raise EpibarError(
                f"scheduler {scheduler}: the worker at {worker} {has}; install epibar {ours} there"
            )
    executor = DaskExecutor(client)
    try:
        yield executor
    finally:
        executor.shutdown()


def _epibar_version() -> str:
    return version("epibar")
