"""A Dask scheduler and two workers that can be killed and started again at the same address."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from pathlib import Path

PATIENCE = 120
"""Seconds for a scheduler or a worker to start."""


class Cluster:
    """Processes of one machine, on a port that was free."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._started = folder, 0
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self._port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self._port}"
        self.scheduler: subprocess.Popen[bytes] | None = None
        self.workers: list[subprocess.Popen[bytes]] = []
        self.complete()

    def complete(self) -> None:
        """Start what is gone: the scheduler, and workers until there are two."""
        if self.scheduler is None or self.scheduler.poll() is not None:
            words = ["scheduler", "--host", "127.0.0.1", "--port", str(self._port)]
            words += ["--no-dashboard", "--no-show"]
            self.scheduler = self._start("Scheduler at:", *words)
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        while len(self.workers) < 2:
            words = ["worker", self.address, "--no-nanny", "--nthreads", "1", "--no-dashboard"]
            self.workers.append(self._start("Registered to:", *words))

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """Kill one process as a power cut would, and wait until it is gone."""
        process.kill()
        process.wait()

    def kill_all(self) -> None:
        """Kill the scheduler and its workers."""
        for process in (self.scheduler, *self.workers):
            if process is not None:
                self.kill(process)

    def _start(self, ready: str, *words: str) -> subprocess.Popen[bytes]:
        self._started += 1
        log = self._folder / f"dask-{self._started}.log"
        with log.open("wb") as stream:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *words], stdout=stream, stderr=stream, cwd=self._folder
            )
        deadline = time.monotonic() + PATIENCE
        while ready not in log.read_text(errors="replace"):
            if time.monotonic() > deadline or process.poll() is not None:
                raise SystemExit(f"dask {words[0]} did not start: {log.read_text(errors='replace')[-2000:]}")
            time.sleep(0.05)
        return process
