"""All pairs of many cameras: threads, one Dask worker, two, and a run that is killed at half and goes on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from concurrent.futures import Executor
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from options import add_common, add_frames, natural
from tables import progress, table, write_json

import epibar
from epibar import synthetic
from epibar.calibration import METHODS
from epibar.jobs.dask import DaskExecutor


def image_size(text: str) -> tuple[int, int]:
    """Read ``160x120``."""
    width, cross, height = text.partition("x")
    if not (cross and width.isdigit() and height.isdigit()):
        raise ArgumentTypeError(f"{text!r}: expected WIDTHxHEIGHT")
    return int(width), int(height)


def write_masks(args: Namespace, folder: Path) -> list[Path]:
    """Draw the masks of every camera."""
    make = synthetic.people if args.scene == "people" else synthetic.cubes
    options = {} if args.scene == "people" else {"objects": 12, "size_m": (0.25, 0.45)}
    scene = make(args.seed, cameras=args.cameras, frames=args.frames, size=args.size, **options)
    paths = [folder / f"cam{index + 1:02d}.npz" for index in range(args.cameras)]
    for index, path in enumerate(paths):
        np.savez_compressed(path, masks=scene.masks(index), fps=scene.fps)
    return paths


def timed(args: Namespace, masks: list[Path], out: Path, executor: Executor | None = None) -> float:
    """Run the job; returns the seconds it took."""
    started = time.perf_counter()
    epibar.calibrate_all(
        masks, out, method=args.method, lines=args.lines, masks=True, executor=executor, report=False
    )
    return time.perf_counter() - started


def timed_on_dask(args: Namespace, masks: list[Path], out: Path, workers: int) -> float:
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
        return timed(args, masks, out, DaskExecutor(client))


def kept(out: Path) -> dict[str, int]:
    """Kept recordings and pairs, with the time of change of each."""
    files = [*out.glob("recordings/cam*.npz"), *out.glob("pairs/cam*.npz")]
    return {str(path.relative_to(out)): path.stat().st_mtime_ns for path in files}


def start(args: Namespace, masks: list[Path], out: Path) -> subprocess.Popen[str]:
    """Start the command line on the job."""
    words = [*map(str, masks), "--out", str(out), "--masks", "--no-report"]
    words += ["--lines", str(args.lines), "--method", args.method]
    command = [sys.executable, "-m", "epibar", "calibrate", *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def killed_and_resumed(args: Namespace, masks: list[Path], out: Path) -> dict[str, object]:
    """Kill a run when half of the pairs are kept, start it again, list what was done twice."""
    half = args.cameras * (args.cameras - 1) // 4
    process = start(args, masks, out)
    while sum(name.startswith("pairs") for name in kept(out)) < half:
        if process.poll() is not None:
            raise SystemExit(f"the run ended before it could be killed:\n{process.communicate()[1]}")
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    before = kept(out)
    started = time.perf_counter()
    process = start(args, masks, out)
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
    add_common(parser, lines=2000)
    args = parser.parse_args()

    with TemporaryDirectory() as temporary:
        folder = Path(temporary)
        masks = write_masks(args, folder)
        runs = {}
        progress("threads of one process ...")
        runs["threads"] = timed(args, masks, folder / "threads")
        for workers in (1, 2):
            progress(f"{workers} Dask worker(s) ...")
            runs[f"{workers} Dask worker(s)"] = timed_on_dask(args, masks, folder / f"dask{workers}", workers)
        progress("killed at half and resumed ...")
        resumed = killed_and_resumed(args, masks, folder / "resumed")
        whole = (folder / "threads" / "calibration.json").read_bytes()
        same = {
            name: (folder / name / "calibration.json").read_bytes() == whole
            for name in ("dask1", "dask2", "resumed")
        }
        accepted = whole.count(b'"accepted": true')

    pairs = args.cameras * (args.cameras - 1) // 2
    print(f"{args.cameras} cameras, {pairs} pairs, {accepted} accepted; load {os.getloadavg()[0]:.1f}\n")
    one = runs["1 Dask worker(s)"]
    rows = [(name, f"{seconds:.1f}", f"{one / seconds:.2f} x") for name, seconds in runs.items()]
    print(table(["run", "seconds", "against one worker"], rows))
    print(f"\nsame calibration.json as by threads, byte by byte: {same}")
    print(f"killed at half: {resumed}")
    outcome = {"seconds": runs, "same": same, "resumed": resumed, "accepted": accepted}
    write_json(args.json, args, [], outcome)
    if not all(same.values()):
        raise SystemExit("calibration.json differs")


if __name__ == "__main__":
    main()
