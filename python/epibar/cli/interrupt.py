"""Ctrl-C ends the command within a second, also in the middle of a long native computation.

Python raises ``KeyboardInterrupt`` only once the compiled code that the main thread waits for returns, and
at its end waits for its other threads. But the signal itself is written to a wake-up socket at once, and a
thread that reads it ends the process when the orderly way takes too long. Files are written under a temporary
name and renamed, so none is left half-written under its name.
"""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from .exit_codes import INTERRUPTED

__all__ = ["prompt_interrupt"]

GRACE = 0.9
"""Seconds for the orderly way: what tasks have finished is written, folders are let go of."""


@contextmanager
def prompt_interrupt() -> Iterator[None]:
    """Within this, the process ends at most ``GRACE`` seconds after Ctrl-C, with exit code 130.

    Only the first Ctrl-C raises ``KeyboardInterrupt``: another would stop what writes the results.
    """
    if (
        threading.current_thread() is not threading.main_thread()
    ):  # only the main thread may ask for the signals
        yield
        return
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    finished = threading.Event()

    def watch() -> None:
        while signals := receiver.recv(64):
            if signal.SIGINT in signals and not finished.wait(GRACE):
                os.write(2, b"\nepibar: interrupted\n")
                os._exit(INTERRUPTED)

    thread = threading.Thread(target=watch, name="epibar-interrupt", daemon=True)
    previous = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if usual:  # a command in the background may have been told to ignore it
        signal.signal(signal.SIGINT, _once())
    thread.start()
    try:
        yield
    finally:
        finished.set()
        if usual:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.set_wakeup_fd(previous)
        sender.close()
        thread.join()
        receiver.close()


def _once() -> Callable[[int, FrameType | None], None]:
    """A handler that raises the first time."""
    raised = False

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal raised
        if not raised:
            raised = True
            raise KeyboardInterrupt

    return handle
