"""``epibar check``: new footage of calibrated cameras, and whether one of them has moved."""

from __future__ import annotations

from argparse import Namespace
from contextlib import ExitStack
from typing import TYPE_CHECKING

from .clock_options import add_clock_options
from .exit_codes import DONE, MOVED, PARTLY, explanation
from .options import CommandParser, add_output_options, add_run_folder
from .recording_options import add_recording_options, record_options

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from ..jobs.folder import Folder
    from ..jobs.inputs import CameraInput
    from ..network.checking import NetworkCheck
    from ..network.offsets import TimeOffset
    from ..network.result import Network
    from ..recording import Recording
    from .check_lenses import FootageLenses
    from .console import Console

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "check"
HELP = "has a camera moved? A minute of new footage against a calibrated network; adds one more camera"
DESCRIPTION = (
    "Tell which cameras of the network in DIR have moved since it was calibrated, from new footage of two "
    "cameras or more in which something moves; a minute or so. A camera is found by the name of the file "
    "without its suffix. Nothing in DIR is changed, unless --update asks for it: then cameras that moved are "
    "put where they stand now, and cameras that the network does not have are added to it."
)
EXIT_CODES = explanation(
    "done, and no camera has moved",
    partly="a video could not be read, and no other camera has moved",
    moved="a camera has moved, cannot be judged, or is none of the network's",
    more="With --update a camera that was updated counts as one that has not moved, and one that was added "
    "as one of the network's. A scheduled job should tell of anything but 0.",
)


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    command.epilog = EXIT_CODES
    add_run_folder(command)
    command.add_videos(
        "one per camera, named as when it was calibrated, or by a new name: a video, a folder of images, or "
        "a saved recording"
    )
    group = command.add_argument_group("when the cameras were started")
    add_clock_options(
        group,
        "N|auto",
        "'auto' finds it; 0: when all are triggered together; N: when it is known of two cameras, frame i "
        "of the first is frame i + N of the second (default: auto)",
    )
    command.add_argument(
        "--update",
        action="store_true",
        help="when a camera was moved for good, or another came: put cameras that moved where they stand, "
        "in the network in DIR, and add those that it does not have; all else stays as it is",
    )
    command.add_argument(
        "--any-way-up",
        action="store_true",
        help="when a camera that is to be added hangs upside down or on its side",
    )
    add_recording_options(command, several=True)
    add_output_options(
        command, json="print the result as one JSON object on stdout, all else on stderr; for programs"
    )


def run(args: Namespace) -> int:
    """Run the command; what can be recorded is checked, and what cannot is unsure."""
    from pathlib import Path

    from ..jobs.folder import Folder
    from ..jobs.inputs import NETWORK_FILE
    from ..network.result import Network
    from .console import Console

    path = Path(args.folder)
    network = Network.load(path / NETWORK_FILE)
    with ExitStack() as held, Console(args.quiet, json=args.json, verbose=args.verbose) as console:
        if not args.update:
            return _checked(args, network, None, console)
        folder = held.enter_context(Folder(path))
        folder.refuse_foreign([path / NETWORK_FILE])
        network = Network.load(path / NETWORK_FILE)
        return _checked(args, network, Update(folder, args.intrinsics, network), console)


class Update:
    """The folder of a run, held, whose network is to be updated; what can be refused is before any work."""

    def __init__(self, folder: Folder, intrinsics: str | None, network: Network) -> None:
        from ..outcome.run import Run

        self._folder = folder
        self._made = Run.load(folder.path) if (folder.path / "calibration.json").exists() else None
        self._lenses = self._made.lenses(intrinsics, network.known_lenses) if self._made else {}

    def write(self, network: Network, moved: Sequence[str]) -> list[str]:
        """Write the network after some cameras moved or were added; returns warnings."""
        from ..jobs.stored_report import rewrite_report
        from ..jobs.update_files import write_update

        given = self._made.intrinsics if self._made else None
        warnings = write_update(self._folder, network, moved, self._lenses, given)
        return warnings + rewrite_report(self._folder, network)


def _checked(args: Namespace, network: Network, update: Update | None, console: Console) -> int:
    """Check the network, and update it where that is asked for."""
    from dataclasses import replace

    from ..errors import EpibarError
    from ..files.json_file import json_text
    from ..network.checking import UNSURE, CameraCheck
    from ..network.updating import update_notes
    from .adding import Additions, known_lenses

    videos = _videos(args, network)
    additions = Additions(
        network, videos, known_lenses(args.intrinsics, set(videos) - network.cameras.keys()), bool(update)
    )
    cameras, lenses = _cameras(args, network, videos, additions.names if update else ())
    for text in lenses.warnings:
        console.warning(text)
    recordings, failed = _recorded(cameras, lenses, args, console)
    old = {name: one for name, one in recordings.items() if name in network.cameras}
    if len(old) < 2:
        raise EpibarError("fewer than two cameras could be recorded, so none can be checked; see above")
    clocks = _clocks(args, recordings)
    check = network.check(
        old, clocks, lambda stage, share: console.step(stage, share), search_seconds=args.search_seconds
    )
    updated = [name for name, one in check.cameras.items() if one.place is not None] if update else []
    network_now = network.updated(check)
    found = check
    unread = {
        name: CameraCheck(name, UNSURE, f"not recorded: {why}")
        for name, why in failed.items()
        if name in network.cameras
    }
    left_out = {name: why for name, why in check.left_out.items() if name not in failed}
    check = replace(check, cameras={**check.cameras, **unread}, left_out=left_out)
    console.checked(check, network)
    additions.failed(failed)
    unwritten: EpibarError | None = None
    if update is not None:
        network_now = additions.extended(network_now, found, recordings, clocks, args, console)
        try:
            for text in update.write(network_now, updated) if updated or additions.added else ():
                console.warning(text)
        except EpibarError as error:  # what was found is told all the same
            unwritten, updated = error, []
            additions.unwritten(str(error))
        for text in update_notes(check) if unwritten is None and (updated or not additions.added) else ():
            console.result(text)
    additions.tell(console)
    code = exit_code(found, failed, updated, set(additions.not_added) - failed.keys())
    if args.json:
        found_out = check.as_dict()
        found_out["ok"] = code == DONE and unwritten is None
        console.json(
            json_text({**found_out, **({"updated": updated} if update else {}), **additions.as_dict()})
        )
    if unwritten is not None:
        raise unwritten
    return code


def exit_code(
    check: NetworkCheck,
    failed: Mapping[str, str],
    updated: Sequence[str] = (),
    not_added: Collection[str] = (),
) -> int:
    """Exit code of what was checked; ``failed`` could not be, ``updated`` is put where it stands now.

    ``not_added`` are cameras that were filmed and that the network has not.
    """
    if check.unsure or check.suspects or set(check.moved) - set(updated) or not_added:
        return MOVED
    return PARTLY if failed else DONE


def _videos(args: Namespace, network: Network) -> dict[str, str]:
    """Videos by the names of their cameras: with the folder's before them where the network has it so."""
    from ..errors import EpibarError
    from ..jobs.inputs import name_with_folder
    from ..sources.source import source_name

    videos: dict[str, str] = {}
    for video in args.videos:
        name = source_name(video)
        if name not in network.cameras and name_with_folder(video) in network.cameras:
            name = name_with_folder(video)
        if name in videos:
            raise EpibarError(f"{videos[name]} and {video} are both of camera {name}; give one of them")
        videos[name] = video
    if len(videos) > 2 and args.time_offset not in (0, "auto", "search"):
        raise EpibarError(
            f"--time-offset {args.time_offset:g} with {len(videos)} cameras does not say whose it is; "
            "use 0 or auto"
        )
    return videos


def _cameras(
    args: Namespace, network: Network, videos: Mapping[str, str], new: Sequence[str]
) -> tuple[list[CameraInput], FootageLenses]:
    """Return what is to be recorded, and its lenses; all that can be refused is refused before any work."""
    from dataclasses import replace
    from pathlib import Path

    from ..errors import EpibarError
    from ..jobs.first_frames import refuse_first_frames
    from ..jobs.given_rate import refuse_rate
    from ..jobs.inputs import camera_inputs
    from ..network.checking import cameras_to_check
    from .check_lenses import FootageLenses

    old = [name for name in videos if name in network.cameras]
    if len(old) < 2 and new:
        raise EpibarError(
            f"to add {', '.join(new)} new footage of at least two cameras of the network is needed, filmed "
            f"at the same time; there is {len(old)}. It has {', '.join(network.cameras)}"
        )
    if len(old) < 2:
        network.refuse_unknown(videos)
    chosen, _ = cameras_to_check(network, old)
    cameras = camera_inputs(
        videos, background=args.background, ignore=args.ignore, masks=args.masks, spelt=_option
    )
    others = [name for name in videos if name not in chosen]
    lenses = FootageLenses.of(Path(args.folder), network, args.intrinsics, chosen, others)
    recorded = [
        replace(one, intrinsics=lenses.taken_out.get(one.name))
        for one in cameras
        if one.name in (*chosen, *new)
    ]
    lenses.refuse_videos(recorded, record_options(args))
    refuse_rate([one.source for one in recorded], record_options(args))
    refuse_first_frames(recorded, record_options(args), args.time_offset)
    return recorded, lenses


def _recorded(
    cameras: list[CameraInput], lenses: FootageLenses, args: Namespace, console: Console
) -> tuple[dict[str, Recording], dict[str, str]]:
    """Record each camera; also returns why which could not be."""
    from functools import partial

    from ..errors import EpibarError
    from ..jobs.tasks import record_camera

    options = record_options(args)
    recordings, failed = {}, {}
    for camera in cameras:
        tell = partial(_tell, console, f"record {camera.name}")
        try:
            recording, taken = record_camera(camera, options, tell)
        except EpibarError as error:
            console.error(str(error))
            failed[camera.name] = str(error)
            continue
        lenses.refuse_raw(camera.name, recording)
        console.recorded(camera.name, recording, taken)
        recordings[camera.name] = recording
    return recordings, failed


def _tell(console: Console, stage: str, _: str, share: float) -> None:
    """Show how far a stage is, whatever its own name for that is."""
    console.step(stage, share)


def _clocks(args: Namespace, recordings: Mapping[str, Recording]) -> TimeOffset:
    """Take the time offset, in seconds."""
    from ..clocks import frame_interval

    if isinstance(args.time_offset, str):
        return "auto"
    second = list(recordings.values())[1]
    return float(args.time_offset) * frame_interval(second)


def _option(name: str) -> str:
    return "VIDEO" if name == "cameras" else "--" + name.replace("_", "-")
