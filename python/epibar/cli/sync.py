"""``epibar sync``: from where to keep each video, so that all start and end together."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from .exit_codes import DONE
from .options import CommandParser, add_output_options, add_run_folder

if TYPE_CHECKING:
    from ..outcome.sync import CameraStart

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "sync"
HELP = "from which frame on to keep each video, so that all start together"
DESCRIPTION = (
    "Print when the accepted cameras of the network in DIR were started against each other, and which frames "
    "of each video to keep for a common start and end, with the command lines of ffmpeg that cut the "
    "videos. Nothing is cut, and nothing in DIR is changed."
)
HEADER = ("camera", "offset", "in frames", "drift", "keep frames", "keep seconds")


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    add_run_folder(command)
    command.add_argument(
        "--commands",
        action="store_true",
        help="print only the commands that cut: when a POSIX shell is to run them",
    )
    add_output_options(
        command, json="print the table as one JSON object on stdout, all else on stderr; for programs"
    )


def run(args: Namespace) -> int:
    """Run the command."""
    from pathlib import Path

    from ..errors import EpibarError
    from ..files.json_file import json_text
    from ..jobs.inputs import NETWORK_FILE, RESULT
    from ..outcome.stored_network import network_of_run
    from ..outcome.sync import starts_of_run
    from .console import Console

    folder = Path(args.folder)
    file, result = folder / NETWORK_FILE, folder / RESULT
    if result.exists() and not file.exists():
        raise EpibarError(f"{file}: there is no network in this run, and so no clocks of all cameras")
    with Console(args.quiet, json=args.json, verbose=args.verbose) as console:
        network = network_of_run(file, result)
        starts = starts_of_run(folder, network)
        for line in [] if args.commands else _table(starts):
            console.result(line)
        for one in starts:
            if one.command is not None and not args.json:
                # As it is: a changed command would cut another file, and it holds no control characters.
                print(one.command, flush=True)
            elif one.absent:
                console.warning(
                    f"{one.name}: no command, for {one.file} is not there; where that is no full path, call "
                    "this in the folder in which 'epibar calibrate' was"
                )
            elif one.command is None:
                console.note(f"{one.name}: {one.file} is no video file that ffmpeg could cut")
        for name in network.left_out:
            console.warning(f"left out: {name}: {network.cameras[name].why_left_out}")
        with_clock_or_reason = [*network.left_out, *(one.name for one in starts)]
        for name in [name for name in network.cameras if name not in with_clock_or_reason]:
            console.warning(f"left out: {name}: it was added by later films, of which the run knows no clock")
        if args.json:
            console.json(json_text({"cameras": [one.as_dict() for one in starts]}))
    return DONE


def _table(starts: list[CameraStart]) -> list[str]:
    from ..files.text_table import aligned

    return aligned([HEADER, *map(_row, starts)])


def _row(one: CameraStart) -> tuple[str, ...]:
    time = one.time
    error = "" if time.error is None else f" ± {time.error:.3f}"
    last_frame = "" if time.last_frame is None else str(time.last_frame)
    last_second = "" if time.last_second is None else f"{time.last_second:.3f}"
    return (
        one.name,
        f"{time.offset:+.3f}{error} s",
        f"{time.offset_frames:+.2f}",
        f"{time.drift:+.1f} ppm",
        f"{time.first_frame} - {last_frame}",
        f"{time.first_second:.3f} - {last_second}",
    )
