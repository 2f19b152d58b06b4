"""``epibar inspect``: what each camera is good for, before any pairing."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from .exit_codes import exit_code, explanation
from .options import CommandParser, add_output_options
from .recording_options import add_recording_options, record_options

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "inspect"
HELP = "what each camera is good for, before any pairing, and what is wrong with it"
DESCRIPTION = (
    "Print for each camera how much moved and where, how many lines are left after each filter, whether the "
    "camera stood still and the light stayed on, and what is wrong and what to do."
)
EXIT_CODES = explanation(partly="a video could not be read, what is said is of the others")


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.epilog = EXIT_CODES
    command.add_videos("a video, a folder of images, or a saved recording")
    add_recording_options(command, several=True)
    add_output_options(command, json="print it as JSON on stdout, all else on stderr; for programs")


def run(args: Namespace) -> int:
    """Run the command; every camera that can be read is inspected."""
    import json
    from dataclasses import replace

    from ..errors import EpibarError
    from ..health.inspection import inspect
    from ..jobs.given_rate import refuse_rate
    from ..jobs.inputs import CameraInput, one_each
    from ..jobs.tasks import record_camera
    from ..lens.cameras_toml import find_cameras, load_cameras
    from ..sources.source import source_name
    from .console import Console

    console = Console(args.quiet, json=args.json, verbose=args.verbose)
    count = len(args.videos)
    backgrounds = one_each("--background", args.background, count)
    ignored = one_each("--ignore", args.ignore, count)
    names = [source_name(video) for video in args.videos]
    lenses = find_cameras(load_cameras(args.intrinsics), names) if args.intrinsics else {}
    lacking = [name for name in names if name not in lenses] if args.intrinsics else []
    if lacking:
        console.warning(f"{args.intrinsics} does not have {', '.join(lacking)}: taken as filmed")
    options = record_options(args)
    refuse_rate(args.videos, options)
    entries: list[dict[str, Any]] = []
    for index, (name, video) in enumerate(zip(names, args.videos, strict=True)):
        camera = CameraInput(name, video, index, backgrounds[index], ignored[index])
        try:
            recording, _ = record_camera(
                replace(camera, intrinsics=lenses.get(camera.name)),
                options,
                console.interactive,
                pictures=False,
            )
        except EpibarError as error:
            console.error(str(error))
            continue
        diagnosis = inspect(recording)
        remarks = [text for text in recording.warnings if not _is_finding(text, diagnosis.findings)]
        entries.append({**diagnosis.as_dict(), "file": camera.shown, "warnings": remarks})
        if not args.json:
            console.result("\n" * (len(entries) > 1) + str(diagnosis))
            for remark in remarks:
                console.result(f"  note      {remark}")
            console.numbers("counted while the video was watched", recording.health)
    if args.json:
        console.json(json.dumps(entries, indent=1, allow_nan=False))
    return exit_code(len(entries), count - len(entries))


def _is_finding(warning: str, findings: tuple[Any, ...]) -> bool:
    """Whether a warning of the recording is one of the findings already."""
    return any(warning.endswith(finding.text) for finding in findings)
