"""Options of how a video is recorded, which ``calibrate``, ``record`` and ``inspect`` share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .options import CommandParser, frame_numbers, frame_rate, positive, seconds, seed_number

if TYPE_CHECKING:
    from ..jobs.inputs import RecordOptions

__all__ = ["add_recording_options", "record_options"]


def add_recording_options(command: CommandParser, several: bool) -> None:
    """Add them; ``several`` where the command takes more videos than one."""
    group = command.add_argument_group("how videos are recorded")
    group.add_argument(
        "--intrinsics",
        metavar="FILE.toml",
        help="camera matrices and distortion: give it for anything but a narrow lens, and whenever the "
        "matrices are known, for they settle much that motion leaves open",
    )
    _add_each(
        command,
        group,
        several,
        "--background",
        metavar="VIDEO",
        purpose=("a video of the empty scene", "videos of the empty scene, one per camera in the same order"),
        when="when people stand still for long",
    )
    _add_each(
        command,
        group,
        several,
        "--ignore",
        metavar="MASK.png",
        purpose=(
            "an image, white where motion does not count",
            "images, white where motion does not count, one per camera in the same order",
        ),
        when="for trees, screens, a clock in the picture",
    )
    group.add_argument(
        "--masks",
        action="store_true",
        help="the input already is black and white, white = moving: for masks of a segmenter of your own",
    )
    group.add_argument(
        "--foreground",
        choices=("auto", "mog2", "mixture", "knn", "median"),
        default="auto",
        help="background model: try another when the heat maps of the report show what did not move "
        "(default: %(default)s)",
    )
    group.add_argument(
        "--frames",
        type=frame_numbers,
        metavar="FIRST:LAST",
        help="use only these frames, LAST not included, and either may be left out, as in 250:; for a camera "
        "that was knocked, or a light that was switched",
    )
    group.add_argument(
        "--seconds",
        type=seconds,
        metavar="S",
        help="use only so many seconds, from the first frame used on: when the rest of a long video adds "
        "nothing; a live stream needs this, or a LAST",
    )
    group.add_argument(
        "--fps",
        type=frame_rate,
        metavar="N",
        help="frames per second: when folders of images are given, or masks that state none; not for videos, "
        "which do (default: 25, with a warning)",
    )
    group.add_argument(
        "--chapters",
        action="store_true",
        help="a folder of videos, or a pattern in quotes as in 'cam1_*.mp4', is one camera whose files "
        "follow one another: for action cameras, which begin a new file every few gigabytes",
    )
    group.add_argument(
        "--lines",
        type=positive,
        default=20_000,
        metavar="N",
        help="random lines per camera: more find more, and take longer; 40000 for low cameras or a pair "
        "refused as ambiguous (default: %(default)s)",
    )
    group.add_argument(
        "--seed",
        type=seed_number,
        default=0,
        metavar="N",
        help="of the lines and of the search; how flat motion is judged does not depend on it: change it to "
        "see what does (default: %(default)s)",
    )


def _add_each(
    command: CommandParser,
    group: argparse._ArgumentGroup,
    several: bool,
    option: str,
    purpose: tuple[str, str],
    when: str,
    **options: Any,
) -> None:
    """Add an option that takes one value, or one for each of several cameras, and say it of either."""
    of_one, of_each = purpose
    if several:
        command.add_for_each_video(group, option, help=f"{of_each}: {when}", **options)
    else:
        group.add_argument(option, help=f"{of_one}: {when}", **options)


def record_options(args: argparse.Namespace) -> RecordOptions:
    """Take what was given."""
    from ..jobs.inputs import RecordOptions
    from ..sources.frame_range import FrameRange

    frames = FrameRange.of(args.frames, args.seconds)
    return RecordOptions(args.lines, args.seed, args.masks, args.foreground, frames, args.chapters, args.fps)
