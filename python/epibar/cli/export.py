"""``epibar export``: the results of a run for other tools."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from ..errors import EpibarError
from ..export.formats import FORMATS
from ..lens.camera_file import load_cameras
from ..runs.run import Run
from .console import Console

__all__ = ["run"]


def run(args: Namespace) -> int:
    """Run the command."""
    console = Console(args.quiet)
    found = Run.load(args.folder)
    out = Path(args.out)
    if out.resolve() in [file.resolve() for file in found.files]:
        raise EpibarError(f"--out {out}: this is part of the run itself")
    selected = found.selected(every=args.all)
    if args.intrinsics:
        selected = selected.with_intrinsics(load_cameras(args.intrinsics), args.intrinsics)
    known = any(camera.matrix is not None for camera in selected.cameras)
    chosen = FORMATS[args.format]
    if known and chosen.poses:
        for reason in selected.poses()[1]:
            console.warning(f"without a pose: {reason}")
    if chosen.lenses:
        written = chosen.write(selected, out, args.intrinsics)
        if len(written) > 1 or written[0] != out:
            console.warning("the pairs cannot be put into one world: a file for each; [metadata] says why")
    else:
        written = chosen.write(selected, out)
    left_out = len(found.pairs) - len(selected.pairs)
    if left_out:
        console.note(f"left out: {left_out} of {len(found.pairs)} pairs, not accepted; --all takes them too")
    for path in written:
        console.result(f"written: {path}")
    return 0
