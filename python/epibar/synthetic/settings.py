"""A setting: the distributions that a situation is drawn from, and how it is drawn.

Cameras, motion, and what is wrong with masks come from random streams of their own, which all follow from the
seed and the name of the family.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..arguments import Array
from .camera import Camera
from .dirt import Dirt
from .figures import Movers
from .film import Clock, Film, Outlines
from .made_up_world import Furniture, MadeUpWorld
from .motion import rotations
from .rigs import FisheyeLenses, Lenses, Rig, draw_cameras, log_uniform
from .situations import Situation

Rng = np.random.Generator
Area = tuple[float, float]
Range = tuple[float, float]

RATES = (2.0, 5.0, 7.0, 10.0, 12.5, 15.0, 25.0, 29.97, 30.0, 50.0, 60.0)
"""Frames per second."""

BUDGET = 2.5e9
"""Pixels that all cameras of a situation film together: some 8,000 frames of 640×480."""

POINTS = 4000


def stream(seed: int, family: str, number: int) -> Rng:
    """Make one of the random streams of a situation."""
    return np.random.default_rng((seed, zlib.crc32(family.encode()), number))


@dataclass(frozen=True)
class Setting:
    """Everything that a situation with synchronised cameras is drawn from.

    Attributes
    ----------
    movers : callable
        ``movers(rng, count, length, area)`` gives them.
    count : (low, high)
        How many movers, both inclusive.
    area : two ranges
        Metres along x and y, where they go about.
    rig : Rig
    cameras : (low, high)
        How many, both inclusive.
    frames : (low, high)
        Drawn evenly in the logarithm, then cut down to ``budget``.
    rates : tuple of float
        Frames per second, one of them.
    seconds : (low, high)
        The time filmed is kept within these where frames allow.
    strangers : float
        Chance of 1–3 further movers whom only one camera sees each.
    furniture : float
        Chance of 1–6 boxes that hide something from one camera each.
    shadows : float
        Chance that a light casts shadows, which count as moving.
    outlines : str
    jitter : (low, high)
        Of boxes and ellipses, as a share of their size.
    dirt : callable, optional
        ``dirt(rng)`` draws how dirty; None from it is clean.
    lenses : Lenses or FisheyeLenses, optional
    clocks : callable, optional
        ``clocks(rng, fps, frames, count)`` gives them; by default all are one.
    budget : float
        Pixels that all cameras film together, at most.
    spare : float
        Seconds that the world goes on after the last frame.
    """

    movers: Callable[[Rng, int, float, Area], list[Movers]]
    count: tuple[int, int] = (3, 10)
    area: tuple[Range, Range] = ((5.0, 16.0), (5.0, 16.0))
    rig: Rig = field(default_factory=Rig)
    cameras: tuple[int, int] = (2, 8)
    frames: tuple[int, int] = (400, 3000)
    rates: tuple[float, ...] = RATES
    seconds: Range = (20.0, 400.0)
    strangers: float = 0.0
    furniture: float = 0.0
    shadows: float = 0.0
    outlines: Outlines = "silhouettes"
    jitter: Range = (0.0, 0.0)
    dirt: Callable[[Rng], Dirt | None] | None = None
    lenses: Lenses | FisheyeLenses | None = None
    clocks: Callable[[Rng, float, int, int], list[Clock]] | None = None
    budget: float = BUDGET
    spare: float = 0.0


def ragged(rng: Rng) -> Dirt | None:
    """Clean, or ragged edges."""
    if rng.random() < 0.5:
        return None
    return Dirt(0.0, ragged=rng.uniform(0.2, 0.8), ragged_px=int(rng.integers(1, 3)), holes=0.0, missed=0.0)


def dirty(rng: Rng) -> Dirt | None:
    """Everything at once, each in its own measure."""
    return Dirt(
        false_blobs=rng.uniform(0, 4),
        blob_px=(2.0, rng.uniform(6, 24)),
        ragged=rng.uniform(0.2, 0.9),
        ragged_px=int(rng.integers(1, 3)),
        holes=rng.uniform(0, 1.5),
        missed=rng.uniform(0, 0.12),
        merged_px=int(rng.integers(0, 9)),
    )


def occluders(rng: Rng, count: int, cameras: list[Camera], middle: Array) -> Furniture:
    """Stand up boxes, each 30–60 % of the way from one camera, in turn, to about the middle."""
    centres, axes = np.empty((count, 3)), np.empty((count, 3, 3))
    for index in range(count):
        place = cameras[index % len(cameras)].centre
        centres[index] = place + rng.uniform(0.3, 0.6) * (middle - place)
        centres[index, :2] += rng.uniform(-1.5, 1.5, 2)
        turned = rotations(np.array([0.0, 0.0, 1.0]), np.array(rng.uniform(0, np.pi)))
        axes[index] = turned * rng.uniform([0.1, 0.1, 0.4], [0.5, 0.5, 1.2])
        centres[index, 2] = max(centres[index, 2] * rng.uniform(0.3, 1.0), 0.3)
    return Furniture(centres, axes, np.arange(count) % len(cameras))


def drawn_light(rng: Rng) -> Array:
    """The way of a light 25–75° above the horizon."""
    turn, above = rng.uniform(-np.pi, np.pi), np.deg2rad(rng.uniform(25, 75))
    return np.array([np.cos(turn) * np.cos(above), np.sin(turn) * np.cos(above), -np.sin(above)])


def whole(rng: Rng, bounds: tuple[int, int]) -> int:
    """Draw a whole number, both ends inclusive."""
    return int(rng.integers(bounds[0], bounds[1] + 1))


def turned(camera: Camera, rng: Rng, degrees: float) -> Camera:
    """Turn a camera where it stands, about an axis drawn at random."""
    axis = rng.normal(size=3)
    turn = rotations(axis / np.linalg.norm(axis), np.array(np.deg2rad(degrees)))
    return replace(camera, R=turn @ camera.R, t=turn @ camera.t)


def one_clock(fps: float, frames: int, count: int) -> list[Clock]:
    """All cameras alike, from second 0 of the world."""
    return [Clock(0.0, fps, frames)] * count


def timing(rng: Rng, setting: Setting) -> tuple[float, int]:
    """Draw frames per second and how many frames."""
    frames = log_uniform(rng, setting.frames)
    low, high = setting.seconds
    rates = [rate for rate in setting.rates if low <= frames / rate <= high] or [
        min(setting.rates, key=lambda rate: abs(np.log(frames / rate / np.sqrt(low * high))))
    ]
    return float(rng.choice(rates)), round(frames)


def room(rng: Rng, area: Area, count: int = POINTS) -> Array:
    """Random points over an area, from the floor to 2 m."""
    return rng.uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 2.0], (count, 3)) * [*area, 1.0]


def draw(seed: int, family: str, setting: Setting) -> Situation:
    """Draw a situation of a setting."""
    rng, motion, camera_rng, masks = (stream(seed, family, number) for number in range(4))
    count, movers = whole(rng, setting.cameras), whole(rng, setting.count)
    area = (float(rng.uniform(*setting.area[0])), float(rng.uniform(*setting.area[1])))
    fps, frames = timing(rng, setting)
    clocks = one_clock(fps, frames, count)
    if setting.clocks is not None:
        clocks = setting.clocks(rng, fps, frames, count)
    length = max(float(clock.moments[-1]) for clock in clocks)
    groups = setting.movers(motion, movers, length + setting.spare, area)
    world = MadeUpWorld(groups)
    points = world.random_points(motion, length, POINTS)
    lens = None if setting.lenses is None else setting.lenses.maker(camera_rng)
    cameras = draw_cameras(camera_rng, setting.rig, count, area, points, lens)
    world = _extended(masks, setting, world, cameras, length + setting.spare, area)
    clocks = _within_budget(clocks, cameras, setting.budget)
    films = [
        Film(camera, world, index, clock.moments, setting.outlines, seed=seed)
        for index, (camera, clock) in enumerate(zip(cameras, clocks, strict=True))
    ]
    films = [_masked(masks, setting, film) for film in films]
    return Situation(family, seed, cameras, clocks, films, points, room(rng, area), (0,) * count, area)


def _extended(
    rng: Rng, setting: Setting, world: MadeUpWorld, cameras: list[Camera], length: float, area: Area
) -> MadeUpWorld:
    """Add what only some cameras see, what hides, and a light."""
    groups, only = list(world.movers), world.only
    if rng.random() < setting.strangers:
        more = int(rng.integers(1, 4))
        groups += setting.movers(rng, more, length, area)
        added = MadeUpWorld(groups).count - world.count
        only = np.concatenate([only, (np.arange(added) + rng.integers(len(cameras))) % len(cameras)])
    furniture, light = None, None
    if rng.random() < setting.furniture:
        furniture = occluders(rng, int(rng.integers(1, 7)), cameras, np.array([0.0, 0.0, 1.0]))
    if rng.random() < setting.shadows:
        light = drawn_light(rng)
    return MadeUpWorld(groups, only, furniture, light)


def _within_budget(clocks: list[Clock], cameras: list[Camera], budget: float) -> list[Clock]:
    pixels = sum(
        c.frames * camera.size[0] * camera.size[1] for c, camera in zip(clocks, cameras, strict=True)
    )
    share = min(1.0, budget / pixels)
    least = min(100, *(clock.frames for clock in clocks))
    return [replace(clock, frames=max(int(clock.frames * share), least)) for clock in clocks]


def _masked(rng: Rng, setting: Setting, film: Film) -> Film:
    """Draw how dirty the masks of a camera are."""
    dirt = None if setting.dirt is None else setting.dirt(rng)
    cleaned, jitter = bool(rng.integers(2)), float(rng.uniform(*setting.jitter))
    return replace(film, dirt=dirt, cleaned=cleaned and dirt is not None, jitter=jitter)
