"""A crowd filmed by cameras that nobody has calibrated: lenses, focal lengths, clocks of their own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..arguments import Array, Size
from . import tracks
from .camera import Camera
from .figures import Walkers
from .film import Clock
from .made_up_world import MadeUpWorld
from .rigs import Lenses, Rig, draw_cameras
from .scene import Scene, Solids
from .video import render_video

__all__ = ["BARREL", "Staging", "stage"]

AREA = (8.0, 8.0)
"""Metres on which people walk."""

BARREL = (-0.3, -0.1)
"""k1 of lenses that bend lines visibly, as those of phones and surveillance cameras do."""

LATEST = 8.0
"""Seconds within which cameras are started by hand."""

RATES = (25.0, 30.0)
DRIFT = 20.0
"""Parts per million: standard deviation of a clock's rate."""

POINTS = 2000


@dataclass(frozen=True, eq=False)
class Staging:
    """What moves, the cameras before it, and when each filmed it.

    Attributes
    ----------
    world : MadeUpWorld
    cameras : list of Camera
        The truth; they are called cam1, cam2, …
    clocks : list of Clock
        Frame 0 of each is the first with people.
    volume_points : (n, 3) array
        Random points where things moved, metres.
    empty_frames : int
        Frames of each video before, without anybody.
    seed : int
        Of the videos' noise.
    """

    world: MadeUpWorld
    cameras: list[Camera]
    clocks: list[Clock]
    volume_points: Array
    empty_frames: int
    seed: int

    def filmed(self, index: int) -> Scene:
        """Return the scene in the frames of one camera."""
        clock = self.clocks[index]
        posture = self.world.at(clock.moments)
        world = self.world
        solids = Solids(
            posture.centres,
            posture.axes,
            world.box,
            world.owner,
            np.ones(len(world.box), bool),
            np.ones((len(world.box), len(self.cameras)), bool),
        )
        return Scene(
            "demo", self.cameras, solids, clock.frames, clock.fps, self.volume_points, seed=self.seed
        )

    def render(self, index: int, path: Path) -> Path:
        """Write the video of a camera; see :func:`~epibar.synthetic.render_video`."""
        return render_video(self.filmed(index), index, path, seed=self.seed, empty_frames=self.empty_frames)

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
    clocks = _clocks(np.random.default_rng((seed, 2)), cameras, seconds, unsynchronised)
    length = max(float(clock.moments[-1]) for clock in clocks) + 1.0
    rng = np.random.default_rng((seed, 1))
    world = MadeUpWorld([Walkers(rng, tracks.free(rng, walkers, length, AREA))])
    points = world.random_points(rng, length, POINTS)
    rng = np.random.default_rng((seed, 0))
    rig = Rig(
        ("ring",),
        height=(2.2, 4.0),
        beyond=(2.5, 4.5),
        focal=(0.65, 0.95),
        roll=0.05,
        sizes=(size,),
        least_seen=0.7,
        least_span=0.6,
    )
    lens = Lenses(k1=BARREL, wide=0.0, alike=False).maker(rng) if barrel else None
    made = [
        replace(camera, name=f"cam{index + 1}")
        for index, camera in enumerate(draw_cameras(rng, rig, cameras, AREA, points, lens))
    ]
    return Staging(world, made, clocks, points, empty_frames, seed)


def _clocks(rng: np.random.Generator, count: int, seconds: float, unsynchronised: bool) -> list[Clock]:
    if not unsynchronised:
        return [Clock(0.0, RATES[0], round(seconds * RATES[0])) for _ in range(count)]
    late, rates = rng.uniform(0.0, LATEST, count), rng.choice(RATES, count)
    drifts = np.concatenate([[0.0], rng.normal(0.0, DRIFT, count - 1)])  # the first is the reference
    return [
        Clock(float(start), float(rate), round(seconds * rate), float(drift))
        for start, rate, drift in zip(late - late.min(), rates, drifts, strict=True)
    ]
