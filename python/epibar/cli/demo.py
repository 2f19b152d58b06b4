"""``epibar demo``: videos with a known answer, through the same path as a user's own."""

from __future__ import annotations

import time
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import EpibarError
from ..lens.camera_file import write_cameras
from ..lens.intrinsics import Intrinsics
from .console import Console
from .parser import build_parser

if TYPE_CHECKING:
    from ..synthetic import Camera

__all__ = ["run"]

CAMERAS = 3
WALKERS = 6
FRAMES = 500
EMPTY = 25
"""Frames of the empty scene before, for the background model to learn from."""
SIZE = (480, 360)


def run(args: Namespace) -> int:
    """Run the command."""
    from ..synthetic import people, render_video
    from . import calibrate, evaluate

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
    known = out / "cameras.toml"
    write_cameras(known, [_known(camera, index) for index, camera in enumerate(scene.cameras)])
    console.note(f"rendered ({time.perf_counter() - started:.1f} s)")

    words = ["calibrate", *map(str, sources), "--out", str(out), "--seed", str(args.seed)]
    console.note("the same as: epibar " + " ".join(words))
    code = calibrate.run(build_parser().parse_args(words + ["--quiet"] * args.quiet))
    if code:
        return code

    console.result("\nagainst the known answer:")
    evaluate.run(Namespace(calibration=str(out / "calibration.json"), cameras=str(known)))
    console.result(f"\nto look at, in any browser: {out / 'report.html'}")
    console.result(f"the pictures of matched epipolar lines: {out}/cam1_cam2.png, ...")
    console.result(f"everything else, F included: {out / 'calibration.json'}")
    return 0


def _known(camera: Camera, index: int) -> Intrinsics:
    """Describe a camera of the scene the way ``--intrinsics`` and ``--cameras`` read it."""
    import cv2

    rotation = np.asarray(cv2.Rodrigues(camera.R)[0], dtype=np.float64).ravel()
    return Intrinsics(f"cam{index + 1}", camera.size, camera.K, rotation=rotation, translation=camera.t)
