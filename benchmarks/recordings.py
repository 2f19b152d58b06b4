"""Real recordings with known cameras: error over the volume where people moved, and what the verdict said.

The recordings are no part of the project; without them this prints a message and does nothing.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from common import Array
from options import METHODS, Method, add_method
from recordings_views import DATA, Data, View, matched, parser_of, present, view, volume_of
from tables import mean, px, table, write_json

import epibar
from epibar import _core
from epibar.evaluation import GOOD_PAIR_PX, compare
from epibar.geometry.cameras import fundamental_from_cameras
from epibar.geometry.epipolar import symmetric_epipolar_distance
from epibar.lens.cameras_toml import load_cameras

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


def _median(F: Array | None, points: tuple[Array, Array]) -> float:
    """Median symmetric epipolar distance of points."""
    if F is None or not len(points[0]):
        return math.nan
    return float(np.median(symmetric_epipolar_distance(F, *points)))


def from_the_known(a: View, b: View, truth: Array, F: Array | None, essential: bool) -> tuple[Array, float]:
    """Refine the known F where it stands; also returns its evidence as a share of that of another F."""

    def examine(F: Array, refined: bool) -> dict[str, Any]:
        known = (a.recording.matrix, b.recording.matrix) if essential else None
        cores = a.recording._core, b.recording._core
        return _core.examine(*cores, np.ascontiguousarray(F), 3.0, 0.0, True, refined, known)

    refined = examine(truth, refined=True)
    ours = math.nan if F is None else examine(F, refined=False)["evidence"]
    return refined["F"], refined["evidence"] / ours if ours > 0 else math.nan


def measure(name: str, data: Data, a: View, b: View, method: Method, seed: int, essential: bool) -> Result:
    """Calibrate a pair and hold it against the known cameras."""
    started = time.perf_counter()
    cal = epibar.calibrate(a.recording, b.recording, method=method, seed=seed, essential=essential)
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
    refined, share = from_the_known(a, b, truth, cal.F, essential)
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


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--pairs", help="only these pairs of cameras, such as cam1-cam2,cam1-cam3")
    add_method(parser)
    parser.add_argument(
        "--no-essential", action="store_true", help="camera matrices are used for the lens alone"
    )
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
                results.append(
                    measure(name, data, views[a], views[b], method, args.seed, not args.no_essential)
                )
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
