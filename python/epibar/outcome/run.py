"""What an export starts from: the cameras of a run, and its pairs with F, verdict and frontier points."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np

from ..arguments import Array, Index, as_camera_matrix, camera_names, check_pairs
from ..calibration import Calibration
from ..clocks import frames_of_b, nearest_frame, position_in_b
from ..errors import EpibarError
from ..files.calibration_json import read_json
from ..files.checks import LONGEST_SIDE
from ..files.frontier_csv import read_frontier_points
from ..geometry.correspondences import FrontierPoints
from ..geometry.pose import RelativePose, relative_pose
from ..lens.cameras_toml import find_camera, find_cameras, load_cameras
from ..lens.intrinsics import Intrinsics
from ..recording import Recording
from .recordings import recording_of
from .stored import Stored, entries

__all__ = ["Pair", "Run", "RunCamera", "no_points"]


@dataclass(frozen=True, eq=False)
class RunCamera:
    """One camera of a run.

    Attributes
    ----------
    name : str
    size : (int, int)
        Width and height, pixels.
    matrix : ndarray, shape (3, 3), or None
        Camera matrix of the undistorted pixels that all is in; None where no intrinsics were given.
    index : int or None
        Place among the cameras that were given to ``epibar calibrate``, of which some may have failed; None
        where it is that in the run.
    """

    name: str
    size: tuple[int, int]
    matrix: Array | None = None
    index: int | None = None


@dataclass(frozen=True, eq=False)
class Pair:
    """One pair of a run: the names of its cameras, and what :class:`~epibar.Calibration` calls the same.

    ``missing`` tells of each frontier point how many frames further on the frame of B is than offset and rate
    alone say, since some are missing of either; None where there are no recordings to ask.
    """

    a: str
    b: str
    F: Array | None
    accepted: bool
    kind: str
    reason: str
    expected_error: float | None
    time_offset: float
    frontier_points: FrontierPoints
    frames_per_frame: float = 1.0
    missing: Callable[[], Index] | None = None

    @property
    def name(self) -> str:
        """Both names, for messages."""
        return f"{self.a} - {self.b}"

    @property
    def frames_b(self) -> Index:
        """Frame of B of each frontier point; where the recordings are gone, as if none were missing."""
        frames = self.frontier_points.frame
        nearest = nearest_frame(position_in_b(frames, self.time_offset, self.frames_per_frame))
        return nearest if self.missing is None else nearest + self.missing()

    def asking(self, recordings: Callable[[str], Recording]) -> Pair:
        """Return the pair with frames of B as recordings have them, which are asked for when those are."""
        plain = replace(self, missing=None)

        def missing() -> Index:
            frames = plain.frontier_points.frame
            try:
                both = recordings(plain.a), recordings(plain.b)
            except EpibarError:  # gone, or of another run
                return np.zeros(len(frames), np.int64)
            clock = plain.time_offset, plain.frames_per_frame
            return frames_of_b(*both, *clock, frames) - plain.frames_b

        return replace(self, missing=missing)


@dataclass(frozen=True, eq=False)
class Run:
    """Cameras and pairs.

    Attributes
    ----------
    cameras : list of RunCamera
    pairs : list of Pair
    intrinsics : str or None
        The camera file that the run was given.
    files : list of Path
        Where it was read from, calibration.json first, and what its cameras were recorded from; an export
        overwrites none of them.
    """

    cameras: list[RunCamera]
    pairs: list[Pair]
    intrinsics: str | None = None
    files: list[Path] = field(default_factory=list)

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> Run:
        """Read what ``epibar calibrate --out folder`` wrote, given the folder or the calibration.json in it.

        Raises
        ------
        EpibarError
            A file is missing or damaged.
        """
        path = Path(folder)
        if not path.is_file():
            path /= "calibration.json"
        result = read_json(path)
        of_cameras = list(entries(path, result, "cameras"))
        cameras = [_camera(entry) for entry in of_cameras]
        names = [camera.name for camera in cameras]
        sources = [entry.values.get("file") for entry in of_cameras]
        files = [
            path,
            *(Path(source) for source in sources if isinstance(source, str) and "\0" not in source),
        ]
        by_name = {entry.text("name"): entry for entry in of_cameras}
        kept = cache(lambda name: recording_of(path.parent, by_name[name]))
        pairs, seen = [], set()
        for entry in entries(path, result, "pairs"):
            points_file = entry.file("frontier_points")
            points = no_points() if points_file is None else read_frontier_points(points_file)
            files += [] if points_file is None else [points_file]
            pair = _pair(entry, points).asking(kept)
            both = frozenset((pair.a, pair.b))
            if len(both) < 2 or both in seen:
                raise EpibarError(f"{path}: damaged: {pair.name} is no pair, or there twice")
            seen.add(both)
            pairs.append(pair)
        if len(set(names)) < len(names):
            raise EpibarError(f"{path}: damaged: two cameras have one name")
        intrinsics = result.get("intrinsics")
        if not isinstance(intrinsics, (str, type(None))):
            raise EpibarError(f"{path}: damaged: intrinsics is no path")
        run = cls(cameras, pairs, intrinsics, files)
        for name in {name for pair in pairs for name in (pair.a, pair.b)}:
            if name not in run.by_name:
                raise EpibarError(f"{path}: damaged: there is a pair with {name!r}, but no such camera")
        return run

    @classmethod
    def of(cls, recordings: Sequence[Recording], calibrations: Mapping[tuple[int, int], Calibration]) -> Run:
        """Put results of :func:`epibar.calibrate` together.

        Parameters
        ----------
        recordings : sequence of Recording
            One per camera. One without a name is called cam1, cam2, … by its place.
        calibrations : mapping of (int, int) to Calibration
            ``{(i, j): epibar.calibrate(recordings[i], recordings[j])}``.

        Raises
        ------
        EpibarError
            Two cameras of one name, or a pair of cameras that are not there.
        """
        names = camera_names(recording.name for recording in recordings)
        check_pairs(calibrations, len(names))
        pairs = [
            Pair(
                names[a],
                names[b],
                calibration.F,
                calibration.accepted,
                calibration.kind,
                calibration.reason,
                calibration.expected_error,
                calibration.time_offset,
                calibration.frontier_points,
                calibration.timing.frames_per_frame,
            ).asking(dict(zip(names, recordings, strict=True)).__getitem__)
            for (a, b), calibration in calibrations.items()
        ]
        cameras = [
            RunCamera(name, recording.size, recording.matrix)
            for name, recording in zip(names, recordings, strict=True)
        ]
        return cls(cameras, pairs)

    @property
    def by_name(self) -> dict[str, RunCamera]:
        """Cameras by their name."""
        return {camera.name: camera for camera in self.cameras}

    def selected(self, every: bool = False) -> Run:
        """Keep the accepted pairs only, or all.

        Raises
        ------
        EpibarError
            No pair is left.
        """
        if not self.pairs:
            raise EpibarError("there is no pair: nothing to export")
        pairs = self.pairs if every else [pair for pair in self.pairs if pair.accepted]
        if not pairs:
            refused = "; ".join(f"{pair.name}: {pair.kind}" for pair in self.pairs)
            raise EpibarError(
                f"no pair was accepted ({refused}); --all exports refused pairs, with the verdict"
            )
        return replace(self, pairs=pairs)

    def with_intrinsics(self, known: Sequence[Intrinsics], where: str) -> Run:
        """Give camera matrices to a run that was made without; check them in a run that was made with.

        Cameras that the file does not have stay as they are.

        Raises
        ------
        EpibarError
            It has none of them; or one has another size or matrix, or a lens that the run did not take out.
        """
        cameras = []
        found = self.some_in(known, where)
        for camera in self.cameras:
            given = found.get(camera.name)
            if given is None:
                cameras.append(camera)
                continue
            _check_lens(camera, given, where)
            cameras.append(replace(camera, matrix=given.matrix))
        return replace(self, cameras=cameras)

    def found_in(self, known: Sequence[Intrinsics], where: str) -> list[Intrinsics]:
        """Find each camera of the run in a camera file, by its name or else by its place.

        Raises
        ------
        EpibarError
            One is not there, or is for images of another size; ``where`` names the file.
        """
        names = [camera.name for camera in self.cameras]
        found = [
            find_camera(known, name, place, names) for name, place in zip(names, self._places, strict=True)
        ]
        for camera, given in zip(self.cameras, found, strict=True):
            _check_size(camera, given, where)
        return found

    def some_in(self, known: Sequence[Intrinsics], where: str) -> dict[str, Intrinsics]:
        """Find cameras of the run in a file of some of them, by the names of the run.

        Raises
        ------
        EpibarError
            None is there, or one is for images of another size; ``where`` names the file.
        """
        found = find_cameras(known, [camera.name for camera in self.cameras], self._places)
        for camera in self.cameras:
            if camera.name in found:
                _check_size(camera, found[camera.name], where)
        return found

    @property
    def _places(self) -> list[int]:
        """Place of each camera among those that were given to the run."""
        return [place if one.index is None else one.index for place, one in enumerate(self.cameras)]

    def lenses(self, where: str | None = None, known: Collection[str] = ()) -> dict[str, Intrinsics]:
        """Lenses that were taken out of the recordings, by camera; none of a run without intrinsics.

        Parameters
        ----------
        where : str, optional
            Camera file; by default that of the run.
        known : collection of str
            Cameras whose lens is known already, so that the file of the run need not be there for them.

        Raises
        ------
        EpibarError
            The file is not there any more, or does not fit.
        """
        straight = [camera.name for camera in self.cameras if camera.matrix is not None]
        if where is None:
            where, straight = self.intrinsics, [name for name in straight if name not in known]
        if where is None or not straight:
            return {}
        if not Path(where).is_file():
            raise EpibarError(
                f"{where}: the camera file of this run is not there any more, but its lenses are needed here"
            )
        found = self.some_in(load_cameras(where), where)
        for name in set(straight) & found.keys():
            _check_lens(self.by_name[name], found[name], where)
        return {name: found[name] for name in straight if name in found}

    def poses(self) -> tuple[dict[tuple[str, str], RelativePose], list[str]]:
        """Relative pose of each pair whose camera matrices are known, and why others have none."""
        found, reasons = {}, []
        cameras = self.by_name
        for pair in self.pairs:
            K_a, K_b = cameras[pair.a].matrix, cameras[pair.b].matrix
            if K_a is None or K_b is None:
                reasons.append(f"{pair.name}: no camera matrix")
                continue
            try:
                found[pair.a, pair.b] = relative_pose(pair, K_a, K_b)
            except EpibarError as error:
                reasons.append(f"{pair.name}: {error}")
        return found, reasons


def no_points() -> FrontierPoints:
    """Those of a pair that has none."""
    return FrontierPoints(np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))


def _check_size(camera: RunCamera, given: Intrinsics, where: str) -> None:
    if given.size != camera.size:
        raise EpibarError(
            f"{where}: {given.name} is for {given.size[0]}x{given.size[1]}, "
            f"but {camera.name} was recorded at {camera.size[0]}x{camera.size[1]}"
        )


def _check_lens(camera: RunCamera, given: Intrinsics, where: str) -> None:
    if camera.matrix is None and given.distorted:
        raise EpibarError(
            f"{where}: {given.name} has lens distortion, but {camera.name} was calibrated without; "
            "run 'epibar calibrate' again with --intrinsics"
        )
    if camera.matrix is not None and not np.allclose(camera.matrix, given.matrix):
        raise EpibarError(
            f"{where}: {given.name} has another camera matrix than {camera.name} was calibrated with"
        )


def _camera(entry: Stored) -> RunCamera:
    matrix = entry.matrix("matrix")
    if matrix is not None:
        matrix = as_camera_matrix(matrix, f"{entry.path}: {entry.place}.matrix")
    size = (entry.whole("width", 2, LONGEST_SIDE), entry.whole("height", 2, LONGEST_SIDE))
    return RunCamera(entry.text("name"), size, matrix, entry.whole("index", 0, 2**31))


def _pair(entry: Stored, points: FrontierPoints) -> Pair:
    F, accepted = entry.matrix("F"), entry.truth("accepted")
    if accepted and F is None:
        raise EpibarError(f"{entry.path}: damaged: {entry.place} is accepted, but has no F")
    return Pair(
        entry.text("a"),
        entry.text("b"),
        F,
        accepted,
        entry.text("kind"),
        entry.text("reason"),
        entry.maybe_number("expected_error"),
        entry.number("time_offset"),
        points,
        entry.table("timing").number("frames_per_frame", 0.0, otherwise=1.0),
    )
