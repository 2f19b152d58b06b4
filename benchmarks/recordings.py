"""Real recordings with known cameras: error over the volume where people moved, and what the verdict said.

The recordings are no part of the project; without them this prints a message and does nothing.
"""

from __future__ import annotations

import hashlib
import math
import time
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from common import Array
from options import METHODS, Method, add_common, add_method, add_names
from tables import mean, progress, px, table, write_json

import epibar
from epibar import EpibarError, Recording, _core
from epibar.evaluation import (
    GOOD_PAIR_PX,
    compare,
    matched_tangent_points,
    moving_volume,
    volume_correspondences,
)
from epibar.foreground.options import ForegroundOptions
from epibar.geometry.cameras import (
    PosedCamera,
    fundamental_from_cameras,
    project,
    projection_matrix,
    triangulate,
)
from epibar.geometry.epipolar import symmetric_epipolar_distance
from epibar.lens.cameras_toml import find_camera, load_cameras
from epibar.lens.intrinsics import Intrinsics

ROOT = Path(__file__).resolve().parents[1]
LEAST_POINTS = 20
MADE_BY = (
    "recording.py",
    "from_video.py",
    "sources/*.py",
    "lens/*.py",
    "foreground/*.py",
    "health/camera_*.py",
)
"""Modules that decide what a recording holds: a cached one made by others is made anew."""


@dataclass(frozen=True)
class Data:
    """One recording of several cameras: the files, by the name of the camera in ``cameras.toml``."""

    folder: str
    files: dict[str, str]
    masks: bool
    radius: float = 6.0
    """Pixels between a tangent and its partner under the known F, when looking for where things moved."""


def _numbered(pattern: str, name: str, numbers: range) -> dict[str, str]:
    return {name.format(number): pattern.format(number) for number in numbers}


DATA = {
    "four_people": Data("four_people", _numbered("cam{}.avi", "cam{}", range(1, 4)), masks=True),
    "hand_over_desk": Data("hand_over_desk", _numbered("cam{}.mp4", "cam{}", range(2)), masks=False),
    "man_at_desk": Data("man_at_desk", _numbered("cam_{}.mp4", "cam_{}", range(4)), masks=False),
    # The views of these are inconsistent by 3-8 px.
    "walking": Data("room_of_people", _numbered("walking_cam{}.npz", "cam{}", range(1, 5)), True, 10.0),
    "jumping": Data("room_of_people", _numbered("jumping_cam{}.npz", "cam{}", range(1, 5)), True, 10.0),
}

HEADER = [
    "recording",
    "pair",
    "method",
    "error, volume px",
    "image px",
    "verdict",
    "expected px",
    "source",
    "points of the known F",
    "known F there, px",
    "our F there, px",
    "points of our F",
    "our F at those, px",
    "known F at those, px",
    "known F refined, px",
    "its evidence over ours",
    "s",
]


@dataclass(frozen=True)
class Result:
    """One pair by one method. Distances in pixels, NaN where there is nothing to measure."""

    recording: str
    pair: str
    method: str
    error: float
    image_error: float
    accepted: bool
    kind: str
    reason: str
    source: str
    expected_error: float
    points_known: int
    known_on_known: float
    ours_on_known: float
    points_ours: int
    ours_on_ours: float
    known_on_ours: float
    refined_known: float
    refined_known_share: float
    evidence: dict[str, float]
    counts: dict[str, int]
    seconds: float
    F: list[list[float]] | None

    @property
    def good(self) -> bool:
        """Error over the volume below 3 px."""
        return self.error < GOOD_PAIR_PX

    @property
    def wrongly_accepted(self) -> bool:
        """Accepted, though not good."""
        return self.accepted and not self.good

    def cells(self) -> list[str]:
        """The result as a row of the table."""
        verdict = "accepted" + (", wrongly" if self.wrongly_accepted else "")
        return [
            self.recording,
            self.pair,
            self.method,
            px(self.error),
            px(self.image_error),
            verdict if self.accepted else self.kind,
            px(self.expected_error),
            self.source,
            str(self.points_known),
            px(self.known_on_known),
            px(self.ours_on_known),
            str(self.points_ours),
            px(self.ours_on_ours),
            px(self.known_on_ours),
            px(self.refined_known),
            px(self.refined_known_share),
            f"{self.seconds:.1f}",
        ]


@dataclass(frozen=True)
class View:
    """A recorded camera whose pose is known."""

    name: str
    recording: Recording
    posed: PosedCamera
    hulls: list[list[Array]]


def _cache_name(path: Path, camera: Intrinsics, *options: object) -> str:
    """Name the cached recording after everything in Python that it depends on."""
    package = Path(epibar.__file__).parent
    digest = hashlib.sha256()
    made_by = (module for pattern in MADE_BY for module in sorted(package.glob(pattern)))
    for part in (path, path.parent / "cameras.toml", *made_by):
        digest.update(part.read_bytes())
    digest.update(repr((camera.name, *options)).encode())
    return f"{path.parent.name}_{path.stem}_{digest.hexdigest()[:16]}.npz"


def record(
    path: Path,
    masks: bool,
    camera: Intrinsics,
    lines: int,
    seed: int,
    foreground: ForegroundOptions,
    cache: Path | None,
    first: int = 0,
) -> Recording:
    """Record a camera in undistorted pixels from a frame on, or load it from the cache."""
    cached = None if cache is None else cache / _cache_name(path, camera, lines, seed, foreground, first)
    if cached is not None and cached.exists():
        try:
            return Recording.load(cached)
        except EpibarError as error:
            progress(f"recorded anew: {error}")
    recording = epibar.record(
        path,
        lines=lines,
        seed=seed,
        name=path.stem,
        masks=masks,
        foreground=foreground,
        intrinsics=camera,
        frames=(first, None),
        progress=False,
    )
    for warning in recording.warnings:
        progress(f"{path.name}: {warning}")
    if cached is not None:
        cached.parent.mkdir(parents=True, exist_ok=True)
        recording.save(cached)
    return recording


def foreground_of(args: Namespace) -> ForegroundOptions:
    """Return the foreground that was asked for."""
    return ForegroundOptions(method=args.foreground, threshold=args.threshold)


def view(
    path: Path, name: str, index: int, known: list[Intrinsics], data: Data, args: Namespace, first: int = 0
) -> View:
    """Record a camera from a frame on."""
    camera = find_camera(known, name, index)
    started = time.perf_counter()
    recording = record(path, data.masks, camera, args.lines, index, foreground_of(args), args.cache, first)
    progress(
        f"{path.parent.name}/{path.name}: {recording.frames} frames, {time.perf_counter() - started:.1f} s"
    )
    hulls = [recording.hulls(frame) for frame in range(recording.frames)]
    return View(name, recording, camera.posed(), hulls)


def matched(a: View, b: View, F: Array, radius: float) -> tuple[Array, Array]:
    """Match the tangents of two views under an F: (n, 2) pixels in each."""
    frames = min(len(a.hulls), len(b.hulls))
    points_a, points_b, _ = matched_tangent_points(
        a.hulls[:frames], b.hulls[:frames], F, radius, a.recording.size, b.recording.size
    )
    return points_a, points_b


def volume_of(a: View, b: View, points: tuple[Array, Array]) -> tuple[Array, Array] | None:
    """Correspondences over the box in which the matched tangents of known cameras lie."""
    if len(points[0]) < LEAST_POINTS:
        return None
    world = triangulate(projection_matrix(a.posed), projection_matrix(b.posed), *points)
    world = world[np.isfinite(world).all(axis=1)]
    world = world[(project(a.posed, world)[1] > 0) & (project(b.posed, world)[1] > 0)]
    if len(world) < LEAST_POINTS:
        return None
    return volume_correspondences(a.posed, b.posed, moving_volume(world))


def _median(F: Array | None, points: tuple[Array, Array]) -> float:
    """Median symmetric epipolar distance of points."""
    if F is None or not len(points[0]):
        return math.nan
    return float(np.median(symmetric_epipolar_distance(F, *points)))


def from_the_known(a: View, b: View, truth: Array, F: Array | None) -> tuple[Array, float]:
    """Refine the known F where it stands; also returns its evidence as a share of that of another F."""

    def examine(F: Array, refined: bool) -> dict[str, Any]:
        known = a.recording.matrix, b.recording.matrix
        cores = a.recording._core, b.recording._core
        return _core.examine(*cores, np.ascontiguousarray(F), 3.0, 0.0, True, refined, known)

    refined = examine(truth, refined=True)
    ours = math.nan if F is None else examine(F, refined=False)["evidence"]
    return refined["F"], refined["evidence"] / ours if ours > 0 else math.nan


def measure(name: str, data: Data, a: View, b: View, method: Method, seed: int) -> Result:
    """Calibrate a pair and hold it against the known cameras."""
    started = time.perf_counter()
    cal = epibar.calibrate(a.recording, b.recording, method=method, seed=seed)
    seconds = time.perf_counter() - started
    truth = fundamental_from_cameras(a.posed, b.posed)
    known = matched(a, b, truth, data.radius)
    nothing = np.empty((0, 2)), np.empty((0, 2))
    ours = nothing if cal.F is None else matched(a, b, cal.F, data.radius)
    error = image_error = math.nan
    sizes, volume = (a.recording.size, b.recording.size), volume_of(a, b, known)
    if cal.F is not None:
        figures = compare(cal.F, truth, *sizes, volume)
        error, image_error = figures.volume_error, figures.image_error
    refined, share = from_the_known(a, b, truth, cal.F)
    return Result(
        recording=name,
        pair=f"{a.name}-{b.name}",
        method=method,
        error=error,
        image_error=image_error,
        accepted=cal.accepted,
        kind=cal.kind,
        reason=cal.reason,
        source=cal.source,
        expected_error=math.nan if cal.expected_error is None else cal.expected_error,
        points_known=len(known[0]),
        known_on_known=_median(truth, known),
        ours_on_known=_median(cal.F, known),
        points_ours=len(ours[0]),
        ours_on_ours=_median(cal.F, ours),
        known_on_ours=_median(truth, ours),
        refined_known=compare(refined, truth, *sizes, volume).volume_error,
        refined_known_share=share,
        evidence=dict(cal.evidence),
        counts=dict(cal.counts),
        seconds=seconds,
        F=None if cal.F is None else cal.F.tolist(),
    )


def summaries(results: list[Result]) -> list[dict[str, object]]:
    """Return the figures of every recording by every method."""
    rows = []
    for method in sorted({r.method for r in results}):
        for name in dict.fromkeys(r.recording for r in results):
            group = [r for r in results if (r.method, r.recording) == (method, name)]
            rows.append(
                {
                    "recording": name,
                    "method": method,
                    "pairs": len(group),
                    "good": sum(r.good for r in group),
                    "mean_good": mean(r.error for r in group if r.good),
                    "accepted": sum(r.accepted for r in group),
                    "wrongly_accepted": sum(r.wrongly_accepted for r in group),
                    "refused_though_good": sum(r.good and not r.accepted for r in group),
                    "seconds": mean(r.seconds for r in group),
                }
            )
    return rows


def _summary_cells(s: dict) -> list[str]:
    counts = (str(s[key]) for key in ("accepted", "wrongly_accepted", "refused_though_good"))
    good = [str(s["pairs"]), str(s["good"]), px(s["mean_good"])]
    return [s["recording"], s["method"], *good, *counts, f"{s['seconds']:.1f}"]


def parser_of(description: str) -> ArgumentParser:
    """Make a parser of the options of every program that measures on the recordings."""
    parser = ArgumentParser(description=description)
    parser.add_argument("data_dir", nargs="?", type=Path, default=ROOT.parent / "shared" / "data")
    add_common(parser, lines=20_000)
    add_names(parser, "--only", DATA)
    parser.add_argument("--foreground", choices=("auto", "mog2", "mixture", "knn", "median"), default="auto")
    parser.add_argument("--threshold", type=float, default=0.0, help="of the foreground (default: its own)")
    parser.add_argument("--cache", type=Path, metavar="DIR", help="keep the recordings there")
    return parser


def present(args: Namespace) -> list[str]:
    """Those of the recordings asked for that are there; says so where none is."""
    found = [name for name in args.only if (args.data_dir / DATA[name].folder / "cameras.toml").exists()]
    if not found:
        print(f"{args.data_dir}: none of {', '.join(args.only)} is there, so there is nothing to measure")
    return found


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--pairs", help="only these pairs of cameras, such as cam1-cam2,cam1-cam3")
    add_method(parser)
    parser.add_argument("--seed", type=int, default=0, help="of the calibration (default %(default)s)")
    args = parser.parse_args()
    names = present(args)
    if not names:
        return

    results: list[Result] = []
    for name in names:
        data, folder = DATA[name], args.data_dir / DATA[name].folder
        pairs = [f"{a}-{b}" for a, b in combinations(data.files, 2)]
        pairs = [pair for pair in pairs if args.pairs is None or pair in args.pairs.split(",")]
        known = load_cameras(folder / "cameras.toml")
        views = {
            camera: view(folder / file, camera, index, known, data, args)
            for index, (camera, file) in enumerate(data.files.items())
            if any(camera in pair.split("-") for pair in pairs)
        }
        for pair in pairs:
            a, b = pair.split("-")
            for method in METHODS[args.method]:
                results.append(measure(name, data, views[a], views[b], method, args.seed))
                if args.verbose:
                    print(f"{name} {pair} {method}: {results[-1].reason}", flush=True)
            write_json(args.json, args, results, summaries(results))
    print(f"\n{args.lines} lines per camera, foreground of videos: {args.foreground}\n")
    print(table(HEADER, (result.cells() for result in results)))
    header = ["recording", "method", "pairs", "good", "mean px, good", "accepted", "wrongly accepted"]
    header += ["refused though good", "s per pair"]
    print("\n" + table(header, map(_summary_cells, summaries(results))))


if __name__ == "__main__":
    main()
