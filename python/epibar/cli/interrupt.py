"""Ctrl-C ends the command promptly, also in the middle of a long native computation.

Python raises ``KeyboardInterrupt`` only once the compiled code it waits for returns. But the signal itself is
written to a wake-up socket at once, and a thread that reads it can end the process when the orderly way takes
too long. Files are written under a temporary name and renamed, so none is left half-written under its name.
"""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from .exit_codes import INTERRUPTED

__all__ = ["prompt_interrupt"]

GRACE = 1.5
"""Seconds for the orderly way."""


@contextmanager
def prompt_interrupt() -> Iterator[None]:
    """Within this, the process ends at most ``GRACE`` seconds after Ctrl-C, with exit code 130."""
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
    thread.start()
    try:
        yield
    finally:
        finished.set()
        signal.set_wakeup_fd(previous)
        sender.close()
        thread.join()
        receiver.close()
