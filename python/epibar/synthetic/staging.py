"""A crowd filmed by cameras that nobody has calibrated: lenses, focal lengths, clocks of their own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..arguments import Size
from .film import Clock
from .generators import people
from .rigs import Lenses
from .scene import Scene
from .video import render_video

__all__ = ["BARREL", "Staging", "stage"]

BARREL = (-0.3, -0.1)
"""k1 of lenses that bend lines visibly, as those of phones and surveillance cameras do."""

LATEST = 8.0
"""Seconds within which cameras are started by hand."""

RATES = (25.0, 30.0)
DRIFT = 20.0
"""Parts per million: standard deviation of a clock's rate."""

DENSE = 30.0
"""Moments per second at which the crowd is known; between them everything moves straight."""


@dataclass(frozen=True, eq=False)
class Staging:
    """A scene, and when each camera filmed it.

    Attributes
    ----------
    scene : Scene
        The truth; its cameras are called cam1, cam2, …
    clocks : list of Clock
        Frame 0 of each is the first with people.
    empty_frames : int
        Frames of each video before, without anybody.
    seed : int
        Of the videos' noise.
    """

    scene: Scene
    clocks: list[Clock]
    empty_frames: int
    seed: int

    def render(self, index: int, path: Path) -> Path:
        """Write the video of a camera; see :func:`~epibar.synthetic.render_video`."""
        clock = self.clocks[index]
        filmed = self.scene.filmed_at(clock.moments, clock.fps)
        return render_video(filmed, index, path, seed=self.seed, empty_frames=self.empty_frames)

    def offset(self, index: int) -> float:
        """Return which second of a video shows what the first frame of the first video shows."""
        first, clock = self.clocks[0], self.clocks[index]
        began = first.start - self.empty_frames / first.fps / first.rate
        return (began - clock.start) * clock.rate + self.empty_frames / clock.fps


def stage(
    seed: int,
    *,
    cameras: int = 4,
    walkers: int = 8,
    seconds: float = 60.0,
    size: Size = (640, 480),
    barrel: bool = True,
    unsynchronised: bool = True,
    empty_frames: int = 25,
) -> Staging:
    """Draw cameras all around a crowd.

    Parameters
    ----------
    seed : int
        Of everything.
    cameras, walkers : int
    seconds : float
        For about so long each films people.
    size : (width, height)
        Pixels.
    barrel : bool
        Lenses that bend lines, k1 in :data:`BARREL`; otherwise pinholes.
    unsynchronised : bool
        Started by hand within :data:`LATEST` seconds, at one of :data:`RATES`, with clocks that drift.
        Otherwise frame by frame together, at the first of those.
    empty_frames : int
    """
    rng = np.random.default_rng((seed, 2))
    late = rng.uniform(0.0, LATEST, cameras)
    rates, drifts = rng.choice(RATES, cameras), rng.normal(0.0, DRIFT, cameras)
    if unsynchronised:
        drifts[0] = 0.0  # the first camera is the reference
        late -= late.min()
    else:
        late, drifts, rates = np.zeros(cameras), np.zeros(cameras), np.full(cameras, RATES[0])
    clocks = [
        Clock(float(start), float(rate), round(seconds * rate), float(drift))
        for start, rate, drift in zip(late, rates, drifts, strict=True)
    ]
    length = max(float(clock.moments[-1]) for clock in clocks)
    frames = int(np.ceil(length * DENSE)) + 2
    scene = people(seed=seed, cameras=cameras, walkers=walkers, frames=frames, size=size, fps=DENSE)
    made = [replace(camera, name=f"cam{index + 1}") for index, camera in enumerate(scene.cameras)]
    if barrel:
        lens = Lenses(k1=BARREL, wide=0.0, alike=False).maker(rng)
        made = [lens(rng, camera) for camera in made]
    return Staging(replace(scene, cameras=made), clocks, empty_frames, seed)
