"""What a job is made of: its cameras and its options, checked before any work."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

from ..arguments import MAX_SEED, as_positive, as_whole_number, check_choice
from ..calibration import MAX_EXPECTED_ERROR, METHODS, SEARCH_SECONDS
from ..errors import EpibarError, address_without_secrets, is_address, printable
from ..foreground.options import METHODS as FOREGROUNDS
from ..foreground.options import ForegroundMethod
from ..lens.cameras_toml import find_camera, find_cameras, load_cameras
from ..lens.intrinsics import Intrinsics
from ..network.metres import check_lengths
from ..network.pair_choice import ALL_PAIRS
from ..recording import DEFAULT_LINES, MAX_LINES
from ..sources.frame_range import FrameRange
from ..sources.source import source_name
from .mixed_sources import refuse_mixed

__all__ = [
    "CAMERAS_FILE",
    "CLOCKS_FILE",
    "NETWORK_FILE",
    "REPORT",
    "RESULT",
    "SYNC_FILE",
    "TRACKS_FILE",
    "CameraInput",
    "CameraPair",
    "Job",
    "PairOptions",
    "RecordOptions",
    "camera_inputs",
    "name_with_folder",
    "one_each",
    "pair_file",
    "pair_stems",
    "picture_file",
    "pictures_file",
    "points_file",
    "recording_file",
]

PathLike = str | os.PathLike[str]

RESULT = "calibration.json"
REPORT = "report.html"
NETWORK_FILE = "network.json"
CAMERAS_FILE = "cameras.toml"
CLOCKS_FILE = "recordings/clocks.json"
TRACKS_FILE = "tracks.csv"
SYNC_FILE = "sync.csv"

SAVED = ".npz"
"""How the names of recordings end; those of masks may, too."""


def recording_file(out: Path, name: str) -> Path:
    """Where a camera's recording is kept."""
    return out / "recordings" / f"{name}.npz"


def pictures_file(out: Path, name: str) -> Path:
    """Where pictures of a camera are kept."""
    return out / "pictures" / f"{name}.npz"


def pair_file(out: Path, stem: str) -> Path:
    """Where a pair's calibration is kept."""
    return out / "pairs" / f"{stem}.npz"


def points_file(out: Path, stem: str) -> Path:
    """Where a pair's frontier points go."""
    return out / f"{stem}_frontier.csv"


def picture_file(out: Path, stem: str) -> Path:
    """Where a pair's picture goes."""
    return out / f"{stem}.png"


@dataclass(frozen=True)
class RecordOptions:
    """How every camera is recorded; see :func:`epibar.record`."""

    lines: int = DEFAULT_LINES
    seed: int = 0
    masks: bool = False
    foreground: ForegroundMethod = "auto"
    frames: FrameRange = field(default_factory=FrameRange)
    chapters: bool = False
    fps: float | None = None

    def __post_init__(self) -> None:
        if self.fps is not None:
            as_positive("fps", self.fps, "frames per second")
        check_choice("foreground", self.foreground, FOREGROUNDS)
        as_whole_number("lines", self.lines, 1, MAX_LINES)
        as_whole_number("seed", self.seed, 0, MAX_SEED)


@dataclass(frozen=True)
class PairOptions:
    """How every pair is calibrated; see :func:`epibar.calibrate`."""

    method: Literal["frontier", "lines"] = "frontier"
    seed: int = 0
    time_offset: float | Literal["auto", "search"] = "auto"
    sharpen_offset: bool = False
    upright: bool = True
    essential: bool = True
    search_seconds: float = SEARCH_SECONDS
    max_expected_error: float = MAX_EXPECTED_ERROR

    def __post_init__(self) -> None:
        check_choice("method", self.method, METHODS)
        as_positive("max_expected_error", self.max_expected_error, "pixels")


@dataclass(frozen=True, eq=False)
class CameraInput:
    """One camera of a job.

    Attributes
    ----------
    name : str
        Unlike that of any other camera; part of file names.
    source : str
        Video, folder of images, address or saved recording, as it was given. An address may hold a password:
        :attr:`shown` is for people and files.
    index : int
        Place among the cameras.
    background, ignore : str or None
        Video of the empty scene; image that is white where motion does not count.
    intrinsics : Intrinsics or None
    """

    name: str
    source: str = field(repr=False)
    index: int
    background: str | None = None
    ignore: str | None = None
    intrinsics: Intrinsics | None = None

    def located(self) -> CameraInput:
        """Return the camera with absolute paths, which mean the same in every process."""
        background = None if self.background is None else _absolute(self.background)
        ignore = None if self.ignore is None else _absolute(self.ignore)
        return replace(self, source=_absolute(self.source), background=background, ignore=ignore)

    def is_saved(self, options: RecordOptions) -> bool:
        """Whether the source is a recording, not a video."""
        return self.source.lower().endswith(SAVED) and not options.masks

    @property
    def shown(self) -> str:
        """The source without user names and passwords."""
        return address_without_secrets(self.source)

    @property
    def files(self) -> list[str]:
        """Every path that recording this camera reads."""
        return [path for path in (self.source, self.background, self.ignore) if path is not None]


CameraPair = tuple[CameraInput, CameraInput]


@dataclass(frozen=True)
class Job:
    """All pairs of some cameras.

    Attributes
    ----------
    cameras : list of CameraInput
    out : Path
        Folder of the results.
    record : RecordOptions
    pair : PairOptions
    intrinsics : str or None
        The file that the cameras' intrinsics came from.
    fresh : bool
        Do everything again, though results of an earlier run are there.
    report : bool
        Write ``report.html``.
    lengths : dict
        What is known in metres: ``distance``, ``person_height``, ``camera_height``, see
        :meth:`epibar.Network.scaled`.
    every_pair : bool
        Search every pair, however many cameras there are.
    """

    cameras: list[CameraInput]
    out: Path
    record: RecordOptions = field(default_factory=RecordOptions)
    pair: PairOptions = field(default_factory=PairOptions)
    intrinsics: str | None = None
    fresh: bool = False
    report: bool = True
    lengths: dict[str, Any] = field(default_factory=dict)
    every_pair: bool = False

    @property
    def chooses_pairs(self) -> bool:
        """Whether only as many pairs are searched as a network needs."""
        return len(self.cameras) > ALL_PAIRS and self.pair.method == "frontier" and not self.every_pair

    @property
    def pairs(self) -> list[CameraPair]:
        """Every pair, in order."""
        return list(combinations(self.cameras, 2))

    @property
    def inputs(self) -> list[str]:
        """Every path that is read."""
        known = [] if self.intrinsics is None else [self.intrinsics]
        return [*known, *(path for camera in self.cameras for path in camera.files)]

    @property
    def files(self) -> list[Path]:
        """Every file that may be written, but for ``cameras.toml``, which gives way to one of the user's."""
        stems = pair_stems(self.cameras).values()
        recorded = [camera for camera in self.cameras if not camera.is_saved(self.record)]
        return [
            *(self.out / name for name in ((RESULT, REPORT) if self.report else (RESULT,))),
            *(self.out / name for name in (NETWORK_FILE, CLOCKS_FILE, TRACKS_FILE, SYNC_FILE)),
            *(file(self.out, one.name) for one in recorded for file in (recording_file, pictures_file)),
            *(file(self.out, stem) for stem in stems for file in (pair_file, points_file, picture_file)),
        ]


def _absolute(path: str) -> str:
    return path if is_address(path) else os.path.abspath(path)


def camera_inputs(
    cameras: Sequence[PathLike] | Mapping[str, PathLike],
    *,
    background: Sequence[PathLike] | None = None,
    ignore: Sequence[PathLike] | None = None,
    intrinsics: PathLike | None = None,
    masks: bool = False,
    time_offset: float | str = "auto",
    lengths: Mapping[str, Any] | None = None,
    spelt: Callable[[str], str] = str,
) -> list[CameraInput]:
    """Turn arguments into cameras.

    Parameters
    ----------
    cameras : sequence of path, or mapping of name to path
        Without names they are called like their files.
    background, ignore : sequence of path, optional
        One per camera.
    intrinsics : path, optional
        Camera file in which each is found by name, or else by its place; of more than two cameras it may lack
        some, of which nothing is known then.
    masks : bool
        All are ready masks, and none a saved recording.
    time_offset : float, "auto" or "search"
        Of all pairs.
    lengths : mapping, optional
        What is known in metres, of which the names are checked.
    spelt : callable
        How the caller writes an argument's name, for the messages.

    Raises
    ------
    EpibarError
        Fewer than two cameras, one twice, names that are no file names, a wrong number of something.
    """
    if isinstance(cameras, (str, os.PathLike)):
        raise EpibarError(f"{spelt('cameras')} = {os.fspath(cameras)!r}: expected several paths")
    sources = [os.fspath(path) for path in (cameras.values() if isinstance(cameras, Mapping) else cameras)]
    names = list(map(str, cameras)) if isinstance(cameras, Mapping) else _names(sources)
    if len(sources) < 2:
        raise EpibarError(f"{spelt('cameras')}: at least two cameras are needed")
    for name in names:
        if not name or name in (".", "..") or any(sign in name for sign in '/\\:*?"<>|\n\r\t'):
            raise EpibarError(f"{spelt('cameras')}: {name!r} cannot be part of a file name; rename it")
        if printable(name) != name:
            raise EpibarError(f"{spelt('cameras')}: {name!r} holds what cannot be printed; rename it")
    if not _differ(names):
        raise EpibarError(
            f"{spelt('cameras')}: {', '.join(names)} would be files of the same names; rename one"
        )
    resolved = [source if is_address(source) else os.path.realpath(source) for source in sources]
    for source, path in zip(sources, resolved, strict=True):
        if resolved.count(path) > 1:
            shown = address_without_secrets(source)
            raise EpibarError(f"{shown}: given twice; a camera has no epipolar geometry with itself")
    if len(sources) > 2 and time_offset not in (0, "auto", "search"):
        raise EpibarError(
            f"{spelt('time_offset')} = {time_offset} with {len(sources)} cameras does not say which pair it "
            "is for; use 'auto', or calibrate the pairs one by one"
        )
    check_lengths(names, **(lengths or {}))
    refuse_mixed(sources, masks, spelt)
    known = _lenses(load_cameras(intrinsics), names, sources, masks) if intrinsics is not None else {}
    backgrounds = one_each(spelt("background"), background, len(sources))
    ignored = one_each(spelt("ignore"), ignore, len(sources))
    return [
        CameraInput(
            name,
            source,
            index,
            backgrounds[index],
            ignored[index],
            known.get(name),
        )
        for index, (name, source) in enumerate(zip(names, sources, strict=True))
    ]


def _lenses(
    known: Sequence[Intrinsics], names: list[str], sources: list[str], masks: bool
) -> dict[str, Intrinsics]:
    """Lenses of the cameras that a file has; of two that are still to be recorded it must have both."""
    found = find_cameras(known, names)
    if len(names) == 2:
        for index, name in enumerate(names):
            if name not in found and (masks or not sources[index].lower().endswith(SAVED)):
                find_camera(known, name, index, names)
    return found


def one_each(option: str, given: Sequence[PathLike] | None, count: int) -> list[str | None]:
    """Take what is given once per camera, or not at all; ``option`` names it in the error."""
    if given is None:
        return [None] * count
    if isinstance(given, (str, os.PathLike)) or len(given) != count:
        number = 1 if isinstance(given, (str, os.PathLike)) else len(given)
        raise EpibarError(
            f"{option}: {number} given for {count} cameras; give one per camera, in their order"
        )
    return [os.fspath(path) for path in given]


def _names(sources: list[str]) -> list[str]:
    """File stems, with the folder's name before them where two are the same, then a number."""
    names = [source_name(source) for source in sources]
    if not _differ(names):
        names = [name_with_folder(source) for source in sources]
    if not _differ(names):
        names = [f"{name}_{index}" for index, name in enumerate(names)]
    return names


def name_with_folder(source: str) -> str:
    """Name of a camera whose file is named as that of another: the folder's name before it."""
    if is_address(source):
        folder = source_name(source.partition("?")[0].rpartition("/")[0])
    else:
        folder = Path(os.path.realpath(source)).parent.name
    return f"{folder}_{source_name(source)}"


def _differ(names: list[str]) -> bool:
    """Whether files of these names differ, also where capitals do not count."""
    return len({name.casefold() for name in names}) == len(names)


def pair_stems(cameras: Sequence[CameraInput]) -> dict[tuple[str, str], str]:
    """Name the files of each pair, ``a_b``, with the places of the two where that would be said twice."""
    pairs = list(combinations(cameras, 2))
    counts = Counter(f"{a.name}_{b.name}" for a, b in pairs)
    return {
        (a.name, b.name): stem if counts[stem] == 1 else f"{stem}_{a.index}_{b.index}"
        for a, b in pairs
        for stem in [f"{a.name}_{b.name}"]
    }
