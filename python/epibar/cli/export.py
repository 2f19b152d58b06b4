"""``epibar export``: the results of a run for other tools."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from ..camera_files.formats import FORMATS as CAMERA_FORMATS
from ..export.formats import FORMATS
from .exit_codes import DONE
from .options import CommandParser, add_output_options

if TYPE_CHECKING:
    from pathlib import Path

    from ..runs.run import Run
    from .console import Console

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "export"
HELP = "write the results for OpenCV, NumPy, COLMAP, aniposelib, Caliscope, or as CSV"
OF_CAMERAS = {"anipose": "anipose", "toml": "anipose", "caliscope": "caliscope"}
"""Formats that hold cameras and nothing else, and what each is called among those of cameras."""

DESCRIPTION = (
    "Write what 'epibar calibrate' found in a form that other tools read. "
    + " ".join(f"{name}: {one.what}." for name, one in FORMATS.items())
    + " Where there is a network, camera files hold its accepted cameras, which --cameras writes as well: "
    + "; ".join(f"{name}: {one.what}" for name, one in CAMERA_FORMATS.items())
    + ". Without one poses need intrinsics."
)


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.add_argument("folder", metavar="DIR", help="what was --out of 'epibar calibrate'")
    command.add_argument("--format", required=True, choices=tuple(FORMATS), help="of the file")
    command.add_argument(
        "--cameras",
        action="store_true",
        help="the cameras of the network, also where the format has pairs: opencv, npz, colmap",
    )
    command.add_argument("-o", "--out", required=True, metavar="PATH", help="the file to write")
    command.add_argument(
        "--all",
        action="store_true",
        help="refused pairs too, marked with their verdict; to look into a refusal",
    )
    command.add_argument(
        "--intrinsics",
        metavar="FILE.toml",
        help="camera matrices, where the run was made without; lenses for toml and caliscope "
        "(default: the file that the run was made with)",
    )
    add_output_options(command)


def run(args: Namespace) -> int:
    """Run the command."""
    from pathlib import Path

    from ..errors import EpibarError
    from ..jobs.network_files import NETWORK
    from ..lens.camera_file import load_cameras
    from ..runs.run import Run
    from .console import Console

    console = Console(args.quiet, verbose=args.verbose)
    found = Run.load(args.folder)
    out = Path(args.out)
    network = found.files[0].parent / NETWORK
    if out.resolve() in [file.resolve() for file in (*found.files, network)]:
        raise EpibarError(f"--out {out}: this is part of the run itself")
    if args.cameras or (args.format in OF_CAMERAS and network.exists()):
        return _export_cameras(args, found, network, out, console)
    selected = found.selected(every=args.all)
    if args.intrinsics:
        selected = selected.with_intrinsics(load_cameras(args.intrinsics), args.intrinsics)
    chosen = FORMATS[args.format]
    known = any(camera.matrix is not None for camera in selected.cameras)
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
    return DONE


def _export_cameras(args: Namespace, run: Run, file: Path, out: Path, console: Console) -> int:
    """Write the accepted cameras of the network."""
    from ..errors import EpibarError
    from ..network import Network

    chosen = OF_CAMERAS.get(args.format, args.format)
    if chosen not in CAMERA_FORMATS:
        raise EpibarError(
            f"--format {args.format} has no cameras; --cameras is for {', '.join(CAMERA_FORMATS)}"
        )
    if not file.exists():
        raise EpibarError(
            f"{file}: there is no network in this run; calibrate three cameras, or two with intrinsics"
        )
    network = Network.load(file)
    lenses = run.lenses(args.intrinsics)
    written = network.export(out, chosen, lenses)
    for name in network.left_out:
        console.warning(f"left out: {name}: {network.cameras[name].reason}")
    if network.unit != "metre":
        console.note("lengths are not in metres: 'epibar scale' makes them so")
    for path in written:
        console.result(f"written: {path}")
    return DONE
