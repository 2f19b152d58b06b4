"""What the measuring programs share: scenes by name, recording, errors against the truth."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from options import Method
from tables import percent, px

import epibar
from epibar import synthetic
from epibar.evaluation import GOOD_PAIR_PX, compare, true_candidate_rate
from epibar.foreground import Foreground
from epibar.foreground.options import ForegroundOptions
from epibar.recording import MIN_COMPONENT_AREA, Recording, new_recorder
from epibar.synthetic import LOW_CAMERAS, Scene

Array = NDArray[np.float64]
Mask = NDArray[np.uint8]

FACTORS = (1, 2, 3)
"""Multiples of the stated expected error that the true error is held against."""

SCENES: dict[str, Callable[..., Scene]] = {
    "cubes": lambda seed, frames: synthetic.cubes(seed, frames=frames),
    "thin": lambda seed, frames: synthetic.thin_cubes(seed, frames=frames),
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
    evidence: dict[str, float]
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
        source=cal.source,
        error=error,
        image_error=image_error,
        volume_points=len(volume[0]),
        expected_error=math.nan if cal.expected_error is None else cal.expected_error,
        true_candidates=rate,
        candidates=len(found),
        frontier_points=len(cal.frontier_points),
        evidence=dict(cal.evidence),
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
    focal_error: float | None = None,
) -> list[Outcome]:
    """Record a scene and measure its pairs, all or the first so many, by each method.

    With ``focal_error`` the recordings know their camera matrices, with focal lengths that are too long and
    too short by this share in turn.
    """
    chosen = list(combinations(range(len(scene.cameras)), 2))[:pairs]
    # Only what a pair needs is recorded.
    needed = {camera for pair in chosen for camera in pair}
    recordings = {camera: record_camera(scene, camera, lines, seed) for camera in sorted(needed)}
    if focal_error is not None:
        for camera, recording in recordings.items():
            recording.matrix = scene.cameras[camera].K.copy()
            recording.matrix[[0, 1], [0, 1]] *= 1.0 + (focal_error if camera % 2 else -focal_error)
    outcomes = []
    for method in methods:
        for a, b in chosen:
            outcomes.append(measure(scene, recordings, a, b, method, seed, name))
            if watch is not None:
                watch(outcomes[-1])
    return outcomes
