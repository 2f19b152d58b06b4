"""How exactly the clocks of two cameras are found: offsets of many seconds, other frame rates, drift."""

from __future__ import annotations

import math
import time
from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from common import record_masks
from options import add_common, add_frames, add_names, add_seeds, natural
from tables import mean, percent, progress, px, table, worst, write_json

import epibar
from epibar import synthetic
from epibar.evaluation import GOOD_PAIR_PX, compare
from epibar.synthetic import LOW_CAMERAS, Scene

SCENE_FPS = 50.0
"""Frames per second at which a scene is drawn up; cameras see the moments between in straight lines."""

SCENES: dict[str, Callable[[int, int], Scene]] = {
    "cubes": lambda seed, frames: synthetic.cubes(seed, cameras=4, objects=10, frames=frames, fps=SCENE_FPS),
    "high": lambda seed, frames: synthetic.people(seed, frames=frames, fps=SCENE_FPS),
    "low": lambda seed, frames: synthetic.people(
        seed, camera_height=LOW_CAMERAS, frames=frames, fps=SCENE_FPS
    ),
}

MARGIN_SECONDS = 2.0
DRIFT_FRAMES = 20_000


@dataclass(frozen=True)
class Case:
    """Frame rates of the two cameras, by how much B's clock is fast, and the largest offset."""

    fps_a: float = 25.0
    fps_b: float = 25.0
    ppm: float = 0.0
    seconds: float = 20.0
    frames: int | None = None


NTSC = 30_000 / 1001
CASES: dict[str, Case] = {
    "25/25": Case(),
    "25/30": Case(fps_b=30.0),
    "30/25": Case(fps_a=30.0),
    "29.97/30": Case(NTSC, 30.0),
    "100 ppm": Case(ppm=100.0, frames=DRIFT_FRAMES),
    "-100 ppm": Case(ppm=-100.0, frames=DRIFT_FRAMES),
}


@dataclass(frozen=True)
class Outcome:
    """One pair. Offsets in frames of B, drift in ppm, errors of F over the volume in pixels."""

    case: str
    scene: str
    number: int
    offset: float
    found: float
    uncertainty: float
    runner_up: float
    drift: float
    drift_found: float
    drift_uncertainty: float
    drift_used: bool
    accepted: bool
    kind: str
    error: float
    expected_error: float
    seconds: float

    @property
    def off(self) -> float:
        """Error of the offset, frames of B."""
        return self.found - self.offset

    @property
    def right(self) -> bool:
        """Within half a frame."""
        return abs(self.off) < 0.5

    def line(self) -> str:
        """The outcome in one line, for ``--verbose``."""
        used = "used" if self.drift_used else "not used"
        return (
            f"{self.case} {self.scene} {self.number}: offset {self.offset:+.2f}, off by {self.off:+.4f} ± "
            f"{self.uncertainty:.4f} frames, second best {self.runner_up:+.0f}; drift {self.drift:+.0f} ppm, "
            f"found {self.drift_found:+.1f} ± {self.drift_uncertainty:.1f}, {used}; "
            f"{px(self.error)} px, expected {px(self.expected_error)}; {self.kind}, {self.seconds:.0f} s"
        )


def number_or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def measure(name: str, scene_name: str, number: int, frames: int, lines: int, draws: int) -> Outcome:
    """Film a scene with two clocks, and calibrate without being told of them."""
    case = CASES[name]
    rng = np.random.default_rng((number, 77))
    offset = float(rng.uniform(-case.seconds, case.seconds))
    frames = case.frames or frames
    # Seconds of the scene at the first frame of each camera; both film for as long.
    start_a, start_b = MARGIN_SECONDS + max(offset, 0.0), MARGIN_SECONDS + max(-offset, 0.0)
    length = frames / case.fps_a
    scene = SCENES[scene_name](number, math.ceil((length + abs(offset) + 2 * MARGIN_SECONDS) * SCENE_FPS))
    a = scene.filmed_at(start_a + np.arange(frames) / case.fps_a, case.fps_a)
    ticks = np.arange(int(length * case.fps_b)) / case.fps_b
    # A clock that is fast counts more of its seconds.
    rate = 1 + 1e-6 * case.ppm
    b = scene.filmed_at(start_b + ticks / rate, case.fps_b)
    recordings = [
        record_masks(
            view.iter_masks(camera), view.cameras[camera].size, lines, 100 * number + camera, view.fps
        )
        for camera, view in enumerate((a, b))
    ]
    started = time.perf_counter()
    cal = epibar.calibrate(*recordings, seed=number, time_offset="search", draws=draws)
    seconds = time.perf_counter() - started
    error = math.nan
    if cal.F is not None:
        sizes = (camera.size for camera in scene.cameras[:2])
        figures = compare(cal.F, scene.fundamental(0, 1), *sizes, scene.volume_correspondences(0, 1))
        error = figures.volume_error
    return Outcome(
        case=name,
        scene=scene_name,
        number=number,
        offset=offset * case.fps_b * rate,
        found=cal.time_offset,
        uncertainty=number_or_nan(cal.timing.offset_uncertainty),
        runner_up=number_or_nan(cal.timing.runner_up),
        drift=case.ppm,
        drift_found=number_or_nan(cal.clock_drift),
        drift_uncertainty=number_or_nan(cal.timing.drift_uncertainty),
        drift_used=cal.timing.drift_used,
        accepted=cal.accepted,
        kind=cal.kind,
        error=error,
        expected_error=number_or_nan(cal.expected_error),
        seconds=seconds,
    )


HEADER = [
    "case",
    "pairs",
    "within ½ frame",
    "accepted",
    "of these within ½ frame",
    "wrongly accepted",
    "mean |off|, accepted",
    "worst |off|, accepted",
    "|off| < 2 x uncertainty",
    "mean drift off, ppm",
    "worst drift off, ppm",
    "mean px, accepted",
    "s per pair",
]


def summary(case: str, outcomes: list[Outcome]) -> dict[str, object]:
    """Return the figures of a case."""
    accepted = [o for o in outcomes if o.accepted]
    return {
        "case": case,
        "pairs": len(outcomes),
        "right": sum(o.right for o in outcomes),
        "accepted": len(accepted),
        "accepted_right": sum(o.right for o in accepted),
        "wrongly_accepted": sum(not (o.right and o.error < GOOD_PAIR_PX) for o in accepted),
        "mean_off": mean(abs(o.off) for o in accepted),
        "worst_off": worst(abs(o.off) for o in accepted),
        "within_uncertainty": mean(float(abs(o.off) < 2 * o.uncertainty) for o in accepted),
        "mean_drift_off": mean(abs(o.drift_found - o.drift) for o in accepted),
        "worst_drift_off": worst(abs(o.drift_found - o.drift) for o in accepted),
        "mean_error": mean(o.error for o in accepted),
        "seconds": mean(o.seconds for o in outcomes),
    }


def cells(s: dict) -> list[str]:
    """Return the figures as a row of the table."""
    return [
        s["case"],
        str(s["pairs"]),
        str(s["right"]),
        str(s["accepted"]),
        str(s["accepted_right"]),
        str(s["wrongly_accepted"]),
        px(s["mean_off"], 3),
        px(s["worst_off"], 3),
        percent(s["within_uncertainty"]),
        px(s["mean_drift_off"], 1),
        px(s["worst_drift_off"], 1),
        px(s["mean_error"]),
        f"{s['seconds']:.1f}",
    ]


def summaries(outcomes: list[Outcome]) -> list[dict[str, object]]:
    """Return the figures of every case."""
    return [summary(case, list(group)) for case, group in groupby(outcomes, lambda o: o.case)]


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    add_common(parser, lines=8000)
    add_names(parser, "--cases", CASES, ["25/25"])
    add_names(parser, "--scenes", SCENES, ["cubes", "high"], "in turn; ")
    add_seeds(parser, 50)
    add_frames(parser, 1600, "of A")
    parser.add_argument(
        "--draws", type=natural, default=10_000, help="of each source of hypotheses (default %(default)s)"
    )
    args = parser.parse_args()

    outcomes: list[Outcome] = []
    for case in args.cases:
        for number in args.seeds:
            scene = args.scenes[number % len(args.scenes)]
            progress(f"{case}, {scene} {number} ...")
            outcomes.append(measure(case, scene, number, args.frames, args.lines, args.draws))
            if args.verbose:
                print(outcomes[-1].line(), flush=True)
            write_json(args.json, args, outcomes, summaries(outcomes))
    print(f"\n{args.lines} lines per camera, {args.frames} frames, {args.draws} draws, seeds {args.seeds}\n")
    print(table(HEADER, map(cells, summaries(outcomes))))
    wrong = [o for o in outcomes if o.accepted and not o.right]
    if wrong:
        print("\nAccepted with a wrong offset:\n" + "\n".join(f"- {o.line()}" for o in wrong))


if __name__ == "__main__":
    main()
