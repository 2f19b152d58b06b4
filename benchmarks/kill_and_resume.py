"""A network's run is killed at random moments and started again: same bytes, nothing finished twice.

On threads the whole run is killed. On Dask (``--dask``) it is in turn the run, a worker, the scheduler, or
all of them; what is gone is started anew, and then the same command again.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from kill_cluster import Cluster
from tables import progress, table, write_json

from epibar import synthetic
from epibar.jobs.stages import CLOCKS, NETWORK

CAMERAS = 3
VICTIMS = ("run", "worker", "scheduler", "all")
PATIENCE = 600
"""Seconds after which a run that should end by itself counts as one that hangs."""

# The command line, which also writes down every task that is handed over.
NOTING_SUBMIT = """
import sys
from epibar.jobs.runner import Runner

path, submit = sys.argv.pop(1), Runner._submit

def submit_and_note(self, task, *rest):
    cameras = task.of if isinstance(task.of, tuple) else (task.of,)
    with open(path, "a") as stream:
        print("_".join(getattr(one, "name", one) for one in cameras), file=stream)
    return submit(self, task, *rest)

Runner._submit = submit_and_note
from epibar.cli import main
sys.exit(main())
"""


def write_masks(folder: Path) -> list[str]:
    """Draw the masks of every camera: of few that make a network, the fewest frames and things."""
    scene = synthetic.cubes(3, cameras=CAMERAS, objects=5, frames=150, size=(96, 72), size_m=(0.25, 0.45))
    paths = [folder / f"cam{index + 1}.npz" for index in range(CAMERAS)]
    for index, path in enumerate(paths):
        np.savez_compressed(path, masks=scene.masks(index), fps=scene.fps)
    return list(map(str, paths))


def results(out: Path) -> dict[str, bytes]:
    """Every file that holds no times: calibration.json, network.json, cameras.toml, points, pictures."""
    found = (path for path in out.rglob("*") if path.suffix in (".json", ".toml", ".csv", ".png"))
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in sorted(found)}


def finished(out: Path) -> set[str]:
    """The tasks whose result is there, under the names that ``NOTING_SUBMIT`` gives them."""
    kept = {path.stem for kind in ("recordings", "pairs") for path in out.glob(f"{kind}/[!.]*.npz")}
    stages = {CLOCKS: out / "recordings" / "clocks.json", NETWORK: out / "network.json"}
    return kept | {stage for stage, path in stages.items() if path.exists()}


class Job:
    """One job of three cameras, in a folder of its own each time."""

    def __init__(self, folder: Path, masks: list[str], scheduler: str | None = None) -> None:
        self.out, self.handed_over = folder / "out", folder / "tasks"
        words = ["calibrate", *masks, "--masks", "--lines", "1000", "--no-report", "--quiet"]
        self.words = [
            sys.executable,
            "-c",
            NOTING_SUBMIT,
            str(self.handed_over),
            *words,
            "--out",
            str(self.out),
        ]
        self.words += [] if scheduler is None else ["--scheduler", scheduler]
        self.running: subprocess.Popen[bytes] | None = None

    def start(self) -> subprocess.Popen[bytes]:
        """Start the command, with nothing said yet of what it hands over."""
        self.handed_over.write_text("")
        self.running = subprocess.Popen(self.words, start_new_session=True, stderr=subprocess.PIPE)
        return self.running

    def stop(self) -> None:
        """Leave nothing running behind."""
        if self.running is not None and self.running.poll() is None:
            os.killpg(self.running.pid, signal.SIGKILL)
            self.running.communicate()

    def tasks(self) -> Counter[str]:
        """How often each task was handed over since the start."""
        return Counter(self.handed_over.read_text().split())

    def whole(self) -> tuple[dict[str, bytes], float]:
        """Run it to its end, and return what it wrote and the seconds it took."""
        shutil.rmtree(self.out, ignore_errors=True)
        started = time.monotonic()
        process = self.start()
        _, said = process.communicate(timeout=PATIENCE)
        if process.returncode or NETWORK not in self.tasks():
            raise SystemExit(f"the job without a kill has failed, or has no network: {said.decode()}")
        return results(self.out), time.monotonic() - started


def kill(victim: str, process: subprocess.Popen[bytes], cluster: Cluster | None) -> bool:
    """Kill one of them, and wait for the run to end; returns whether it was still running before."""
    if process.poll() is not None:
        process.communicate()
        return False
    if victim in ("run", "all"):
        os.killpg(process.pid, signal.SIGKILL)
    if cluster is not None:
        if victim == "worker":
            cluster.kill(cluster.workers[0])
        elif victim in ("scheduler", "all"):
            cluster.kill_all()
    process.communicate(timeout=PATIENCE)
    return True


def resumed(job: Job, expected: dict[str, bytes]) -> Counter[str]:
    """Start the command again after a kill, and count what came of it."""
    before = finished(job.out)
    again = job.start()
    again.communicate(timeout=PATIENCE)
    return Counter(
        {
            "kills": 1,
            "same bytes": int(again.returncode == 0 and results(job.out) == expected),
            "tasks that were finished": len(before),
            "of them done again": sum(job.tasks()[task] for task in before),
            "with a finished network": int(NETWORK in before),
            "left-over files": len(list(job.out.rglob("*.epibar-part"))),
        }
    )


def killed_often(
    args: Namespace, folder: Path, cluster: Cluster | None, rows: dict[str, Counter[str]]
) -> None:
    """Kill and resume, as often as asked for or until interrupted, and count in ``rows``."""
    moments = random.Random(args.seed)
    masks = write_masks(folder)
    expected, took = Job(folder, masks).whole()
    job = Job(folder, masks, cluster and cluster.address)
    if cluster is not None:
        shown, took = job.whole()
        progress(f"Dask writes the same as threads: {shown == expected}")
    killed = 0
    try:
        while killed < args.kills:
            victim = list(rows)[killed % len(rows)]
            shutil.rmtree(job.out, ignore_errors=True)
            process = job.start()
            time.sleep(moments.uniform(0.0, took))
            if not kill(victim, process, cluster):
                continue  # it was quicker than the first one, and had ended
            killed += 1
            if cluster is not None:
                cluster.complete()
            rows[victim].update(resumed(job, expected))
            progress(f"{killed} of {args.kills}: {victim} {dict(rows[victim])}")
            write_json(args.json, args, [], {one: dict(row) for one, row in rows.items()})
    finally:
        job.stop()


def main() -> int:
    """Run it."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    parser.add_argument("--dask", action="store_true", help="on a Dask cluster of two workers")
    parser.add_argument("--json", type=Path, help="file for all of it")
    args = parser.parse_args()
    rows: dict[str, Counter[str]] = {victim: Counter() for victim in (VICTIMS if args.dask else ("run",))}
    with TemporaryDirectory() as name:
        cluster = Cluster(Path(name)) if args.dask else None
        try:
            killed_often(args, Path(name), cluster, rows)
        except KeyboardInterrupt:
            progress("interrupted: the table is of what was done")
        finally:
            if cluster is not None:
                cluster.kill_all()
    columns = ["kills", "same bytes", "tasks that were finished", "of them done again"]
    columns += ["with a finished network", "left-over files"]
    print(
        table(
            ["killed", *columns], [[one, *(row[column] for column in columns)] for one, row in rows.items()]
        )
    )
    total = sum(rows.values(), Counter())
    good = total["same bytes"] == total["kills"] and not total["of them done again"]
    return 0 if good and not total["left-over files"] else 1


if __name__ == "__main__":
    sys.exit(main())
