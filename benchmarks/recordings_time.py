"""Real recordings with clocks that were set apart, and with recordings of other scenes.

The recordings are no part of the project; without them this prints a message and does nothing.
"""

from __future__ import annotations

import math
import time
from argparse import Namespace
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path

from recordings_views import DATA, View, matched, parser_of, present, view, volume_of
from tables import mean, px, table, worst, write_json

import epibar
from epibar.clocks import frame_interval
from epibar.evaluation import GOOD_PAIR_PX, compare
from epibar.geometry.cameras import fundamental_from_cameras
from epibar.lens.cameras_toml import load_cameras

SHIFTS = (3.0, -3.0)
"""Seconds by which B starts later than A."""


@dataclass(frozen=True)
class Shifted:
    """A pair whose clocks were set apart. Offsets in frames, error of F over the volume in pixels."""

    recording: str
    pair: str
    offset: float
    found: float
    accepted: bool
    kind: str
    reason: str
    error: float
    seconds: float

    @property
    def right(self) -> bool:
        """Within half a frame."""
        return abs(self.found - self.offset) < 0.5

    @property
    def wrongly_accepted(self) -> bool:
        """Accepted, though the offset or F is wrong."""
        return self.accepted and not (self.right and self.error < GOOD_PAIR_PX)

    def cells(self) -> list[str]:
        """The result as a row of the table."""
        verdict = "accepted" + (", wrongly" if self.wrongly_accepted else "")
        return [
            self.recording,
            self.pair,
            f"{self.offset:+.0f}",
            f"{self.found:+.2f}",
            verdict if self.accepted else self.kind,
            px(self.error),
            f"{self.seconds:.1f}",
        ]


@dataclass(frozen=True)
class Unrelated:
    """Two cameras of different scenes."""

    a: str
    b: str
    accepted: bool
    kind: str
    reason: str
    z: float


def shifted(name: str, args: Namespace, folder: Path) -> list[Shifted]:
    """Search the offset of every pair of a recording, whose cameras start some seconds apart."""
    data, results = DATA[name], []
    known = load_cameras(folder / "cameras.toml")

    @cache
    def camera(index: int, first: int) -> View:
        stem, file = list(data.files.items())[index]
        return view(folder / file, stem, index, known, data, args, first)

    for i, j in combinations(range(len(data.files)), 2):
        for seconds in args.shifts:
            frames = round(abs(seconds) / frame_interval(camera(i, 0).recording))
            a, b = camera(i, frames if seconds < 0 else 0), camera(j, frames if seconds > 0 else 0)
            started = time.perf_counter()
            cal = epibar.calibrate(
                a.recording, b.recording, time_offset="search", search_seconds=args.search_seconds
            )
            elapsed = time.perf_counter() - started
            truth = fundamental_from_cameras(a.posed, b.posed)
            error = math.nan
            if cal.F is not None:
                # The volume comes from cameras that are in step.
                points = matched(camera(i, 0), camera(j, 0), truth, data.radius)
                sizes = a.recording.size, b.recording.size
                error = compare(cal.F, truth, *sizes, volume_of(a, b, points)).volume_error
            results.append(
                Shifted(
                    recording=name,
                    pair=f"{a.name}-{b.name}",
                    offset=math.copysign(frames, -seconds),
                    found=cal.time_offset,
                    accepted=cal.accepted,
                    kind=cal.kind,
                    reason=cal.reason,
                    error=error,
                    seconds=elapsed,
                )
            )
            if args.verbose:
                print(" ".join(results[-1].cells()), results[-1].reason, flush=True)
    return results


def unrelated(names: list[str], args: Namespace) -> list[Unrelated]:
    """Calibrate the first two cameras of each recording with those of the others."""
    views: list[tuple[str, View]] = []
    for name in names:
        data, folder = DATA[name], args.data_dir / DATA[name].folder
        known = load_cameras(folder / "cameras.toml")
        for index, (stem, file) in enumerate(list(data.files.items())[:2]):
            views.append((name, view(folder / file, stem, index, known, data, args)))
    results = []
    for (of_a, a), (of_b, b) in combinations(views, 2):
        if of_a == of_b:
            continue
        cal = epibar.calibrate(a.recording, b.recording)
        names_of = f"{of_a} {a.name}", f"{of_b} {b.name}"
        z = cal.evidence.get("z", math.nan)
        results.append(Unrelated(*names_of, cal.accepted, cal.kind, cal.reason, z))
        if args.verbose:
            print(*names_of, cal.kind, f"z {z:.1f}", flush=True)
    return results


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--shifts", type=float, nargs="+", default=SHIFTS, metavar="SECONDS")
    parser.add_argument("--search-seconds", type=float, default=8.0)
    args = parser.parse_args()
    names = present(args)
    if not names:
        return

    pairs: list[Shifted] = []
    for name in names:
        pairs += shifted(name, args, args.data_dir / DATA[name].folder)
    others = unrelated(names, args)
    write_json(args.json, args, [*pairs, *others], [])
    header = ["recording", "pair", "offset, frames", "found", "verdict", "error, volume px", "s"]
    print("\n" + table(header, (pair.cells() for pair in pairs)))
    accepted = [pair for pair in pairs if pair.accepted]
    off = [abs(pair.found - pair.offset) for pair in accepted]
    right, wrong = sum(pair.right for pair in pairs), sum(pair.wrongly_accepted for pair in pairs)
    print(f"\n{right} of {len(pairs)} within half a frame; {len(accepted)} accepted, {wrong} of them wrongly")
    print(f"offsets of the accepted: off by {px(mean(off))} frames, at most {px(worst(off))}")
    said = sum(other.accepted for other in others)
    largest = worst(other.z for other in others if math.isfinite(other.z))
    print(f"{len(others)} pairs of different scenes: {said} accepted, z at most {largest:.1f}")


if __name__ == "__main__":
    main()
