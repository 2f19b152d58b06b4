"""Where tasks run without an executor: threads of this process, which end early when they are interrupted."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from .runner import Progress

__all__ = ["own_threads", "thread_count"]

THREADS = 4
"""Tasks at a time. Each uses all cores already; they fill each other's pauses."""


def thread_count() -> int:
    """Tasks that run at a time."""
    return min(THREADS, os.cpu_count() or 1)


class _Interrupted(BaseException):
    """Ends a task whose result nobody waits for any more."""


@contextmanager
def own_threads() -> Iterator[tuple[Executor, Callable[[Progress], Progress]]]:
    """Threads whose tasks report how far they are, and end early when this is left by an exception."""
    stop = threading.Event()

    def reporting(progress: Progress) -> Progress:
        def report(stage: str, share: float) -> None:
            if stop.is_set():
                raise _Interrupted
            progress(stage, share)

        return report

    executor = ThreadPoolExecutor(thread_count(), thread_name_prefix="epibar-job")
    try:
        yield executor, reporting
    except BaseException:
        stop.set()
        # Threads that go on write nothing, and nobody takes what they return.
        executor.shutdown(wait=False, cancel_futures=True)
        raise
    executor.shutdown()
