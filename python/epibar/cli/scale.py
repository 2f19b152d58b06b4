"""``epibar scale``: metres for a network that is calibrated already."""

from __future__ import annotations

from argparse import Namespace

from .exit_codes import DONE
from .length_options import add_length_options, lengths
from .options import CommandParser, add_output_options, add_run_folder

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "scale"
HELP = "give a calibrated network its metres, after the fact"
DESCRIPTION = (
    "Bring the network in DIR to metres, by all lengths that are given, now and before, weighted by their "
    "accuracy; the same one given again replaces the one before. Rewrites "
    "network.json, cameras.toml, tracks.csv, report.html and the network in calibration.json; pairs stay as "
    "they are."
)


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    add_run_folder(command)
    add_length_options(command)
    command.add_argument(
        "--forget",
        action="store_true",
        help="take these lengths alone: when what was given before, which is combined with them otherwise, "
        "was wrong",
    )
    add_output_options(command)


def run(args: Namespace) -> int:
    """Run the command."""
    from ..errors import EpibarError
    from ..jobs.folder import Folder
    from ..jobs.inputs import NETWORK_FILE
    from ..jobs.network_tables import rescaled_tracks, tracks_of
    from ..jobs.stored_report import rewrite_report
    from ..jobs.update_files import write_update
    from ..outcome.run import Run
    from ..outcome.stored_network import network_of_run
    from .console import Console

    console = Console(args.quiet, verbose=args.verbose)
    given = lengths(args)
    found = Run.load(args.folder)
    result = found.files[0]
    path = result.parent / NETWORK_FILE
    if not path.exists():
        raise EpibarError(f"{path}: there is no network in this run to scale")
    with Folder(result.parent) as folder:
        folder.refuse_foreign([path])
        before = network_of_run(path, result)
        tracks = tracks_of(folder, before)
        network = before.scaled(**given, keep=not args.forget)
        if tracks is not None:
            tracks = rescaled_tracks(tracks, before, network)
        for text in write_update(
            folder, network, (), found.lenses(known=before.known_lenses), found.intrinsics, tracks
        ):
            console.warning(text)
        for text in rewrite_report(folder, network):
            console.warning(text)
    console.joined(network, None)
    return DONE
