"""What the measuring programs share: scenes by name, recording, errors against the truth, tables, JSON."""

from __future__ import annotations

import json
import math
import platform
import sys
import time
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import epibar
from epibar import synthetic
from epibar.evaluation import GOOD_PAIR_PX, compare, true_candidate_rate
from epibar.foreground import Foreground, ForegroundOptions
from epibar.recording import MIN_COMPONENT_AREA, Recording, new_recorder
from epibar.synthetic import LOW_CAMERAS, Scene

Array = NDArray[np.float64]
Mask = NDArray[np.uint8]

Method = Literal["frontier", "lines"]
METHODS: dict[str, tuple[Method, ...]] = {
    "frontier": ("frontier",),
    "lines": ("lines",),
    "both": ("lines", "frontier"),
}
FACTORS = (1, 2, 3)
"""Multiples of the stated expected error that the true error is held against."""

SCENES: dict[str, Callable[..., Scene]] = {
    "cubes": lambda seed, frames: synthetic.cubes(seed, cameras=4, frames=frames),
    "thin": lambda seed, frames: synthetic.thin_cubes(seed, cameras=4, frames=frames),
    "high": lambda seed, frames: synthetic.people(seed, frames=frames),
    "low": lambda seed, frames: synthetic.people(seed, camera_height=LOW_CAMERAS, frames=frames),
    "two": lambda seed, frames: synthetic.people(seed, walkers=2, camera_height=LOW_CAMERAS, frames=frames),
    "sixteen": lambda seed, frames: synthetic.people(
        seed, walkers=16, camera_height=LOW_CAMERAS, frames=frames
    ),
    "dirty": lambda seed, frames: synthetic.people(seed, dirty=True, frames=frames),
    "one_camera": lambda seed, frames: synthetic.people(seed, one_camera_only=4, frames=frames),
    "occluders": lambda seed, frames: synthetic.people(seed, occluders=8, frames=frames),
    "asymmetric": lambda seed, frames: synthetic.people(seed, asymmetric=True, frames=frames),
    # Only the first two cameras of a facing ring see each other.
    "facing": lambda seed, frames: synthetic.people(seed, cameras=2, facing=True, frames=frames),
}


@dataclass(frozen=True)
class Outcome:
    """One pair by one method. Errors: mean symmetric epipolar distance, pixels; NaN where there is none."""

    scene: str
    seed: int
    pair: str
    method: str
    accepted: bool
    kind: str
    reason: str
    source: str
    error: float
    image_error: float
    volume_points: int
    expected_error: float
    true_candidates: float
    candidates: int
    frontier_points: int
    seconds: float
    F: list[list[float]] | None

    @property
    def good(self) -> bool:
        """Error over the volume below 3 px."""
        return self.error < GOOD_PAIR_PX

    @property
    def wrongly_accepted(self) -> bool:
        """Accepted, though not good (or not measurable)."""
        return self.accepted and not self.good

    @property
    def refused_though_good(self) -> bool:
        """Good, and refused."""
        return self.good and not self.accepted

    def line(self) -> str:
        """The outcome in one line, for ``--verbose``."""
        verdict = "accepted" if self.accepted else f"refused ({self.kind})"
        verdict += ", WRONGLY" if self.wrongly_accepted or self.refused_though_good else ""
        return (
            f"{self.scene} seed {self.seed} {self.pair} {self.method}: {px(self.error)} px over the volume, "
            f"{px(self.image_error)} over the image, expected {px(self.expected_error)}; {verdict}; "
            f"{self.source}, {percent(self.true_candidates)} of {self.candidates} candidates true, "
            f"{self.seconds:.1f} s"
        )


def clean_masks(masks: Iterable[Mask]) -> Iterable[Mask]:
    """Clean ready but dirty masks as the package cleans its own: median filter, closing, area filter."""
    foreground = Foreground(ForegroundOptions())
    for mask in masks:
        yield foreground.clean(mask)


def record_masks(
    masks: Iterable[Mask], size: tuple[int, int], lines: int, seed: int, fps: float = 25.0, name: str = ""
) -> Recording:
    """Make a recording of a stream of masks, which need not fit into memory."""
    recorder = new_recorder(size[0], size[1], lines, seed, MIN_COMPONENT_AREA)
    for index, mask in enumerate(masks):
        recorder.push(np.ascontiguousarray(mask), index / fps)
    return Recording(recorder.finish(), name=name)


def record_camera(scene: Scene, camera: int, lines: int, seed: int) -> Recording:
    """Record one camera of a scene, with lines of its own; dirty masks are cleaned first."""
    masks: Iterable[Mask] = scene.iter_masks(camera)
    if scene.dirt is not None:
        masks = clean_masks(masks)
    size = scene.cameras[camera].size
    return record_masks(masks, size, lines, 100 * seed + camera, scene.fps, f"camera {camera + 1}")


def measure(
    scene: Scene, recordings: Mapping[int, Recording], a: int, b: int, method: Method, seed: int, name: str
) -> Outcome:
    """Calibrate a pair of a scene and hold it against the truth."""
    started = time.perf_counter()
    cal = epibar.calibrate(recordings[a], recordings[b], method=method, seed=seed)
    seconds = time.perf_counter() - started
    truth, size_a, size_b = scene.fundamental(a, b), scene.cameras[a].size, scene.cameras[b].size
    error = image_error = math.nan
    volume = scene.volume_correspondences(a, b)
    if cal.F is not None:
        figures = compare(cal.F, truth, size_a, size_b, volume)
        error, image_error = figures.volume_error, figures.image_error
    found = cal.candidates
    rate = true_candidate_rate(found.lines_a, found.lines_b, truth, size_a, size_b)
    return Outcome(
        scene=name,
        seed=seed,
        pair=f"{a + 1}-{b + 1}",
        method=method,
        accepted=cal.accepted,
        kind=cal.kind,
        reason=cal.reason,
        source=getattr(cal, "source", "unknown"),
        error=error,
        image_error=image_error,
        volume_points=len(volume[0]),
        expected_error=math.nan if cal.expected_error is None else cal.expected_error,
        true_candidates=rate,
        candidates=len(found),
        frontier_points=len(cal.frontier_points),
        seconds=seconds,
        F=None if cal.F is None else cal.F.tolist(),
    )


def measure_scene(
    scene: Scene,
    name: str,
    seed: int,
    lines: int,
    methods: Sequence[Method],
    pairs: int | None = None,
    watch: Callable[[Outcome], None] | None = None,
) -> list[Outcome]:
    """Record a scene and measure its pairs, all or the first so many, by each method."""
    chosen = list(combinations(range(len(scene.cameras)), 2))[:pairs]
    # Only what a pair needs is recorded.
    needed = {camera for pair in chosen for camera in pair}
    recordings = {camera: record_camera(scene, camera, lines, seed) for camera in sorted(needed)}
    outcomes = []
    for method in methods:
        for a, b in chosen:
            outcomes.append(measure(scene, recordings, a, b, method, seed, name))
            if watch is not None:
                watch(outcomes[-1])
    return outcomes


# --- summaries ---


def mean(values: Iterable[float]) -> float:
    """Mean of what is not NaN; NaN of nothing."""
    kept = [value for value in values if not math.isnan(value)]
    return sum(kept) / len(kept) if kept else math.nan


def worst(values: Iterable[float]) -> float:
    """Largest of what is not NaN; NaN of nothing."""
    return max((value for value in values if not math.isnan(value)), default=math.nan)


def counted(words: Iterable[str]) -> str:
    """Words with how often each came, most frequent first."""
    return ", ".join(f"{word} {count}" for word, count in Counter(words).most_common())


def px(value: float, digits: int = 2) -> str:
    """Pixels for a table; three digits where two would hide a small error."""
    if math.isnan(value):
        return "-"
    return f"{value:.{3 if abs(value) < 0.1 else digits}f}" if math.isfinite(value) else "inf"


def percent(share: float, digits: int = 1) -> str:
    """A share for a table."""
    return "-" if math.isnan(share) else f"{100 * share:.{digits}f} %"


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Set a table in Markdown, its columns aligned; the first to the left, the others to the right."""
    cells = [list(header), *([str(cell) for cell in row] for row in rows)]
    widths = [max(3, *(len(row[column]) for row in cells)) for column in range(len(header))]

    def line(row: Sequence[str]) -> str:
        padded = [
            cell.ljust(width) if column == 0 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        return "| " + " | ".join(padded) + " |"

    rule = [("-" * width) if column == 0 else "-" * (width - 1) + ":" for column, width in enumerate(widths)]
    return "\n".join([line(cells[0]), line(rule), *map(line, cells[1:])])


# --- command line and files ---


def numbers(text: str) -> list[int]:
    """Read ``1-5``, ``1,4,7`` or a mixture as a list of whole numbers."""
    found: list[int] = []
    try:
        for part in text.split(","):
            low, _, high = part.partition("-")
            found += range(int(low), int(high or low) + 1)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: expected numbers such as 1-5 or 1,4,7") from None
    if not found:
        raise ArgumentTypeError(f"{text!r}: no number in it")
    return found


def names_of(known: Iterable[str]) -> Callable[[str], list[str]]:
    """Make a reader of a list of names, each of which must be known."""
    allowed = list(known)

    def read(text: str) -> list[str]:
        found = [name.strip() for name in text.split(",") if name.strip()]
        for name in found:
            if name not in allowed:
                raise ArgumentTypeError(f"{name!r}: choose from {', '.join(allowed)}")
        return found

    return read


def natural(text: str) -> int:
    """Read a whole number of at least 1."""
    if not text.isdigit() or int(text) < 1:
        raise ArgumentTypeError(f"{text!r}: expected a whole number of at least 1")
    return int(text)


def add_common(parser: ArgumentParser, lines: int) -> None:
    """Add the options that every program has."""
    parser.add_argument(
        "--lines", type=natural, default=lines, help="random lines per camera (default %(default)s)"
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="write every outcome and the summary there too"
    )
    parser.add_argument("--verbose", action="store_true", help="print every pair as it is done")


def settings(args: Namespace) -> dict[str, Any]:
    """Everything that the figures depend on."""
    return {
        "command": " ".join(["python", *sys.argv]),
        "arguments": {
            key: str(value) if isinstance(value, Path) else value for key, value in vars(args).items()
        },
        "epibar": version("epibar"),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": platform.machine(),
    }


def write_json(path: Path | None, args: Namespace, outcomes: Iterable[object], summary: object) -> None:
    """Write settings, outcomes (dataclasses or dicts) and summary; NaN and infinity become null."""
    if path is None:
        return
    rows = [item if isinstance(item, dict) else asdict(item) for item in outcomes]  # type: ignore[call-overload]
    content = _strict({**settings(args), "summary": summary, "outcomes": rows})
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _strict(value: Any) -> Any:
    """Turn a value into what strict JSON can hold."""
    if isinstance(value, dict):
        return {str(key): _strict(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_strict(item) for item in value]
    if isinstance(value, np.ndarray):
        return _strict(value.tolist())
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def progress(text: str) -> None:
    """Say on stderr how far it is, so that stdout holds only results."""
    print(text, file=sys.stderr, flush=True)
