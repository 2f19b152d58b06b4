"""Where cameras stand, how they look, and through which lens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Array
from ..errors import EpibarError
from . import fisheye
from .camera import Camera
from .lens import smooth_lens

Range = tuple[float, float]
Area = tuple[float, float]

SIZES = {
    (640, 480): 0.3,
    (720, 576): 0.2,
    (640, 360): 0.1,
    (800, 600): 0.1,
    (1024, 768): 0.08,
    (1280, 720): 0.16,
    (1920, 1080): 0.06,
}
"""Image sizes, and how often each is drawn."""

LAYOUTS = ("ring", "corners", "row", "facing")
TRIES = 60
WIDEST = 120.0
"""Degrees from the left of an image to its right."""


@dataclass(frozen=True)
class Rig:
    """What cameras are drawn from.

    Attributes
    ----------
    layouts : tuple of str
        ``circle``: around the origin, at ``beyond`` metres from it. ``ring``: around the area. ``corners``:
        in the corners of the area, then at its sides. ``row``: along one side, 1–4 m apart. ``facing``: the
        first two opposite and aimed at each other, the rest around. ``beside``: on either side of the x axis,
        looking across it. ``before``: within 60° of the y axis, at ``beyond`` metres from the origin.
    height : (low, high)
        Metres.
    beyond : (low, high)
        Metres from the edge of the area to a camera.
    focal : (low, high)
        Image widths, drawn evenly in the logarithm.
    focal_px : (low, high), optional
        Pixels, drawn evenly, instead.
    roll : float
        Radians, at most, either way.
    sizes : dict of size to weight, or tuple of sizes that are taken in turn
    least_seen : float
        Share of the points where things move that a camera must see, or it is drawn anew.
    least_span : float
        Share of its image's width that they must span there, from the 2nd percentile to the 98th.
    one_size : bool
        Whether all cameras have one size (and, nearly, one focal length) in half of the situations.
    """

    layouts: tuple[str, ...] = LAYOUTS
    height: Range = (1.2, 8.0)
    beyond: Range = (1.0, 8.0)
    focal: Range = (0.6, 2.0)
    focal_px: Range | None = None
    roll: float = 0.2
    sizes: dict[tuple[int, int], float] | tuple[tuple[int, int], ...] | None = None
    least_seen: float = 0.3
    least_span: float = 0.0
    one_size: bool = False


def log_uniform(rng: np.random.Generator, bounds: Range) -> float:
    """Draw evenly in the logarithm."""
    return float(np.exp(rng.uniform(*np.log(bounds))))


def _places(rng: np.random.Generator, layout: str, count: int, area: Area, rig: Rig) -> tuple[Array, Array]:
    """Draw (count, 2) places and (count, 2) aims on the floor."""
    half = np.array(area) / 2
    beyond = rng.uniform(*rig.beyond, count)
    aims = rng.uniform(-0.3, 0.3, (count, 2)) * half
    if layout == "corners":
        signs = np.array([(1, 1), (-1, -1), (-1, 1), (1, -1), (1, 0), (-1, 0), (0, 1), (0, -1)])
        signs = np.resize(signs * rng.choice([-1, 1], 2), (count, 2))
        jitter = rng.uniform(-0.15, 0.15, (count, 2)) * half
        return signs * (half + beyond[:, None] * 0.7) + jitter, aims
    if layout == "beside":
        places = np.column_stack([rng.uniform(-0.4, 0.4, count), rng.choice([-1, 1], count)]) * half
        places[:, 1] += np.sign(places[:, 1]) * beyond
        return places, np.column_stack([places[:, 0] + rng.uniform(-1.5, 1.5, count), np.zeros(count)])
    if layout == "before":
        angle = rng.uniform(np.pi / 6, 5 * np.pi / 6, count)
        return np.column_stack([np.cos(angle), np.sin(angle)]) * beyond[:, None], aims
    if layout == "row":
        gap = rng.uniform(1.0, 4.0)
        along = (np.arange(count) - (count - 1) / 2) * gap + rng.uniform(-0.3, 0.3, count) * gap
        side = rng.integers(2)
        places = np.empty((count, 2))
        places[:, side] = along
        places[:, 1 - side] = rng.choice([-1, 1]) * (
            half[1 - side] + beyond.mean() + rng.uniform(-0.3, 0.3, count)
        )
        aims[:, side] += rng.uniform(0, 0.6) * along
        return places, aims
    angle = rng.uniform(0, 2 * np.pi) + (np.arange(count) + rng.uniform(-0.4, 0.4, count)) * 2 * np.pi / count
    if layout == "facing" and count > 1:
        angle[1] = angle[0] + np.pi + rng.uniform(-0.3, 0.3)
    away = np.column_stack([np.cos(angle), np.sin(angle)])
    if layout == "circle":
        return away * beyond[:, None], aims
    # On an ellipse about the area, and then outwards.
    places = away * half * 1.1 + away * beyond[:, None]
    if layout == "facing" and count > 1:
        aims[:2] = 0.7 * aims[:2] + 0.3 * places[1::-1]
    return places, aims


def _size(rng: np.random.Generator, rig: Rig, index: int) -> tuple[int, int]:
    if isinstance(rig.sizes, tuple):
        return rig.sizes[index % len(rig.sizes)]
    weights = rig.sizes or SIZES
    names, odds = list(weights), np.array(list(weights.values()))
    return names[int(rng.choice(len(names), p=odds / odds.sum()))]


def draw_cameras(
    rng: np.random.Generator,
    rig: Rig,
    count: int,
    area: Area,
    points: Array,
    lens: Callable[[np.random.Generator, Camera], Camera] | None = None,
    aim_height: Range = (0.4, 1.4),
) -> list[Camera]:
    """Draw cameras, anew while one sees too few of the (n, 3) points; the last of `TRIES` is taken as it is.

    Parameters
    ----------
    lens : callable, optional
        Gives a camera its lens, principal point and aspect.
    """
    layout = str(rng.choice(rig.layouts))
    alike = rig.one_size and rng.random() < 0.5
    focal, first = log_uniform(rng, rig.focal), _size(rng, rig, 0)

    def one(index: int, place: Array, aim: Array) -> Camera:
        size = first if alike else _size(rng, rig, index)
        widths = focal * rng.uniform(0.97, 1.03) if alike else log_uniform(rng, rig.focal)
        pixels = widths * size[0] if rig.focal_px is None else rng.uniform(*rig.focal_px)
        camera = Camera.look_at(
            [*place, rng.uniform(*rig.height)],
            [*aim, rng.uniform(*aim_height)],
            pixels,
            size,
            float(np.rad2deg(rng.uniform(-rig.roll, rig.roll))),
            f"cam{index + 1:02d}",
        )
        return camera if lens is None else lens(rng, camera)

    for attempt in range(TRIES):
        places, aims = _places(rng, layout, count, area, rig)
        cameras: list[Camera] = []
        for index in range(count):
            for _ in range(6):
                camera = one(index, places[index], aims[index])
                seen, span = coverage(camera, points)
                good = seen >= rig.least_seen and span >= rig.least_span and not crowded(camera, cameras)
                if good or attempt == TRIES - 1:
                    cameras.append(camera)
                    break
            else:
                break
        if len(cameras) == count:
            return cameras
    raise AssertionError("the last attempt takes what comes")


def crowded(camera: Camera, others: list[Camera]) -> bool:
    """Whether a camera stands within 0.7 m of another."""
    return any(np.linalg.norm(camera.centre - other.centre) < 0.7 for other in others)


def coverage(camera: Camera, points: Array) -> tuple[float, float]:
    """Share of (n, 3) points that a camera sees, and share of the width of its image that these span."""
    pixels, depth = camera.project(points)
    with np.errstate(invalid="ignore"):
        bent = camera.distort(pixels)
        inside = ((bent >= 0) & (bent <= np.array(camera.size) - 1)).all(axis=1)
    inside &= depth > 0
    if not inside.any():
        return (0.0, 0.0) if len(points) else (1.0, 1.0)
    left, right = np.percentile(bent[inside, 0], (2, 98))
    return float(inside.mean()), float((right - left) / camera.size[0])


@dataclass(frozen=True)
class Lenses:
    """What lenses are drawn from.

    Attributes
    ----------
    k1 : (low, high)
    wide : float
        Share of cameras whose field of view is drawn, evenly from 85° to 120°, not their focal length.
    tangential : float
        Standard deviation of p1 and p2.
    off_centre : float
        Largest distance of the principal point from the middle along either axis, image widths.
    aspect : float
        Standard deviation of fy / fx about 1.
    alike : bool
        Whether all cameras of a situation have one lens (in half of the situations).
    """

    k1: Range = (-0.4, 0.05)
    wide: float = 0.2
    tangential: float = 0.0
    off_centre: float = 0.0
    aspect: float = 0.0
    alike: bool = True

    def maker(self, rng: np.random.Generator) -> Callable[[np.random.Generator, Camera], Camera]:
        """Draw what the lenses of one situation have in common; returns what gives a camera its lens."""
        common = rng.uniform(*self.k1) if self.alike and rng.random() < 0.5 else None

        def make(rng: np.random.Generator, camera: Camera) -> Camera:
            for _ in range(200):
                k1 = rng.uniform(*self.k1) if common is None else common
                made = self._lens(rng, camera, k1)
                if made is not None:
                    return made
            raise EpibarError(f"no lens with k1 in {self.k1} fits {camera.size} at f = {camera.K[0, 0]:.0f}")

        return make

    def _lens(self, rng: np.random.Generator, camera: Camera, k1: float) -> Camera | None:
        """Draw one lens; None where it folds, or looks wider than `WIDEST`."""
        K, width = camera.K.copy(), camera.size[0]
        K[:2, 2] += rng.uniform(-self.off_centre, self.off_centre, 2) * width
        aspect = rng.normal(1.0, self.aspect) if self.aspect else 1.0
        tangential = rng.normal(0, self.tangential, 2) if self.tangential else np.zeros(2)
        terms, growth = int(rng.choice([1, 2, 3], p=[0.3, 0.3, 0.4])), rng.uniform(0.0, 1.0)
        wide, view = rng.random() < self.wide, rng.uniform(85.0, WIDEST)
        reach = self._reach(K, camera.size)
        if wide:
            # By the smooth curve; what the polynomial makes of it is looked at below.
            r, q = np.tan(np.deg2rad(view / 2)), growth - 2 * min(k1, 0.0)
            bent = r * (1 + q * r * r) ** (k1 / q) if q > 1e-6 else r * (1 + k1 * r * r)
            K[0, 0], reach = width / 2 / bent, 1.25 * r
        K[1, 1] = K[0, 0] * aspect
        if terms == 1 or k1 >= 0:
            found: tuple[float, ...] = (k1, 0.0, 0.0, 0.0, 0.0)
        else:
            found = smooth_lens(
                k1, growth - 2 * k1 + 0.05, max(1.6 * reach if not wide else reach, 0.3), terms
            )
        found = (found[0], found[1], *(float(p) for p in tangential), found[4])
        made = replace(camera, K=K, distortions=found)
        try:
            _ = made.lens_limit
        except EpibarError:
            return None
        return made if field_of_view(made) <= WIDEST else None

    @staticmethod
    def _reach(K: Array, size: tuple[int, int]) -> float:
        """Bent r of the farthest corner."""
        corners = np.array([(0, 0), (size[0], 0), (0, size[1]), size], dtype=np.float64)
        return float(np.hypot(*((corners - K[:2, 2]) / K[0, 0]).T).max())


@dataclass(frozen=True)
class FisheyeLenses:
    """What fisheye lenses are drawn from; their principal points are in the middle.

    Attributes
    ----------
    view : (low, high)
        Degrees from corner to corner of the image, below 180.
    k : (low, high)
        Of :mod:`~epibar.synthetic.fisheye`; cameras of one situation have one.
    """

    view: Range = (100.0, 160.0)
    k: Range = (-0.04, 0.08)

    def maker(self, rng: np.random.Generator) -> Callable[[np.random.Generator, Camera], Camera]:
        """Draw what the lenses of one situation have in common; returns what gives a camera its lens."""
        k = rng.uniform(*self.k)

        def make(rng: np.random.Generator, camera: Camera) -> Camera:
            theta = np.deg2rad(rng.uniform(*self.view) / 2)
            K = camera.K.copy()
            K[0, 0] = K[1, 1] = np.hypot(*camera.size) / 2 / fisheye.seen_at(theta, k)
            return replace(camera, K=K, fisheye=k)

        return make


def field_of_view(camera: Camera) -> float:
    """Angle from the left of an image to its right through its middle, degrees."""
    middle = (camera.size[1] - 1) / 2
    ends = camera.undistort(np.array([[-0.5, middle], [camera.size[0] - 0.5, middle]]))
    rays = np.column_stack([ends, np.ones(2)]) @ np.linalg.inv(camera.K).T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return float(np.rad2deg(np.arccos(np.clip(rays[0] @ rays[1], -1, 1))))
