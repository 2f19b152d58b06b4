"""``epibar calibrate``: record every camera once, calibrate every pair, write what was found."""

from __future__ import annotations

from argparse import Namespace
from contextlib import nullcontext
from pathlib import Path

from ..errors import EpibarError
from ..files.calibration_json import json_text
from ..jobs.all_pairs import run_job
from ..jobs.dask import dask_executor
from ..jobs.inputs import Job, PairOptions, RecordOptions, camera_inputs
from ..sources.frame_range import FrameRange
from .console import Console

__all__ = ["run"]


def run(args: Namespace) -> int:
    """Run the command; every pair whose two cameras are usable is written."""
    console = Console(args.quiet, json=args.json)
    job = Job(
        cameras=camera_inputs(
            args.videos,
            background=args.background,
            ignore=args.ignore,
            intrinsics=args.intrinsics,
            time_offset=args.time_offset,
            spelt=_option,
        ),
        out=Path(args.out),
        record=record_options(args),
        pair=PairOptions(
            method=args.method,
            seed=args.seed,
            time_offset=args.time_offset,
            upright=not args.any_way_up,
            essential=args.essential,
            search_seconds=args.search_seconds,
        ),
        intrinsics=args.intrinsics,
        fresh=args.fresh,
        report=args.report,
    )
    if job.out.exists() and not job.out.is_dir():
        raise EpibarError(f"--out {job.out}: this is a file; give a folder")
    with console, nullcontext() if args.scheduler is None else dask_executor(args.scheduler) as executor:
        found = run_job(job, executor, console)
    files = "calibration.json" + (" and report.html" if job.report else "")
    accepted = sum(calibration.accepted for calibration in found.calibrations.values())
    failed = f"; errors: {len(found.errors)}, see above" if found.errors else ""
    console.note(f"accepted: {accepted} of {len(job.pairs)} pairs{failed}; written: {files} in {job.out}")
    if not job.report and (job.out / "report.html").exists():
        console.warning(f"{job.out / 'report.html'} is still that of an earlier run")
    if args.json:
        console.json(json_text(found.content))
    return 2 if found.errors else 0


def record_options(args: Namespace) -> RecordOptions:
    """Take the options that ``calibrate`` and ``record`` share."""
    frames = FrameRange.of(args.frames)
    return RecordOptions(args.lines, args.seed, args.masks, args.foreground, frames)


def _option(name: str) -> str:
    return "VIDEO" if name == "cameras" else "--" + name.replace("_", "-")
