"""The whole job as one function: many cameras in, a fundamental matrix for every pair out."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ..calibration import MAX_EXPECTED_ERROR, SEARCH_SECONDS, Calibration
from ..foreground.options import ForegroundMethod
from ..lens.cameras_toml import load_cameras, not_used
from ..network.result import Network
from ..recording import DEFAULT_LINES, Recording
from ..sources.frame_range import FrameRange
from .first_frames import refuse_first_frames
from .folder import Folder
from .given_rate import refuse_rate
from .inputs import Job, PairOptions, PathLike, RecordOptions, camera_inputs
from .runner import Runner
from .threads import own_threads, thread_count
from .watch import Watch, default_watch

__all__ = ["AllPairs", "calibrate_all", "run_job"]


@dataclass(frozen=True, eq=False)
class AllPairs:
    """What came out of a job.

    Attributes
    ----------
    recordings : dict of str to Recording
        By camera name.
    calibrations : dict of (str, str) to Calibration
        By the names of the two cameras, in the order given.
    errors : list of dict of str to str
        What could not be done: ``message``, and ``camera`` and ``file``, or ``a`` and ``b``, or neither where
        the network could not be written.
    content : dict
        What calibration.json holds of this run.
    network : Network or None
        Of all cameras; where there is none ``content["network_reason"]`` says why.
    searched : sequence of (str, str)
        Pairs that were to be done: all, or of more than six cameras those that a network needs.
    network_files : sequence of Path
        Where the network was written.
    leaves_earlier : bool
        Whether no camera could be recorded, and the results of an earlier run stay in the folder as they are.
    """

    recordings: dict[str, Recording]
    calibrations: dict[tuple[str, str], Calibration]
    errors: list[dict[str, str]]
    content: dict[str, Any]
    network: Network | None = None
    searched: Sequence[tuple[str, str]] = ()
    network_files: Sequence[Path] = ()
    leaves_earlier: bool = False

    def __repr__(self) -> str:
        accepted = sum(calibration.accepted for calibration in self.calibrations.values())
        pairs = f"{accepted} of {len(self.calibrations)} pairs accepted"
        network = "no network"
        if self.network is not None:
            left_out = len(self.network.left_out)
            network = f"{len(self.network.cameras) - left_out} in the network"
        return f"<AllPairs {len(self.recordings)} cameras, {network}, {pairs}, {len(self.errors)} errors>"


def calibrate_all(
    cameras: Sequence[PathLike] | Mapping[str, PathLike],
    out: PathLike,
    *,
    method: Literal["frontier", "lines"] = "frontier",
    seed: int = 0,
    time_offset: float | Literal["auto", "search"] = "auto",
    upright: bool = True,
    essential: bool = True,
    search_seconds: float = SEARCH_SECONDS,
    max_expected_error: float = MAX_EXPECTED_ERROR,
    lines: int = DEFAULT_LINES,
    masks: bool = False,
    foreground: ForegroundMethod = "auto",
    background: Sequence[PathLike] | None = None,
    ignore: Sequence[PathLike] | None = None,
    intrinsics: PathLike | None = None,
    frames: Sequence[int | None] | None = None,
    person_height: Any = None,
    distances: Any = (),
    camera_heights: Any = (),
    every_pair: bool = False,
    seconds: float | None = None,
    chapters: bool = False,
    fps: float | None = None,
    executor: Executor | None = None,
    fresh: bool = False,
    report: bool = True,
    watch: Watch | None = None,
) -> AllPairs:
    """Record every camera once, calibrate pairs, join all to a network, write it to a folder.

    Recordings, pictures of some frames and pairs are kept under ``recordings``, ``pictures`` and ``pairs`` in
    ``out``, each with a key of what it was made of: the path, size and time of change of its files, the
    options, the versions of epibar and OpenCV. A run that was interrupted, or to which a camera was added,
    does only what is missing.

    Parameters
    ----------
    cameras : sequence of path, or mapping of name to path
        A video, a folder of images or a saved recording for each of at least two cameras. Without names they
        are called like their files.
    out : path
        Folder for calibration.json, frontier points, pictures, the report and what is kept. Made if missing.
    method, seed, upright, essential, max_expected_error
        Of every pair, see :func:`epibar.calibrate`.
    search_seconds : float
        How far either way the offsets of clocks are searched for, seconds.
    time_offset : "auto", float or "search"
        "auto" finds an offset for the clock of each camera, and whether all started together; with "search"
        every pair searches by itself; a number, in frames of B, is for two cameras, or 0 for all.
    lines, seed, masks, foreground, frames, seconds, chapters
        Of every camera, see :func:`epibar.record`.
    fps : float, optional
        Frames per second of folders of images, and of masks that state none. Not for videos, which do.
    background, ignore : sequence of path, optional
        One per camera, see :func:`epibar.record`.
    intrinsics : path, optional
        Camera file in which each is found by its name, or else by its place. Of more than two cameras it may
        lack some, whose lenses are then found with the network.
    person_height, distances, camera_heights : optional
        Metres, as ``person_height``, ``distance`` and ``camera_height`` of :meth:`epibar.Network.scaled`.
    every_pair : bool
        Search every pair by itself. Else of more than six cameras only those are that are likeliest to see
        the same, as many as a network needs; it has all.
    executor : concurrent.futures.Executor, optional
        Where the tasks run: one per camera records its video, one per pair matches two recordings. Threads of
        this process by default. The result does not depend on it. It stays open. For Dask see
        :func:`epibar.jobs.dask_executor`.
    fresh : bool
        Do everything again, whatever is kept.
    report : bool
        Write ``report.html`` too, which a person can look at.
    watch : Watch, optional
        Told what happens; by default the logger ``epibar`` is, and where stderr is a terminal, or this runs
        in a notebook, bars show how far it is.

    Returns
    -------
    AllPairs

    Raises
    ------
    EpibarError
        An argument is unusable, the folder cannot be written, holds an input or is that of another run that
        goes on, or the executor has stopped. A camera or a pair that cannot be done is no such error: it is
        in ``errors``, and the others are done.

    Examples
    --------
    >>> import epibar
    >>> done = epibar.calibrate_all(["cam1.mp4", "cam2.mp4", "cam3.mp4"], "calibrated")
    >>> sorted(done.calibrations)
    [('cam1', 'cam2'), ('cam1', 'cam3'), ('cam2', 'cam3')]
    """
    lengths = {
        "distance": distances,
        "person_height": person_height,
        "camera_height": camera_heights,
    }
    job = Job(
        cameras=camera_inputs(
            cameras,
            background=background,
            ignore=ignore,
            intrinsics=intrinsics,
            masks=masks,
            time_offset=time_offset,
            lengths=lengths,
        ),
        out=Path(out),
        record=RecordOptions(lines, seed, masks, foreground, FrameRange.of(frames, seconds), chapters, fps),
        pair=PairOptions(
            method=method,
            seed=seed,
            time_offset=time_offset,
            upright=upright,
            essential=essential,
            search_seconds=search_seconds,
            max_expected_error=max_expected_error,
        ),
        intrinsics=None if intrinsics is None else os.fspath(intrinsics),
        fresh=fresh,
        report=report,
        lengths=lengths,
        every_pair=every_pair,
    )
    if watch is not None:
        return run_job(job, executor, watch)
    with default_watch() as shown:
        return run_job(job, executor, shown)


def run_job(job: Job, executor: Executor | None, watch: Watch) -> AllPairs:
    """Run a job whose arguments are checked; see :func:`calibrate_all`."""
    # What is wrong with the arguments is told before a folder is made.
    refuse_rate([camera.source for camera in job.cameras], job.record)
    refuse_first_frames(job.cameras, job.record, job.pair.time_offset)
    Folder(job.out).refuse_inputs(job.inputs, job.files)
    with Folder(job.out) as folder:
        folder.refuse_foreign(job.files)
        return _run(job, folder, executor, watch)


def _run(job: Job, folder: Folder, executor: Executor | None, watch: Watch) -> AllPairs:
    _tell_of_intrinsics(job, watch)
    if executor is None:
        with own_threads() as (threads, reporting):
            runner = Runner(job, folder, threads, watch, at_once=thread_count(), reporting=reporting)
            runner.run()
    else:
        runner = Runner(job, folder, executor, watch)
        runner.run()
    results = runner.results
    if job.report and not results.leaves_earlier:
        watch.note("writing the report ...")
        results.write_report()
    runner.tally.finished()
    return AllPairs(
        {camera.name: recording for camera, recording in results.recordings.items()},
        {
            (a.name, b.name): results.calibrations[a, b]
            for a, b in job.pairs
            if (a, b) in results.calibrations
        },
        list(results.errors.values()),
        results.content(),
        results.network,
        runner.searched,
        results.network_files,
        results.leaves_earlier,
    )


def _tell_of_intrinsics(job: Job, watch: Watch) -> None:
    """Say which camera is which in the camera file, where names do not tell, and whom it lacks."""
    if job.intrinsics is None:
        return
    lenses = {camera.name: camera.intrinsics for camera in job.cameras}
    for name, lens in lenses.items():
        if lens is not None and lens.name.casefold() != name.casefold():
            watch.warning(
                f"{name}: {job.intrinsics} has no camera of this name; by its place it is taken to be "
                f"{lens.name!r}"
            )
    strange = not_used(load_cameras(job.intrinsics), filter(None, lenses.values()))
    if strange:
        watch.warning(f"{job.intrinsics}: no video is called {', '.join(strange)}, so that is not used")
    lacking = [camera.name for camera in job.cameras if camera.intrinsics is None]
    if lacking:
        watch.warning(f"{job.intrinsics} does not have {', '.join(lacking)}: taken as filmed, lens unknown")
