"""Scenes by name: `cubes`, `thin_cubes`, `people`. Every number is drawn from the seed.

Cameras and motion come from separate random streams: the same ``seed`` with another ``motion_seed`` gives the
same cameras and unrelated motion, which is how to make two recordings that have nothing to do with each
other.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arguments import Bits, Size
from . import motion
from .camera import Camera
from .dirt import Dirt
from .scene import Scene, Solids

HIGH_CAMERAS = (2.5, 7.0)
LOW_CAMERAS = (1.5, 2.2)

# Image sizes relative to the one asked for, camera by camera, in an asymmetric scene.
_ASYMMETRIC = ((1.0, 1.0), (1.25, 1.25), (0.8, 1.2), (1.5, 0.9), (0.75, 0.75))


def _ring(
    rng: np.random.Generator,
    count: int,
    size: Size,
    distance: tuple[float, float],
    height: tuple[float, float],
    focal: tuple[float, float],
    target: tuple[float, float, float],
    asymmetric: bool,
    facing: bool,
) -> list[Camera]:
    """Place cameras all around that look at about the target; focal lengths in widths of a 4:3 image."""
    angles = (
        rng.uniform(0, 2 * np.pi) + (np.arange(count) + rng.uniform(-0.25, 0.25, count)) * 2 * np.pi / count
    )
    distances, heights = rng.uniform(*distance, count), rng.uniform(*height, count)
    focals, rolls = rng.uniform(*focal, count), rng.uniform(-3, 3, count)
    aims = np.array(target) + rng.uniform(-0.4, 0.4, (count, 3)) * (1, 1, 0.5)
    if asymmetric:
        rolls = rng.uniform(10, 30, count) * rng.choice([-1, 1], count)
        focals = focals * np.resize([1.0, 1.35, 0.85, 1.15, 0.95], count)
    if facing and count > 1:
        # Opposite, and aimed at each other: the epipoles lie inside the images.
        angles[1] = angles[0] + np.pi + rng.uniform(0.1, 0.3) * rng.choice([-1, 1])
    places = np.column_stack([distances * np.cos(angles), distances * np.sin(angles), heights])
    if facing and count > 1:
        aims[:2] = 0.6 * aims[:2] + 0.4 * places[1::-1]
    cameras = []
    for i in range(count):
        scale = _ASYMMETRIC[i % len(_ASYMMETRIC)] if asymmetric else (1.0, 1.0)
        image = (round(size[0] * scale[0]), round(size[1] * scale[1]))
        cameras.append(
            Camera.look_at(
                places[i],
                aims[i],
                focals[i] * min(image[0], image[1] * 4 / 3),
                image,
                float(rolls[i]),
                f"camera {i + 1}",
            )
        )
    return cameras


def _one_each(count: int, cameras: int, parts: int = 1) -> Bits:
    """Let each object be seen by one camera, in turn: (count · parts, cameras), part by part as `bodies`."""
    return np.tile(np.eye(cameras, dtype=bool)[np.arange(count) % cameras], (parts, 1))


def _occluders(
    rng: np.random.Generator,
    count: int,
    cameras: list[Camera],
    frames: int,
    target: tuple[float, float, float],
) -> Solids:
    """Stand up boxes, each hiding a part of the view of one camera, in turn."""
    centres, axes = np.empty((count, 3)), np.zeros((count, 3, 3))
    for i in range(count):
        place = cameras[i % len(cameras)].centre
        centres[i] = place + rng.uniform(0.3, 0.5) * (np.array(target) - place)
        centres[i, :2] += rng.uniform(-1.2, 1.2, 2)
        turn = rng.uniform(0, np.pi)
        turned = motion.rotations(np.array([0.0, 0.0, 1.0]), np.array(turn))
        axes[i] = turned * rng.uniform([0.15, 0.15, 0.5], [0.4, 0.4, 1.0])
    return Solids.of(
        np.broadcast_to(centres, (frames, count, 3)),
        np.broadcast_to(axes, (frames, count, 3, 3)),
        True,
        np.arange(count),
        _one_each(count, len(cameras)),
        moving=False,
    )


def _scene(
    name: str,
    cameras: list[Camera],
    solids: Solids,
    fps: float,
    rng: np.random.Generator,
    seed: int,
    dirty: bool | Dirt,
) -> Scene:
    points = solids.random_points(5000, rng)
    dirt = dirty if isinstance(dirty, Dirt) else (Dirt() if dirty else None)
    return Scene(name, cameras, solids, len(solids.centres), fps, points, seed, dirt)


def _streams(seed: int, motion_seed: int | None) -> tuple[np.random.Generator, np.random.Generator]:
    return np.random.default_rng((seed, 0)), np.random.default_rng(
        (seed if motion_seed is None else motion_seed, 1)
    )


def cubes(
    seed: int = 0,
    *,
    cameras: int = 5,
    objects: int = 20,
    size_m: tuple[float, float] = (0.15, 0.3),
    thin: bool = False,
    speed: tuple[float, float] = (0.4, 1.6),
    frames: int = 800,
    size: Size = (640, 480),
    fps: float = 25.0,
    asymmetric: bool = False,
    facing: bool = False,
    one_camera_only: int = 0,
    occluders: int = 0,
    dirty: bool | Dirt = False,
    motion_seed: int | None = None,
    name: str = "cubes",
) -> Scene:
    """Let cubes fly in a volume of 4.8 × 4.8 × 3.6 m, with cameras all around at different heights.

    Parameters
    ----------
    seed : int
        Of everything.
    cameras, objects : int
    size_m : (low, high)
        Edge lengths, metres.
    thin : bool
        Sticks rather than cubes.
    speed : (low, high)
        Along each axis, metres per second.
    frames : int
    size : (width, height)
        Pixels.
    fps : float
    asymmetric : bool
        Different image sizes and focal lengths, cameras rolled by 10–30°.
    facing : bool
        The first two cameras see each other: epipoles inside the image.
    one_camera_only : int
        Further objects that only one camera sees, in turn.
    occluders : int
        Static boxes that hide moving things in one view each, in turn.
    dirty : bool or Dirt
        Masks as a background subtraction gives them.
    motion_seed : int, optional
        Another motion before the same cameras.
    """
    camera_rng, rng = _streams(seed, motion_seed)
    ring = _ring(
        camera_rng, cameras, size, (5.5, 8.0), (-2.5, 4.0), (0.8, 1.05), (0, 0, 0), asymmetric, facing
    )
    seconds = np.arange(frames) / fps

    def flying(count: int, seen_by: Bits) -> Solids:
        centres, axes = motion.flying_boxes(rng, count, seconds, (2.4, 2.4, 1.8), size_m, thin, speed)
        return Solids.of(centres, axes, True, np.arange(count), seen_by)

    solids = flying(objects, np.ones((objects, cameras), dtype=bool))
    if one_camera_only:
        solids = solids.joined(flying(one_camera_only, _one_each(one_camera_only, cameras)))
    if occluders:
        solids = solids.joined(_occluders(camera_rng, occluders, ring, frames, (0, 0, 0)))
    return _scene(name, ring, solids, fps, rng, seed, dirty)


def thin_cubes(seed: int = 0, *, cameras: int = 7, objects: int = 24, **options: Any) -> Scene:
    """Let smaller and thinner boxes fly, before seven cameras; the options are those of `cubes`."""
    defaults = {"size_m": (0.08, 0.18), "thin": True, "name": "thin cubes"}
    return cubes(seed, cameras=cameras, objects=objects, **{**defaults, **options})


def people(
    seed: int = 0,
    *,
    cameras: int = 4,
    walkers: int = 8,
    camera_height: tuple[float, float] = HIGH_CAMERAS,
    one_path: bool = False,
    frames: int = 800,
    size: Size = (640, 480),
    fps: float = 25.0,
    asymmetric: bool = False,
    facing: bool = False,
    one_camera_only: int = 0,
    occluders: int = 0,
    dirty: bool | Dirt = False,
    motion_seed: int | None = None,
    name: str = "people",
) -> Scene:
    """Let people walk on a floor of 10 × 10 m, with cameras at 9–14 m that look at its middle.

    Parameters
    ----------
    seed : int
        Of everything.
    cameras, walkers : int
    camera_height : (low, high)
        Metres; `LOW_CAMERAS` is the hard case: at head height all heads lie near the horizon, and the floor
        alone explains most of what is seen.
    one_path : bool
        Everybody on one straight line, to and fro: leaves F undetermined.
    frames, size, fps, asymmetric, facing, one_camera_only, occluders, dirty, motion_seed
        As for `cubes`.
    """
    camera_rng, rng = _streams(seed, motion_seed)
    target = (0.0, 0.0, 1.0)
    ring = _ring(
        camera_rng, cameras, size, (9.0, 14.0), camera_height, (0.75, 1.1), target, asymmetric, facing
    )
    walk = motion.path_walks if one_path else motion.walks

    def walking(count: int, seen_by: Bits) -> Solids:
        centres, axes, owner = motion.bodies(rng, *walk(rng, count, frames, fps), fps)
        return Solids.of(centres, axes, False, owner, seen_by)

    solids = walking(walkers, np.ones((7 * walkers, cameras), dtype=bool))
    if one_camera_only:
        solids = solids.joined(walking(one_camera_only, _one_each(one_camera_only, cameras, parts=7)))
    if occluders:
        solids = solids.joined(_occluders(camera_rng, occluders, ring, frames, target))
    return _scene(name, ring, solids, fps, rng, seed, dirty)
