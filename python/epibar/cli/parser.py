"""The arguments of every command. Standard library only: this is what ``--help`` waits for."""

from __future__ import annotations

import argparse
import math
import re

__all__ = ["build_parser"]

EPILOG = (
    "Exit codes: 0 done (a refused pair is a result too: read its verdict); 2 unusable input, or a camera or "
    "a pair that could not be done (the others are written all the same); 130 interrupted."
)


def build_parser() -> argparse.ArgumentParser:
    """Make the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="epibar",
        description="Epipolar geometry of stationary cameras from what moves in front of them.",
        epilog=EPILOG,
    )
    parser.add_argument("--version", action=_Version)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_calibrate(commands)
    _add_record(commands)
    _add_inspect(commands)
    _add_evaluate(commands)
    _add_export(commands)
    _add_demo(commands)
    return parser


def _add_calibrate(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "calibrate",
        help="videos in, a fundamental matrix and a verdict for every pair out",
        description="Find the fundamental matrix of every pair of cameras. Writes calibration.json, "
        "report.html to look at, and for each pair a picture with matched epipolar lines and the frontier "
        "points as CSV. Recordings and pairs are kept in DIR: the same command again, or with one more "
        "camera, does only what is missing.",
        epilog=EPILOG,
    )
    command.add_argument(
        "videos",
        nargs="+",
        metavar="VIDEO",
        help="one per camera: a video, a folder of images, or a saved recording",
    )
    command.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the results; made if it is missing"
    )
    command.add_argument(
        "--method", choices=("frontier", "lines"), default="frontier", help="default: %(default)s"
    )
    command.add_argument(
        "--time-offset",
        type=_time_offset,
        default=0.0,
        metavar="N|search",
        help="frame i of the first camera is frame i + N of the second; 'search' finds it (default: 0)",
    )
    command.add_argument(
        "--search-seconds",
        type=_seconds,
        default=21.0,
        metavar="S",
        help="how far either way '--time-offset search' looks; a wider search asks for more evidence "
        "(default: %(default)g)",
    )
    command.add_argument(
        "--any-way-up", action="store_true", help="do not assume that all cameras are the right way up"
    )
    command.add_argument(
        "--no-essential",
        dest="essential",
        action="store_false",
        help="use camera matrices, of --intrinsics or in saved recordings, for the lens alone: F need not be "
        "an essential matrix under them",
    )
    command.add_argument(
        "--scheduler",
        type=_scheduler,
        metavar="ADDRESS",
        help="run on Dask: tcp://host:port of its scheduler, or 'local' for a process per core here",
    )
    command.add_argument("--fresh", action="store_true", help="do everything again, whatever is kept in DIR")
    command.add_argument("--no-report", dest="report", action="store_false", help="do not write report.html")
    command.add_argument(
        "--json", action="store_true", help="print calibration.json on stdout, all else on stderr"
    )
    _add_recording_options(command, several=True)


def _add_record(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "record",
        help="one video in, a small recording out that any other can be matched with",
        description="Turn one camera's video into a recording: lines with barcodes, silhouettes, no images.",
        epilog=EPILOG,
    )
    command.add_argument("video", metavar="VIDEO", help="a video or a folder of images")
    command.add_argument("--out", required=True, metavar="FILE.npz", help="the file to write")
    _add_recording_options(command, several=False)


def _add_inspect(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "inspect",
        help="what each camera is good for, before any pairing, and what is wrong with it",
        description="Print for each camera how much moved and where, how many lines are left after each "
        "filter, whether the camera stood still and the light stayed on, and what is wrong and what to do.",
        epilog="Exit codes: 0 done (read what was found), 2 unusable input, 130 interrupted.",
    )
    command.add_argument(
        "videos", nargs="+", metavar="VIDEO", help="a video, a folder of images, or a saved recording"
    )
    command.add_argument("--json", action="store_true", help="print it for programs")
    _add_recording_options(command, several=True)


def _add_recording_options(command: argparse.ArgumentParser, several: bool) -> None:
    many = {"nargs": "+"} if several else {"nargs": 1}
    each = "one per camera, in the same order" if several else "of this camera"
    command.add_argument(
        "--intrinsics", metavar="FILE.toml", help="camera matrices and distortion; see the README"
    )
    command.add_argument("--background", metavar="VIDEO", help=f"videos of the empty scene, {each}", **many)
    command.add_argument(
        "--ignore", metavar="MASK.png", help=f"images, white where motion is ignored, {each}", **many
    )
    command.add_argument(
        "--masks", action="store_true", help="the input already is black and white, white = moving"
    )
    command.add_argument(
        "--foreground", choices=("mog2", "knn", "median"), default="mog2", help="default: %(default)s"
    )
    command.add_argument(
        "--frames",
        type=_frames,
        metavar="FIRST:LAST",
        help="use only these frames, LAST not included; either may be left out, as in 250:",
    )
    command.add_argument(
        "--lines", type=_positive, default=20_000, metavar="N", help="per camera; default: %(default)s"
    )
    command.add_argument(
        "--seed", type=_seed, default=0, metavar="N", help="of every random draw; default: 0"
    )
    command.add_argument("--quiet", action="store_true", help="print errors only")


def _add_evaluate(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "evaluate",
        help="compare a calibration with known cameras",
        description="Print for every pair the symmetric epipolar distance over the image and over the volume "
        "where things moved, against cameras whose pose is known.",
        epilog=EPILOG,
    )
    command.add_argument("calibration", metavar="calibration.json", help="what 'epibar calibrate' wrote")
    command.add_argument("--cameras", required=True, metavar="FILE.toml", help="the known cameras, with pose")


def _add_export(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "export",
        help="write the results for OpenCV, NumPy, COLMAP, aniposelib, Caliscope, or as CSV",
        description="Write what 'epibar calibrate' found in a form that other tools read. opencv: "
        "FileStorage YAML. npz: NumPy arrays. colmap: a database with the frontier points as verified "
        "matches. csv: the frontier points. toml and caliscope: camera files of aniposelib and Caliscope "
        "with rotations and translations, which needs intrinsics.",
        epilog=EPILOG,
    )
    command.add_argument("folder", metavar="DIR", help="what was --out of 'epibar calibrate'")
    command.add_argument(
        "--format", required=True, choices=("opencv", "npz", "colmap", "csv", "toml", "caliscope")
    )
    command.add_argument("--out", required=True, metavar="PATH", help="the file to write")
    command.add_argument("--all", action="store_true", help="refused pairs too, marked with their verdict")
    command.add_argument(
        "--intrinsics",
        metavar="FILE.toml",
        help="camera matrices, where the run was made without; lenses for toml and caliscope "
        "(default: the file that the run was made with)",
    )
    command.add_argument("--quiet", action="store_true", help="print errors only")


def _add_demo(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "demo",
        help="render videos of a crowd, calibrate them, compare with the known answer",
        description="Render noisy videos of walking people from three cameras, calibrate them the way "
        "your own videos would be, and compare with the known answer.",
        epilog=EPILOG,
    )
    command.add_argument("--out", default="demo", metavar="DIR", help="default: %(default)s")
    command.add_argument("--seed", type=_seed, default=0, metavar="N", help="of scene and draws; default: 0")
    command.add_argument("--quiet", action="store_true", help="print the result only")


class _Version(argparse.Action):
    """``--version``, which looks the version up only when asked."""

    def __init__(self, option_strings: list[str], dest: str, **_: object) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, nargs=0, help="show the version and exit")

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"epibar {version('epibar')}")
        parser.exit()


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None


def _positive(text: str) -> int:
    number = _whole(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{number} is too small: it must be at least 1")
    return number


def _seed(text: str) -> int:
    number = _whole(text)
    if not 0 <= number < 2**64:
        raise argparse.ArgumentTypeError(f"{number} is out of range: it must be between 0 and 2^64 - 1")
    return number


def _frames(text: str) -> tuple[int | None, int | None]:
    first, colon, last = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"{text!r} is not FIRST:LAST, such as 250:1000")
    return _whole(first) if first else None, _whole(last) if last else None


def _scheduler(text: str) -> str:
    if text == "local" or re.fullmatch(r"(tcp|tls)://[^\s/]+:\d+", text):
        return text
    raise argparse.ArgumentTypeError(f"{text!r} is neither 'local' nor an address like tcp://10.0.0.5:8786")


def _seconds(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number of seconds")
    return number


def _time_offset(text: str) -> float | str:
    if text == "search":
        return text
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number of frames nor 'search'")
    return number
