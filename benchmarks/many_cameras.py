"""All pairs of many cameras: threads, one Dask worker, two, and a run that is killed at half and goes on.

With ``--beside`` the job runs on threads alone, in turn by this checkout and by another.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from many_cameras_beside import checkout, compared, in_turn, report
from options import METHODS, Method, add_common, add_frames, natural
from tables import progress, table, write_json

import epibar
from epibar import synthetic
from epibar.jobs.dask import DaskExecutor


def image_size(text: str) -> tuple[int, int]:
    """Read ``160x120``."""
    width, cross, height = text.partition("x")
    if not (cross and width.isdigit() and height.isdigit()):
        raise ArgumentTypeError(f"{text!r}: expected WIDTHxHEIGHT")
    return int(width), int(height)


@dataclass(frozen=True)
class Job:
    """What is calibrated, by which method."""

    masks: list[Path]
    method: Method
    lines: int

    @property
    def pairs(self) -> int:
        """How many there are."""
        return len(self.masks) * (len(self.masks) - 1) // 2


def write_masks(args: Namespace, folder: Path) -> list[Path]:
    """Draw the masks of every camera."""
    make = synthetic.people if args.scene == "people" else synthetic.cubes
    options = {} if args.scene == "people" else {"objects": 12, "size_m": (0.25, 0.45)}
    scene = make(args.seed, cameras=args.cameras, frames=args.frames, size=args.size, **options)
    paths = [folder / f"cam{index + 1:02d}.npz" for index in range(args.cameras)]
    for index, path in enumerate(paths):
        np.savez_compressed(path, masks=scene.masks(index), fps=scene.fps)
    return paths


def timed(job: Job, out: Path, executor: Executor | None = None) -> float:
    """Run the job; returns the seconds it took."""
    options = {"method": job.method, "lines": job.lines, "masks": True, "every_pair": True, "report": False}
    started = time.perf_counter()
    epibar.calibrate_all(job.masks, out, executor=executor, **options)
    return time.perf_counter() - started


def timed_on_dask(job: Job, out: Path, workers: int) -> float:
    """Run the job on worker processes of one thread each; starting them is not counted."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            env={"RAYON_NUM_THREADS": "1"},
        ) as cluster,
        Client(cluster) as client,
    ):
        return timed(job, out, DaskExecutor(client))


def kept(out: Path) -> dict[str, int]:
    """Kept recordings and pairs, with the time of change of each."""
    files = [*out.glob("recordings/cam*.npz"), *out.glob("pairs/cam*.npz")]
    return {str(path.relative_to(out)): path.stat().st_mtime_ns for path in files}


def start(job: Job, out: Path) -> subprocess.Popen[str]:
    """Start the command line on the job."""
    words = [*map(str, job.masks), "--out", str(out), "--masks", "--no-report", "--every-pair"]
    words += ["--lines", str(job.lines), "--method", job.method]
    command = [sys.executable, "-m", "epibar", "calibrate", *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def killed_and_resumed(job: Job, out: Path) -> dict[str, object]:
    """Kill a run when half of the pairs are kept, start it again, list what was done twice."""
    process = start(job, out)
    while sum(name.startswith("pairs") for name in kept(out)) < job.pairs // 2:
        if process.poll() is not None:
            raise SystemExit(f"the run ended before it could be killed:\n{process.communicate()[1]}")
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    before = kept(out)
    started = time.perf_counter()
    process = start(job, out)
    said = process.communicate()[1]
    seconds = time.perf_counter() - started
    if process.returncode:
        raise SystemExit(f"the resumed run failed:\n{said}")
    after = kept(out)
    return {
        "kept when killed": len(before),
        "done again though kept": sorted(name for name in before if after[name] != before[name]),
        "done by the second run": len(after) - len(before),
        "said": next((line for line in said.splitlines() if line.startswith("kept from")), ""),
        "seconds": seconds,
    }


def all_ways(job: Job, folder: Path) -> dict[str, Any]:
    """Run the job in every way, and print how long each took and whether the results are the same."""
    runs = {}
    progress(f"{job.method}: threads of one process ...")
    runs["threads"] = timed(job, folder / "threads")
    for workers in (1, 2):
        progress(f"{workers} Dask worker(s) ...")
        runs[f"{workers} Dask worker(s)"] = timed_on_dask(job, folder / f"dask{workers}", workers)
    progress("killed at half and resumed ...")
    resumed = killed_and_resumed(job, folder / "resumed")
    whole = (folder / "threads" / "calibration.json").read_bytes()
    same = {
        name: (folder / name / "calibration.json").read_bytes() == whole
        for name in ("dask1", "dask2", "resumed")
    }
    accepted = sum(pair["accepted"] for pair in json.loads(whole)["pairs"])

    print(f"{accepted} of {job.pairs} pairs accepted; load {os.getloadavg()[0]:.1f}\n")
    one = runs["1 Dask worker(s)"]
    rows = [
        (name, f"{seconds:.1f}", f"{seconds / job.pairs:.4f}", f"{one / seconds:.2f} x")
        for name, seconds in runs.items()
    ]
    print(table(["run", "seconds", "a pair", "against one worker"], rows))
    print(f"\nsame calibration.json as by threads, byte by byte: {same}")
    print(f"killed at half: {resumed}\n")
    each = {name: seconds / job.pairs for name, seconds in runs.items()}
    return {
        "pairs": job.pairs,
        "seconds": runs,
        "seconds per pair": each,
        "same": same,
        "resumed": resumed,
        "accepted": accepted,
    }


def main() -> None:
    """Run everything and print the figures."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--cameras", type=natural, default=20, help="default: %(default)s")
    parser.add_argument("--scene", choices=("cubes", "people"), default="cubes", help="default: %(default)s")
    parser.add_argument("--size", type=image_size, default=(160, 120), metavar="WxH", help="default: 160x120")
    add_frames(parser, 200)
    parser.add_argument("--seed", type=int, default=3, help="default: %(default)s")
    parser.add_argument(
        "--method", choices=METHODS, default="lines", help="default: %(default)s, the quicker"
    )
    parser.add_argument(
        "--beside", type=checkout, metavar="DIR", help="the folder python of another checkout"
    )
    parser.add_argument(
        "--rounds", type=natural, default=3, help="by each checkout, with --beside (default %(default)s)"
    )
    add_common(parser, lines=2000)
    args = parser.parse_args()

    summary = {}
    with TemporaryDirectory() as temporary:
        folder = Path(temporary)
        masks = write_masks(args, folder)
        for method in METHODS[args.method]:
            print(f"{args.cameras} cameras, method {method}:", end=" ")
            job = Job(masks, method, args.lines)
            if args.beside is None:
                summary[method] = all_ways(job, folder / method)
            else:
                results = in_turn(job.method, job.lines, masks, folder, args.beside, args.rounds)
                summary[method] = compared(results)
                print(f"{job.pairs} pairs beside {args.beside}; load {os.getloadavg()[0]:.1f}\n")
                print(f"{report(summary[method])}\n")
            write_json(args.json, args, [], summary)
    if not all(all(one.get("same", {}).values()) for one in summary.values()):
        raise SystemExit("calibration.json differs")


if __name__ == "__main__":
    main()
