"""``epibar export``: the results of a run for other tools."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from .. import export
from ..errors import EpibarError
from ..lens.camera_file import load_cameras
from .console import Console

__all__ = ["run"]

PLAIN = {
    "opencv": export.write_opencv,
    "npz": export.write_npz,
    "colmap": export.write_colmap,
    "csv": export.write_csv,
}


def run(args: Namespace) -> int:
    """Run the command."""
    console = Console(args.quiet)
    found = export.Run.load(args.folder)
    out = Path(args.out)
    if out.resolve() in [file.resolve() for file in found.files]:
        raise EpibarError(f"--out {out}: this is part of the run itself")
    selected = found.selected(every=args.all)
    if args.intrinsics:
        selected = selected.with_intrinsics(load_cameras(args.intrinsics), args.intrinsics)
    known = any(camera.matrix is not None for camera in selected.cameras)
    if known and args.format != "csv":
        for reason in selected.poses()[1]:
            console.warning(f"without a pose: {reason}")
    if args.format in PLAIN:
        written = PLAIN[args.format](selected, out)
    else:
        written = export.write_toml(selected, out, args.intrinsics, caliscope=args.format == "caliscope")
        if len(written) > 1 or written[0] != out:
            console.warning("the pairs cannot be put into one world: a file for each; [metadata] says why")
    left_out = len(found.pairs) - len(selected.pairs)
    if left_out:
        console.note(f"left out: {left_out} of {len(found.pairs)} pairs, not accepted; --all takes them too")
    for path in written:
        console.result(f"written: {path}")
    return 0
