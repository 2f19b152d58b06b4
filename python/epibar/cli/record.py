"""``epibar record``: one camera's video in, a small file out."""

from __future__ import annotations

from argparse import Namespace

from .exit_codes import DONE
from .options import CommandParser, add_output_options
from .recording_options import add_recording_options, record_options

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "record"
HELP = "one video in, a small recording out that any other can be matched with"
DESCRIPTION = "Turn one camera's video into a recording: lines with barcodes, silhouettes, no images."


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.add_argument("video", metavar="VIDEO", help="a video or a folder of images")
    command.add_argument(
        "-o",
        "--out",
        required=True,
        metavar="FILE.npz",
        help="the file to write, which 'calibrate' and others take in the place of the video",
    )
    add_recording_options(command, several=False)
    add_output_options(command)


def run(args: Namespace) -> int:
    """Run the command."""
    import os
    from pathlib import Path

    from ..errors import EpibarError
    from ..jobs.given_rate import refuse_rate
    from ..jobs.inputs import CameraInput
    from ..jobs.tasks import record_camera
    from ..lens.cameras_toml import intrinsics_of
    from ..sources.source import source_name
    from .console import Console

    out = Path(args.out)
    if out.suffix.lower() != ".npz":
        raise EpibarError(f"--out {out}: the name of a recording ends in .npz")
    if not out.parent.is_dir():
        raise EpibarError(f"--out {out}: there is no folder {out.parent}")
    if os.path.realpath(out) == os.path.realpath(args.video):
        raise EpibarError(f"--out {out}: this is the input itself")
    refuse_rate([args.video], record_options(args))
    name = source_name(args.video)
    intrinsics = intrinsics_of(args.intrinsics, name) if args.intrinsics else None
    camera = CameraInput(name, args.video, 0, args.background, args.ignore, intrinsics)
    with Console(args.quiet, verbose=args.verbose) as console:
        recording, seconds = record_camera(
            camera,
            record_options(args),
            lambda stage, share: console.step(stage, share),
            pictures=False,
        )
        console.recorded(name, recording, seconds)
        recording.save(out)
        console.result(f"written: {out}")
    return DONE
