"""``epibar demo``: videos with a known answer, through the same path as a user's own."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from . import calibrate, evaluate
from .exit_codes import DONE
from .options import CommandParser, add_output_options, seed_number

if TYPE_CHECKING:
    from ..lens.intrinsics import Intrinsics
    from ..synthetic.camera import Camera

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "demo"
HELP = "render videos of a crowd, calibrate them, compare with the known answer"
DESCRIPTION = (
    "Render noisy videos of walking people from three cameras, calibrate them the way your own videos would "
    "be, and compare with the known answer."
)

CAMERAS = 3
WALKERS = 6
FRAMES = 500
EMPTY = 25
"""Frames of the empty scene before, for the background model to learn from."""
SIZE = (480, 360)


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.add_argument(
        "-o",
        "--out",
        default="demo",
        metavar="DIR",
        help="folder for videos and results (default: %(default)s)",
    )
    command.add_argument(
        "--seed",
        type=seed_number,
        default=0,
        metavar="N",
        help="of scene and draws: another one, other walkers (default: %(default)s)",
    )
    add_output_options(command)


def run(args: Namespace) -> int:
    """Run the command."""
    import time
    from pathlib import Path

    from ..errors import EpibarError
    from ..lens.camera_file import write_cameras
    from ..synthetic import people, render_video
    from .console import Console

    console = Console(args.quiet)
    out = Path(args.out)
    videos = out / "videos"
    try:
        videos.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EpibarError(f"--out {out}: cannot be made ({error.strerror})") from error

    started = time.perf_counter()
    scene = people(seed=args.seed, cameras=CAMERAS, walkers=WALKERS, frames=FRAMES, size=SIZE)
    console.note(
        f"rendering {CAMERAS} noisy videos: {EMPTY} frames without anybody, then {FRAMES} "
        f"of {WALKERS} walking people ..."
    )
    try:
        sources = []
        with console:
            for index in range(CAMERAS):
                console.progress("rendering", index, CAMERAS)
                path = videos / f"cam{index + 1}.mp4"
                sources.append(render_video(scene, index, path, seed=args.seed, empty_frames=EMPTY))
    except OSError as error:
        raise EpibarError(str(error)) from error
    known = out / "known_cameras.toml"
    write_cameras(known, [_known(camera, index) for index, camera in enumerate(scene.cameras)])
    console.note(f"rendered ({time.perf_counter() - started:.1f} s)")

    words = ["calibrate", *map(str, sources), "--out", str(out), "--seed", str(args.seed)]
    console.note("the same as: epibar " + " ".join(words))
    parser = CommandParser()
    calibrate.add_options(parser)
    code = calibrate.run(
        parser.parse_args(words[1:] + ["--quiet"] * args.quiet + ["--verbose"] * args.verbose)
    )
    if code != DONE:
        return code

    console.result("\nagainst the known answer:")
    found = out / "calibration.json"
    evaluate.run(
        Namespace(calibration=str(found), cameras=str(known), json=False, quiet=False, verbose=False)
    )
    console.result(f"\nto look at, in any browser: {out / 'report.html'}")
    console.result(f"the pictures of matched epipolar lines: {out}/cam1_cam2.png, ...")
    console.result(f"everything else, F included: {found}")
    return DONE


def _known(camera: Camera, index: int) -> Intrinsics:
    """Describe a camera of the scene the way ``--intrinsics`` and ``--cameras`` read it."""
    import cv2
    import numpy as np

    from ..lens.intrinsics import Intrinsics

    rotation = np.asarray(cv2.Rodrigues(camera.R)[0], dtype=np.float64).ravel()
    return Intrinsics(f"cam{index + 1}", camera.size, camera.K, rotation=rotation, translation=camera.t)
