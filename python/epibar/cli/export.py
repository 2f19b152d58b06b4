"""``epibar export``: the results of a run for other programs."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from ..camera_export.formats import ALIASES
from ..export import CAMERA_FORMATS, PAIR_FORMATS, TRACK_FORMATS
from .exit_codes import DONE
from .options import CommandParser, add_output_options, add_run_folder

if TYPE_CHECKING:
    from pathlib import Path

    from ..network import Network
    from ..network.walkers import WalkerTracks
    from ..outcome.run import Run
    from .console import Console

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "export"
HELP = "write the cameras, the pairs or the walkers of a run for another program; 'epibar formats' lists them"

DESCRIPTION = (
    "Write what 'epibar calibrate' found in a form that another program reads. "
    f"Pairs: {', '.join(PAIR_FORMATS)}. Cameras: {', '.join(CAMERA_FORMATS)}; a name of both stands "
    f"for the pairs, unless --cameras is given. Walkers: {', '.join(TRACK_FORMATS)}. "
    "'epibar formats' tells what each writes and what it loses. "
    "Where there is a network, its accepted cameras are written; else those of the pairs, put into one "
    "world, which needs intrinsics."
)

NOT_METRES = "lengths are not in metres: 'epibar scale' makes them so"


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    names = tuple(dict.fromkeys([*CAMERA_FORMATS, *PAIR_FORMATS, *TRACK_FORMATS, *ALIASES]))
    both = ", ".join(name for name in PAIR_FORMATS if name in CAMERA_FORMATS)
    add_run_folder(command)
    command.add_argument(
        "--format",
        required=True,
        choices=names,
        help="the program that is to read it; where several may, 'epibar formats' says what each loses",
    )
    command.add_argument(
        "--cameras",
        action="store_true",
        help="write the cameras of the network: when they are wanted in a format that has pairs too, which "
        f"are written otherwise: {both}",
    )
    command.add_argument(
        "-o",
        "--out",
        required=True,
        metavar="PATH",
        help="the file or folder to write; 'epibar formats' says which, and where the program looks for it",
    )
    command.add_argument(
        "--all",
        action="store_true",
        help="refused pairs too, marked with their verdict: to look into a refusal",
    )
    command.add_argument(
        "--intrinsics",
        metavar="FILE.toml",
        help="camera matrices and lenses: when the run was made without, or its camera file is not there any "
        "more (default: the file that the run was made with)",
    )
    add_output_options(command)


def run(args: Namespace) -> int:
    """Run the command."""
    import os
    from pathlib import Path

    from ..errors import EpibarError
    from ..jobs.folder import is_part_of_run
    from ..jobs.inputs import NETWORK_FILE, TRACKS_FILE
    from ..lens.cameras_toml import load_cameras, not_used
    from ..outcome.run import Run
    from .console import Console

    found = Run.load(args.folder)
    out = Path(args.out)
    network = found.files[0].parent / NETWORK_FILE
    used = (*found.files, network, network.parent / TRACKS_FILE, found.intrinsics, args.intrinsics)
    own = {os.path.realpath(file) for file in used if file}
    if os.path.realpath(out) in own or is_part_of_run(network.parent, out):
        raise EpibarError(f"--out {out}: this is part of the run itself; give another file or folder")
    chosen = ALIASES.get(args.format, args.format)
    of_cameras = args.cameras or chosen not in PAIR_FORMATS
    with Console(args.quiet, verbose=args.verbose) as console, console.warnings():
        if chosen in TRACK_FORMATS and not args.cameras:
            written = _export_tracks(out, chosen, found, network, console)
        elif args.cameras or (of_cameras and network.exists()):
            written = _export_network(args, chosen, found, network, console)
        else:
            selected = found.selected(every=args.all)
            if args.intrinsics:
                known = load_cameras(args.intrinsics)
                selected = selected.with_intrinsics(known, args.intrinsics)
                strange = not_used(known, selected.some_in(known, args.intrinsics).values())
                if strange:
                    console.warning(f"{args.intrinsics}: no camera is called {', '.join(strange)}")
            written = _export_pairs(args, chosen, selected, of_cameras, console)
            left_out = len(found.pairs) - len(selected.pairs)
            if left_out:
                remark = f"left out: {left_out} of {len(found.pairs)} pairs, not accepted"
                console.note(f"{remark}; --all takes them too")
        for path in written:
            console.result(f"written: {path}")
    return DONE


def _export_pairs(args: Namespace, chosen: str, run: Run, of_cameras: bool, console: Console) -> list[Path]:
    """Write the pairs, or the cameras as the pairs place them."""
    from pathlib import Path

    from ..pair_export.placed import write_placed

    known = any(camera.matrix is not None for camera in run.cameras)
    if known and chosen != "csv":
        for reason in run.poses()[1]:
            console.warning(f"without a pose: {reason}")
    out = Path(args.out)
    if not of_cameras:
        return PAIR_FORMATS[chosen].write(run, out)
    written = write_placed(run, out, chosen, args.intrinsics)
    if out not in written and out not in [path.parent for path in written]:
        console.warning("the pairs cannot be put into one world: a file for each, which says why")
    return written


def _export_network(args: Namespace, chosen: str, run: Run, file: Path, console: Console) -> list[Path]:
    """Write the accepted cameras of the network."""
    from ..errors import EpibarError
    from ..jobs.inputs import TRACKS_FILE

    if chosen not in CAMERA_FORMATS:
        raise EpibarError(
            f"--format {args.format} has no cameras; --cameras is for {', '.join(CAMERA_FORMATS)}"
        )
    network = _network(file, run)
    found = len(network.left_out) < len(network.cameras)
    if args.intrinsics and found and all(camera.matrix is None for camera in run.cameras):
        raise EpibarError(
            f"--intrinsics {args.intrinsics}: this run was made without intrinsics, and its network has "
            "lenses of its own: leave it out"
        )
    table = file.parent / TRACKS_FILE
    wanted = CAMERA_FORMATS[chosen]
    tracks, points = None, None
    if wanted.points:
        tracks = _followed(file.parent, run, network, console)
        points = {(pair.a, pair.b): pair.frontier_points for pair in run.pairs if pair.accepted}
    elif wanted.tracks and table.exists():
        tracks = _walkers(table, network.unit, console)
    written = network.export(
        args.out, chosen, run.lenses(args.intrinsics, network.known_lenses), tracks, points
    )
    if network.unit != "metre":
        console.note(NOT_METRES)
    return written


def _network(file: Path, run: Run) -> Network:
    """Read the network of a run."""
    from ..errors import EpibarError
    from ..outcome.stored_network import network_of_run

    if not file.exists():
        raise EpibarError(
            f"{file}: there is no network in this run; calibrate three cameras, or two with intrinsics"
        )
    return network_of_run(file, run.files[0])


def _export_tracks(out: Path, chosen: str, run: Run, file: Path, console: Console) -> list[Path]:
    """Write the walkers that the run followed."""
    from ..errors import EpibarError
    from ..jobs.inputs import TRACKS_FILE
    from ..network.tracks_csv import load_tracks

    network, table = _network(file, run), file.parent / TRACKS_FILE
    if not table.exists():
        raise EpibarError(
            f"{table}: this run followed no walkers, as where no floor was found, or fewer than two cameras "
            "were accepted"
        )
    tracks = load_tracks(table)
    if len(tracks) and tracks.unit != network.unit:
        raise EpibarError(
            f"{table}: in {tracks.unit}s, and the network in {network.unit}s; 'epibar calibrate' with the "
            "same videos writes both anew"
        )
    written = TRACK_FORMATS[chosen].write(tracks, out)
    if network.unit != "metre":
        console.note(NOT_METRES)
    return written


def _followed(folder: Path, run: Run, network: Network, console: Console) -> WalkerTracks | None:
    """Follow walkers anew: a table has no place for what each camera saw. Where that fails it is said."""
    from ..errors import EpibarError
    from ..files.calibration_json import read_json
    from ..jobs.inputs import RESULT
    from ..jobs.update_files import MOVED_KIND
    from ..network.walkers import height_on_floor
    from ..outcome.recordings import recording_of
    from ..outcome.stored import entries

    if height_on_floor(network) is None:
        return None
    names = []
    for name, camera in network.cameras.items():
        if not camera.accepted:
            continue
        if name not in run.by_name:
            console.warning(f"without walkers in {name}, which was added after they were recorded")
            continue
        kinds = {pair.kind for pair in run.pairs if name in (pair.a, pair.b)}
        if kinds == {MOVED_KIND}:
            console.warning(f"without walkers in {name}, which moved after it was recorded")
        else:
            names.append(name)
    try:
        cameras = entries(folder / RESULT, read_json(folder / RESULT), "cameras")
        by_name = {entry.text("name"): entry for entry in cameras}
        recordings = {name: recording_of(folder, by_name[name]) for name in names}
        return network.tracks(recordings, lambda stage, share: console.step(stage, share))
    except EpibarError as error:
        console.warning(f"without tops and bottoms of walkers: {error}")
        return None


def _walkers(table: Path, unit: str, console: Console) -> WalkerTracks | None:
    """Read the walkers of a run; where they do not fit, it is said, and the cameras go without them."""
    from ..errors import EpibarError
    from ..network.tracks_csv import load_tracks

    try:
        tracks = load_tracks(table)
    except EpibarError as error:
        console.warning(f"without walkers: {error}")
        return None
    if tracks.unit != unit:
        console.warning(f"without walkers: {table} is in {tracks.unit}s, and the network in {unit}s")
        return None
    return tracks
