"""``epibar demo``: videos with a known answer, through the same path as a user's own."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from . import calibrate, evaluate
from .exit_codes import DONE
from .options import CommandParser, add_output_options, seed_number

if TYPE_CHECKING:
    from pathlib import Path

    from ..lens.intrinsics import Intrinsics
    from ..synthetic.camera import Camera
    from ..synthetic.staging import Staging
    from .console import Console

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "demo"
HELP = "render videos of a crowd, calibrate their cameras, compare with the known answer"
DESCRIPTION = (
    "Render noisy videos of walking people from cameras that nobody knows, calibrate them the way your own "
    "videos would be, and compare with the known answer."
)

CAMERAS = 4
FEWEST, MOST = 2, 12
WALKERS = 8
SECONDS = 40.0
EMPTY = 25
"""Frames of the empty scene before, for the background model to learn from."""
SIZE = (640, 480)


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.add_argument(
        "-o",
        "--out",
        default="demo",
        metavar="DIR",
        help="folder for videos and results: another one to keep those of an earlier demo "
        "(default: %(default)s)",
    )
    command.add_argument(
        "--seed",
        type=seed_number,
        default=0,
        metavar="N",
        help="of scene and draws: change it to see other cameras and walkers (default: %(default)s)",
    )
    command.add_argument(
        "--cameras",
        type=int,
        choices=range(FEWEST, MOST + 1),
        default=CAMERAS,
        metavar="N",
        help=f"how many, {FEWEST} to {MOST}: as many as you have; two give no network (default: %(default)s)",
    )
    clocks = command.add_mutually_exclusive_group()
    clocks.add_argument(
        "--unsynchronised",
        action="store_true",
        default=True,
        help="cameras started by hand, at 25 or 30 frames a second, as phones are (the default)",
    )
    clocks.add_argument(
        "--synchronised",
        dest="unsynchronised",
        action="store_false",
        help="cameras triggered together: when yours are",
    )
    command.add_argument(
        "--lens",
        choices=("barrel", "none"),
        default="barrel",
        help="whether lenses bend lines: 'none' when yours do not, and to compare pairs by themselves too "
        "(default: %(default)s)",
    )
    add_output_options(command)
    command.epilog = calibrate.EXIT_CODES


def run(args: Namespace) -> int:
    """Run the command."""
    from pathlib import Path

    from ..errors import EpibarError
    from ..lens.cameras_toml import write_cameras
    from ..synthetic.figures import MEAN_HEIGHT
    from ..synthetic.staging import stage
    from .console import Console

    console = Console(args.quiet)
    out = Path(args.out)
    try:
        (out / "videos").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EpibarError(f"--out {out}: cannot be made ({error.strerror})") from error

    staging = stage(
        args.seed,
        cameras=args.cameras,
        walkers=WALKERS,
        seconds=SECONDS,
        size=SIZE,
        barrel=args.lens == "barrel",
        unsynchronised=args.unsynchronised,
        empty_frames=EMPTY,
    )
    sources = _rendered(staging, out / "videos", console)
    known = out / "known_cameras.toml"
    write_cameras(known, [_known(camera) for camera in staging.cameras])

    arguments = ["calibrate", *map(str, sources), "--out", str(out), "--seed", str(args.seed)]
    if not args.unsynchronised:
        arguments += ["--time-offset", "0"]
    if args.cameras > FEWEST:
        arguments += ["--person-height", str(MEAN_HEIGHT)]
    console.note("the same as: epibar " + " ".join(arguments))
    parser = CommandParser()
    calibrate.add_options(parser)
    code = calibrate.run(
        parser.parse_args(arguments[1:] + ["--quiet"] * args.quiet + ["--verbose"] * args.verbose)
    )
    if code != DONE:
        return code
    _compare(out, known, staging, console)
    _where_to_look(out, console)
    return DONE


def _rendered(staging: Staging, folder: Path, console: Console) -> list[Path]:
    """Render a video for each camera."""
    import time

    from ..errors import EpibarError

    started = time.perf_counter()
    count = len(staging.clocks)
    console.note(
        f"rendering {count} noisy videos: {staging.empty_frames} frames without anybody, then "
        f"{SECONDS:g} s of {WALKERS} walking people ..."
    )
    sources = []
    try:
        with console:
            for index in range(count):
                console.step("rendering", index, count)
                sources.append(staging.render(index, folder / f"cam{index + 1}.mp4"))
    except OSError as error:
        raise EpibarError(str(error)) from error
    console.note(f"rendered ({time.perf_counter() - started:.1f} s)")
    return sources


def _compare(out: Path, known: Path, staging: Staging, console: Console) -> None:
    """Hold the network against the true cameras; pairs too, where no lens is between the two."""
    from ..network.result import Network
    from .demo_answer import compared

    console.result("\nagainst the known answer:")
    network = out / "network.json"
    if network.exists():
        for line in compared(Network.load(network), staging):
            console.result(line)
    if not any(camera.distorted for camera in staging.cameras):
        evaluate.run(
            Namespace(
                calibration=str(out / "calibration.json"),
                cameras=str(known),
                json=False,
                quiet=False,
                verbose=False,
            )
        )
    elif not network.exists():
        console.result("there is no network, and pairs alone have no lens to be compared with")


def _where_to_look(out: Path, console: Console) -> None:
    console.result(f"\nto look at, in any browser: {out / 'report.html'}")
    if (out / "cameras.toml").exists():
        console.result(f"the calibrated cameras, for other programs: {out / 'cameras.toml'}")
    console.result(f"the pictures of matched epipolar lines: {out}/cam1_cam2.png, ...")
    console.result(f"everything else, F included: {out / 'calibration.json'}")


def _known(camera: Camera) -> Intrinsics:
    """Describe a camera of the scene the way ``--intrinsics`` and ``--cameras`` read it."""
    import numpy as np

    from ..lens.intrinsics import Intrinsics, rotation_vector

    distortions = np.array(camera.distortions or (0.0,) * 5)
    rotation = rotation_vector(camera.R)
    return Intrinsics(
        camera.name, camera.size, camera.K, distortions, rotation=rotation, translation=camera.t
    )
