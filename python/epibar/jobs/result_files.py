"""What a job leaves in its folder for people and programs: calibration.json, points, pictures, report."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from ..calibration import Calibration
from ..errors import EpibarError, without_secrets
from ..files.frontier_csv import write_frontier_points
from ..files.json_file import write_json
from ..network.result import Network
from ..outcome.entries import camera_entry, pair_entry, pose_entry, run_entry
from ..recording import Recording
from ..report.pair_picture import write_pair_picture
from ..sources.pictures import Pictures
from .folder import Folder
from .inputs import (
    CAMERAS_FILE,
    NETWORK_FILE,
    REPORT,
    RESULT,
    TRACKS_FILE,
    CameraInput,
    CameraPair,
    Job,
    picture_file,
    points_file,
)
from .network_files import kept_network, write_network
from .network_tables import forget_tables, write_tables
from .stages import NETWORK

__all__ = ["Results"]

PAUSE = 2.0
"""Seconds between two versions of calibration.json, which grows with the pairs."""


class Results:
    """Results of one job; all that is written is in the order of the cameras, however the work was done.

    Attributes
    ----------
    recordings : dict of CameraInput to Recording
    pictures : dict of CameraInput to Pictures
        Taken while the camera was recorded.
    calibrations : dict of (CameraInput, CameraInput) to Calibration
    seconds : dict of (CameraInput, CameraInput) to float
        What each calibration took, whenever it was made.
    network : Network or None
    no_network : str or None
        Why there is none.
    network_files : list of Path
        Where it was written.
    errors : dict of CameraInput, (CameraInput, CameraInput), NETWORK or CLOCKS to dict
        Why some could not be done, or the network not be written.
    """

    def __init__(self, job: Job, folder: Folder) -> None:
        self._folder = folder
        self.recordings: dict[CameraInput, Recording] = {}
        self.pictures: dict[CameraInput, Pictures] = {}
        self.calibrations: dict[CameraPair, Calibration] = {}
        self.seconds: dict[CameraPair, float] = {}
        self.errors: dict[CameraInput | CameraPair | str, dict[str, str]] = {}
        self.network: Network | None = None
        self.no_network: str | None = "the run was not finished"
        self.network_files: list[Path] = []
        self._job = job
        self._earlier = self.path.exists()
        self._files: dict[CameraPair, dict[str, str]] = {}
        self._written = time.monotonic()
        self._in_file = 0

    @property
    def path(self) -> Path:
        """The file calibration.json."""
        return self._job.out / RESULT

    @property
    def leaves_earlier(self) -> bool:
        """Whether no two cameras could be recorded, and the results of an earlier run stay as they are."""
        return self._earlier and bool(self.errors) and len(self.recordings) < 2

    def take(self, camera: CameraInput, recording: Recording) -> None:
        """Take a recording; its pictures stay here when it goes to the tasks of its pairs."""
        self.recordings[camera] = recording
        if recording.matrix is not None and recording.lens is None:  # kept by a version that did not keep it
            recording.lens = camera.intrinsics
        if recording.pictures is not None:
            self.pictures[camera], recording.pictures = recording.pictures, None

    def add(self, pair: CameraPair, stem: str, calibration: Calibration, seconds: float) -> None:
        """Take a calibration; write its points and its picture where they are missing."""
        a, b = pair
        points, picture = self._points(stem), self._picture(stem)
        self.calibrations[pair], self.seconds[pair] = calibration, seconds
        self._folder.will_write(points, picture)
        if not points.exists():
            write_frontier_points(points, calibration.frontier_points)
        if not picture.exists():
            write_pair_picture(
                picture,
                (a.name, b.name),
                (self.pictures.get(a), self.pictures.get(b)),
                (self.recordings[a], self.recordings[b]),
                calibration,
            )
        self._files[pair] = {"frontier_points": points.name, "picture": picture.name}

    def failed(self, of: CameraInput | CameraPair | str, message: str) -> str:
        """Note why a camera, a pair or a stage could not be done, and return it as people are told."""
        message = without_secrets(message)
        if isinstance(of, str):
            self.errors[of] = {"message": message}
            return message
        if isinstance(of, CameraInput):
            self.errors[of] = {"camera": of.name, "file": of.shown, "message": message}
            return message
        a, b = of
        message = f"{a.name} - {b.name}: {message}"
        self.errors[of] = {"a": a.name, "b": b.name, "message": message}
        return message

    def forget(self, stem: str) -> None:
        """Remove the points and the picture that an earlier run wrote.

        Raises
        ------
        EpibarError
            They cannot be removed.
        """
        self._folder.remove(self._points(stem), self._picture(stem))

    def _points(self, stem: str) -> Path:
        return points_file(self._job.out, stem)

    def _picture(self, stem: str) -> Path:
        return picture_file(self._job.out, stem)

    def content(self) -> dict[str, Any]:
        """Return what calibration.json holds. No times are in it: the same job gives the same file."""
        job = self._job
        straight = {one.matrix is not None for one in self.recordings.values()}
        result = run_entry(
            seed=job.record.seed,
            method=job.pair.method,
            lines=job.record.lines,
            foreground=None if job.record.masks else job.record.foreground,
            upright=job.pair.upright,
            max_expected_error=job.pair.max_expected_error,
            intrinsics=job.intrinsics,
            undistorted=None if len(straight) > 1 else straight == {True},
        )
        result["cameras"] = [
            camera_entry(camera.name, camera.shown, camera.index, self.recordings[camera])
            for camera in job.cameras
            if camera in self.recordings
        ]
        result["pairs"] = [
            {**self._pair_entry(a, b), **self._files[a, b]} for a, b in job.pairs if (a, b) in self._files
        ]
        tasks: list[CameraInput | CameraPair] = [*job.cameras, *job.pairs]
        result["network"] = None if self.network is None else self.network.as_dict()
        result["network_reason"] = None if self.network is not None else self.no_network
        result["errors"] = [self.errors[task] for task in tasks if task in self.errors]
        return result

    def _pair_entry(self, a: CameraInput, b: CameraInput) -> dict[str, Any]:
        calibration = self.calibrations[a, b]
        pose = pose_entry(calibration, self.recordings[a].matrix, self.recordings[b].matrix)
        return {**pair_entry(a.name, b.name, calibration), "pose": pose}

    def write_network(self, key: str | None, tables: bool = True) -> list[str]:
        """Write the network's own files, with its tables or without, or remove old ones; returns warnings."""
        if self.leaves_earlier:
            return []
        job, network = self._job, self.network
        lenses = {camera.name: camera.intrinsics for camera in job.cameras if camera.intrinsics is not None}
        recordings = {camera.name: recording for camera, recording in self.recordings.items()}
        kept = network is not None and not job.fresh and kept_network(job.out, key, list(network.cameras))
        replaced = [] if kept else self._replaced_network()
        left = [] if kept else self._forget_tables()
        if left:  # so the next run must not take this network for one that is kept
            key, tables = None, False
        try:
            self.network_files, warnings = write_network(self._folder, network, key, lenses, job.intrinsics)
        except EpibarError as error:
            earlier = [name for name in (NETWORK_FILE, CAMERAS_FILE) if (job.out / name).is_file()]
            still_there = f"; still there, of an earlier run: {', '.join(earlier)}" if earlier else ""
            raise EpibarError(f"{error}{still_there}") from error
        warnings += replaced + left
        if network is not None and tables:
            sources = {camera.name: camera.shown for camera in job.cameras}
            written, missing = write_tables(self._folder, network, recordings, sources)
            self.network_files += written
            warnings += missing
        return warnings

    def _replaced_network(self) -> list[str]:
        """Say what of an earlier network is lost: all of it, cameras, or lengths that its metres were of."""
        path = self._job.out / NETWORK_FILE
        if not (path.is_file() and self._folder.owns(path)):
            return []
        if self.network is None:
            return [f"{path}: the network of an earlier run is removed"]
        try:
            before = Network.load(path)
        except EpibarError:
            return []
        now, known = (() if one.scale is None else one.scale.lengths for one in (self.network, before))
        lost = [one.what for one in known if one.of not in [other.of for other in now]]
        gone = [name for name in before.cameras if name not in self.network.cameras]
        lacking = [f"without {', '.join(gone)}; 'epibar check --update' adds a camera again"] if gone else []
        lacking += [f"without {' and '.join(lost)}; give that again, or 'epibar scale' does"] if lost else []
        return [f"{path}: made anew, {one}" for one in lacking]

    def _forget_tables(self) -> list[str]:
        """Remove the tables of an earlier network; returns why one stays."""
        try:
            forget_tables(self._folder)
        except EpibarError as error:
            return [self.failed(NETWORK, f"{error}; it is of an earlier network")]
        return []

    def write_report(self) -> None:
        """Write report.html."""
        from ..report.inputs import NetworkReport, ReportCamera, ReportPair
        from ..report.page import write_report
        from ..report.walker_lines import read_tracks

        job = self._job
        cameras = [
            ReportCamera(
                camera.name,
                None if camera.is_saved(job.record) else camera.source,
                job.record.masks,
                self.recordings[camera],
                self.pictures.get(camera),
            )
            for camera in job.cameras
            if camera in self.recordings
        ]
        pairs = [
            ReportPair(pair[0].name, pair[1].name, self.calibrations[pair], self.seconds[pair])
            for pair in job.pairs
            if pair in self._files
        ]
        errors = [error["message"] for error in self.content()["errors"]]
        tracks = []
        if self.network is not None:
            try:
                tracks = read_tracks(job.out / TRACKS_FILE)
            except EpibarError as error:
                errors.append(str(error))
        network = NetworkReport(self.network, self.no_network, tracks)
        self._folder.will_write(job.out / REPORT)
        write_report(job.out / REPORT, cameras, pairs, errors, network)

    def write_now_and_then(self) -> None:
        """Write calibration.json where pairs have come since, and it was some time ago."""
        if len(self._files) > self._in_file and time.monotonic() - self._written > PAUSE:
            self.write()

    def write(self) -> None:
        """Write calibration.json."""
        if self.leaves_earlier:
            return
        self._folder.will_write(self.path)
        write_json(self.path, self.content())
        self._written, self._in_file = time.monotonic(), len(self._files)
