"""The report of a run whose network has changed since, of what its folder keeps: no video is read again.

``recordings/``, ``pictures/`` and ``pairs/`` hold what a report is made of beside calibration.json. They may
be of a later run that was stopped, so each is compared with what calibration.json says of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..calibration import Calibration
from ..errors import EpibarError
from ..files import calibration_npz
from ..files.archive import read_archive
from ..files.calibration_json import is_plain_name, read_json
from ..network.result import Network
from ..outcome.entries import camera_entry, pair_entry
from ..outcome.recordings import refuse_of_another_run
from ..outcome.run import no_points
from ..outcome.stored import Stored, entries
from ..recording import Recording
from ..report.inputs import NetworkReport, ReportCamera, ReportPair
from ..report.page import write_report
from ..report.walker_lines import read_tracks
from ..sources import pictures
from ..sources.pictures import Pictures
from .folder import Folder
from .inputs import (
    REPORT,
    RESULT,
    TRACKS_FILE,
    CameraInput,
    RecordOptions,
    pair_file,
    pictures_file,
    recording_file,
)
from .store import SECONDS
from .update_files import MOVED_KIND

__all__ = ["rewrite_report"]

OF_THE_SEARCH = ("time_offset", "timing", "method", "seed", "counts", "evidence", "source")
"""What calibration.json says of a pair that stays when one of its cameras moves."""


def rewrite_report(folder: Folder, network: Network) -> list[str]:
    """Write report.html anew with the network as it is now, if the run has a report.

    Parameters
    ----------
    folder : Folder
        Of the run, held; calibration.json is written.
    network : Network

    Returns
    -------
    list of str
        Warnings: why the report is as it was, or what is not shown in it.
    """
    path = folder.path / REPORT
    if not path.exists():
        return []
    if not folder.owns(path):
        return [f"{path}: not written by epibar, so it stays as it is"]
    try:
        return _write(path, read_json(folder.path / RESULT), network)
    except EpibarError as error:
        return [f"{path} still shows the network as it was, its cameras and its view in space: {error}"]


def _write(path: Path, content: Mapping[str, Any], network: Network) -> list[str]:
    out, result = path.parent, path.parent / RESULT
    masks = content.get("foreground") is None
    warnings: list[str] = []
    cameras = [_camera(out, entry, masks, warnings) for entry in entries(result, content, "cameras")]
    pairs = [_pair(out, entry) for entry in entries(result, content, "pairs")]
    errors = [entry.text("message") for entry in entries(result, content, "errors")]
    tracks = []
    try:
        tracks = read_tracks(out / TRACKS_FILE)
    except EpibarError as error:
        errors.append(str(error))
    write_report(path, cameras, pairs, errors, NetworkReport(network, None, tracks))
    return warnings


def _camera(out: Path, entry: Stored, masks: bool, warnings: list[str]) -> ReportCamera:
    """Take the recording of a camera, from where it is kept or was given."""
    name, source = _file_name(entry, "name"), entry.text("file")
    given = CameraInput(name, source, entry.whole("index", 0, 2**31)).is_saved(RecordOptions(masks=masks))
    path = Path(source) if given else recording_file(out, name)
    if not path.is_file():
        raise EpibarError(f"{path}, the recording of {name}, is not there")
    recording = Recording.load(path)
    if given:  # the run added a matrix and remarks to what is in the file
        said = entry.values.get("warnings")
        recording.matrix, recording.warnings = entry.matrix("matrix"), said if isinstance(said, list) else []
    refuse_of_another_run(path, camera_entry(name, source, entry.values["index"], recording), entry)
    return ReportCamera(name, None if given else source, masks, recording, _pictures(out, name, warnings))


def _pictures(out: Path, name: str, warnings: list[str]) -> Pictures | None:
    path = pictures_file(out, name)
    if not path.exists():
        return None
    try:
        return Pictures.from_arrays(read_archive(path, pictures.KIND), str(path))
    except EpibarError as error:
        warnings.append(f"{error}; silhouettes are shown instead")
        return None


def _pair(out: Path, entry: Stored) -> ReportPair:
    """Take the calibration of a pair, without what is not so any more where a camera of it has moved."""
    a, b = entry.text("a"), entry.text("b")
    path = pair_file(out, Path(_file_name(entry, "picture")).stem)
    arrays = read_archive(path, calibration_npz.KIND)
    calibration = Calibration.from_arrays(arrays, str(path))
    made = pair_entry(a, b, calibration)
    if entry.text("kind") != MOVED_KIND:
        refuse_of_another_run(path, made, entry)
        return ReportPair(a, b, calibration, _seconds(arrays))
    refuse_of_another_run(path, {key: made[key] for key in OF_THE_SEARCH}, entry)
    # Pictures and points are of before, so no F of now belongs beside them.
    moved = replace(
        calibration,
        F=None,
        accepted=False,
        kind=MOVED_KIND,
        reason=entry.text("reason"),
        expected_error=None,
        frontier_points=no_points(),
        floor=None,
        rivals=[],
        error_maps=None,
    )
    return ReportPair(a, b, moved, _seconds(arrays))


def _seconds(arrays: Mapping[str, Any]) -> float:
    """How long the search of a pair took."""
    try:
        return float(arrays[SECONDS])
    except (KeyError, TypeError, ValueError):
        return 0.0


def _file_name(entry: Stored, key: str) -> str:
    name = entry.text(key)
    if not is_plain_name(name):
        raise EpibarError(f"{entry.path}: damaged: {entry.place}.{key} is no name of a file")
    return name
