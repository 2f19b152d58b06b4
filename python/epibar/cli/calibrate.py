"""``epibar calibrate``: record every camera once, calibrate every pair, write what was found."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from .clock_options import add_clock_options
from .exit_codes import exit_code, explanation
from .length_options import add_length_options, lengths
from .options import (
    CommandParser,
    add_output_options,
    positive_pixels,
    scheduler_address,
)
from .recording_options import add_recording_options, record_options

if TYPE_CHECKING:
    from ..jobs.all_pairs import AllPairs
    from ..jobs.inputs import Job

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "calibrate"
HELP = "videos in; every camera calibrated, with a verdict, and a fundamental matrix for every pair out"
DESCRIPTION = (
    "Find focal length, lens, rotation, position and clock of each of three or more cameras, or of two with "
    "known intrinsics; and the fundamental matrix of every pair. Writes cameras.toml and network.json, "
    "calibration.json, report.html to look at, and for each pair a picture with matched epipolar lines and "
    "the frontier points as CSV. Recordings and pairs are kept in DIR: the same command again, or with one "
    "more camera, does only what is missing."
)
EXIT_CODES = explanation(
    "done (a refused pair is a result too: read its verdict)",
    partly="a camera or a pair could not be done, or the network not be made or written; the others are",
    more="Of fewer than two cameras that can be read nothing comes: 2. The same command again goes on where "
    "it was interrupted.",
)


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.epilog = EXIT_CODES
    command.add_videos("one per camera: a video, a folder of images, or a saved recording")
    command.add_argument(
        "-o",
        "--out",
        required=True,
        metavar="DIR",
        help="folder for the results, made if it is missing: one of before to go on from what it holds, "
        "another one to keep that",
    )
    add_length_options(command)
    _add_pair_options(command)
    add_recording_options(command, several=True)
    group = command.add_argument_group("how the work is done")
    group.add_argument(
        "--scheduler",
        type=scheduler_address,
        metavar="ADDRESS",
        help="run on Dask: when one machine is too slow. tcp://host:port of its scheduler, or 'local' for a "
        "process per core here",
    )
    group.add_argument(
        "--fresh",
        action="store_true",
        help="do everything again, whatever is kept in DIR: after a change of epibar's own sources",
    )
    group.add_argument(
        "--every-pair",
        action="store_true",
        help="search every pair by itself, also of more than six cameras, where otherwise as many are as the "
        "network needs: when each is wanted with its own F; takes longer",
    )
    group.add_argument(
        "--no-report",
        dest="report",
        action="store_false",
        help="do not write report.html: when only programs read the results",
    )
    add_output_options(command, json="print calibration.json on stdout, all else on stderr; for programs")


def _add_pair_options(command: CommandParser) -> None:
    group = command.add_argument_group("how pairs are calibrated")
    group.add_argument(
        "--method",
        choices=("frontier", "lines"),
        default="frontier",
        help="'lines' is the paper's, motion barcodes alone: for comparison (default: %(default)s)",
    )
    add_clock_options(
        group,
        "N|auto|search",
        "'auto' finds when each camera was started, and whether all were together; 'search' looks for "
        "every pair by itself, to compare; 0: when all are triggered together; N: when it is known of two "
        "cameras, frame i of the first is frame i + N of the second (default: auto)",
        "; a wider search asks for more evidence",
    )
    group.add_argument(
        "--any-way-up",
        action="store_true",
        help="do not assume that all cameras are the right way up: when one hangs upside down, or is rolled "
        "by a quarter turn or more",
    )
    group.add_argument(
        "--no-essential",
        dest="essential",
        action="store_false",
        help="use camera matrices, of --intrinsics or in saved recordings, for the lens alone: when they are "
        "not to be trusted, as essential_deviation above 0.05 says",
    )
    group.add_argument(
        "--max-expected-error",
        type=positive_pixels,
        default=3.0,
        metavar="PX",
        help="accept only pairs that state less: raise it when a coarse answer is good enough, but not with "
        "boxes or ellipses as masks (default: %(default)g)",
    )


def run(args: Namespace) -> int:
    """Run the command; every pair whose two cameras are usable is written."""
    from contextlib import nullcontext

    from ..errors import EpibarError
    from ..files.json_file import json_text
    from ..jobs.all_pairs import run_job
    from ..jobs.dask import dask_executor
    from .console import Console

    console = Console(args.quiet, json=args.json, verbose=args.verbose)
    job = _job(args)
    if job.out.exists() and not job.out.is_dir():
        raise EpibarError(f"--out {job.out}: this is a file; give a folder")
    saved = all(camera.is_saved(job.record) for camera in job.cameras)
    if job.intrinsics is None and not saved and len(job.cameras) > 2 and job.pair.method == "frontier":
        console.note(
            "without --intrinsics each pair is searched as it was filmed, and may be refused for its lenses; "
            "what counts is the network in the end"
        )
    with console, nullcontext() if args.scheduler is None else dask_executor(args.scheduler) as executor:
        found = run_job(job, executor, console)
    lenses = _about_lenses(found)
    if lenses is not None and found.calibrations:
        console.note(lenses)
    console.note(_summary(job, found))
    if not job.report and (job.out / "report.html").exists():
        console.warning(f"{job.out / 'report.html'} is still that of an earlier run")
    if args.json:
        console.json(json_text(found.content))
    return exit_code(len(found.calibrations), len(found.errors))


def _summary(job: Job, found: AllPairs) -> str:
    """What came out, and where it is."""
    accepted = sum(calibration.accepted for calibration in found.calibrations.values())
    # Of cameras that cannot be read there are no pairs.
    pairs = len(found.calibrations) or len(found.searched)
    said = f"accepted: {accepted} of {pairs} pairs"
    if found.leaves_earlier:
        stays = f"what an earlier run wrote in {job.out} stays as it is"
        return f"{said}; errors: {len(found.errors)}, see above; {stays}"
    files = ["calibration.json"]
    if found.network is not None:
        cameras = len(found.network.cameras) - len(found.network.left_out)
        alone = f"{accepted} of {pairs} pairs also by themselves"
        said = f"accepted: {cameras} of {len(job.cameras)} cameras ({alone})"
        files += [path.name for path in found.network_files]
    files += ["report.html"] * job.report
    failed = f"; errors: {len(found.errors)}, see above" if found.errors else ""
    written = " and ".join(filter(None, [", ".join(files[:-1]), files[-1]]))
    return f"{said}{failed}; written: {written} in {job.out}"


def _about_lenses(found: AllPairs) -> str | None:
    """What silence would mislead about: whose lens is in which result."""
    unknown = [name for name, recording in found.recordings.items() if recording.matrix is None]
    if not unknown:
        return None
    network = found.network
    some = f" of {', '.join(unknown)}" if len(unknown) < len(found.recordings) else ""
    if network is not None and len(network.left_out) < len(network.cameras):
        return (
            f"focal lengths and lenses{some} were not given: they were found with the network, whose F are "
            "in undistorted pixels. A pair alone has no lens, and may be refused where the lens bends lines"
        )
    third = ", or a third camera" if len(found.recordings) == 2 else ""
    return (
        f"pairs{some} were calibrated without a lens model: what a lens bends is part of their error; give "
        f"--intrinsics{third}"
    )


def _job(args: Namespace) -> Job:
    from pathlib import Path

    from ..jobs.inputs import Job, PairOptions, camera_inputs

    known_lengths = lengths(args)
    return Job(
        cameras=camera_inputs(
            args.videos,
            background=args.background,
            ignore=args.ignore,
            intrinsics=args.intrinsics,
            masks=args.masks,
            time_offset=args.time_offset,
            lengths=known_lengths,
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
            max_expected_error=args.max_expected_error,
        ),
        intrinsics=args.intrinsics,
        fresh=args.fresh,
        report=args.report,
        lengths=known_lengths,
        every_pair=args.every_pair,
    )


def _option(name: str) -> str:
    return "VIDEO" if name == "cameras" else "--" + name.replace("_", "-")
