"""Decode in one thread, work in another."""

from __future__ import annotations

import queue
import threading
from collections.abc import Generator, Iterable, Iterator
from typing import Any, TypeVar

from ..errors import EpibarError

__all__ = ["prefetched"]

LEFT_AFTER = 2.0
"""Seconds for which a thread that is no longer needed is waited for."""

T = TypeVar("T")


def prefetched(items: Iterable[T], depth: int = 2) -> Generator[T, None, None]:
    """Run an iterator in a thread, up to ``depth`` items ahead, so that decoding and the work overlap.

    Exceptions come out where the item would have; abandoning the iteration stops the thread.
    """
    if depth < 1:
        raise EpibarError(f"prefetch depth is {depth}; it must be at least 1")
    ready: queue.Queue[tuple[bool, Any]] = queue.Queue(maxsize=depth)
    stop, end = threading.Event(), object()

    def put(entry: tuple[bool, Any]) -> bool:
        while not stop.is_set():
            try:
                ready.put(entry, timeout=0.05)
                return True
            except queue.Full:
                continue
        return False

    def produce() -> None:
        try:
            for item in items:
                if not put((True, item)):
                    return
            put((False, end))
        except BaseException as error:
            put((False, error))
        finally:
            close = getattr(items, "close", None)  # a generator must be closed by the thread that ran it
            if close is not None and isinstance(items, Iterator):
                close()

    thread = threading.Thread(target=produce, name="epibar-prefetch", daemon=True)
    thread.start()
    try:
        while True:
            is_item, value = ready.get()
            if is_item:
                yield value
            elif value is end:
                return
            else:
                raise value
    finally:
        stop.set()
        # A read of a stream that stalls cannot be stopped; whoever interrupts does not wait for it.
        thread.join(LEFT_AFTER)
