"""``epibar record``: one camera's video in, a small file out."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from ..errors import EpibarError
from ..jobs.inputs import Camera, source_name
from ..jobs.tasks import record_camera
from ..lens.camera_file import intrinsics_of
from .calibrate import record_options
from .console import Console

__all__ = ["run"]


def run(args: Namespace) -> int:
    """Run the command."""
    out = Path(args.out)
    if out.suffix.lower() != ".npz":
        raise EpibarError(f"--out {out}: the name of a recording ends in .npz")
    if not out.parent.is_dir():
        raise EpibarError(f"--out {out}: there is no folder {out.parent}")
    if out.resolve() == Path(args.video).resolve():
        raise EpibarError(f"--out {out}: this is the input itself")
    name = source_name(args.video)
    intrinsics = intrinsics_of(args.intrinsics, name) if args.intrinsics else None
    camera = Camera(
        name=name,
        source=args.video,
        index=0,
        background=args.background[0] if args.background else None,
        ignore=args.ignore[0] if args.ignore else None,
        intrinsics=intrinsics,
    )
    with Console(args.quiet) as console:
        recording, seconds = record_camera(
            camera, record_options(args), lambda stage, share: console.progress(stage, share, 1)
        )
        console.recorded(name, recording, seconds)
        recording.save(out)
        console.result(f"written: {out}")
    return 0
