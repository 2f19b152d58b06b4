"""Pairs for `verdicts`: without an answer, in every way that came to mind, and with one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from common import SCENES, Array, Mask, record_masks

from epibar import synthetic
from epibar.recording import Recording
from epibar.synthetic import LOW_CAMERAS, Camera, Scene

SIZE = (640, 480)
LAMPS = 6
FLASH_RATE = 0.06
"""Share of frames in which a lamp, or the light of the room, is on."""


@dataclass(frozen=True)
class Pair:
    """Two recordings; the true F and points of the moving volume where there are any."""

    a: Recording
    b: Recording
    truth: Array | None = None
    volume: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class Case:
    """A way to make pairs: ``make(number, frames, lines)``."""

    make: Callable[[int, int, int], Pair]
    answerable: bool = False
    repeats: bool = True


def _rng(number: int, stream: int) -> np.random.Generator:
    return np.random.default_rng((number, stream, 4711))


def _scene(number: int, frames: int, **options: Any) -> Scene:
    """Return cubes, people before high or people before low cameras, in turn."""
    if number % 3 == 0:
        return synthetic.cubes(number, cameras=4, frames=frames, **options)
    heights: dict[str, Any] = {} if number % 3 == 1 else {"camera_height": LOW_CAMERAS}
    return synthetic.people(number, frames=frames, **heights, **options)


def _partner(number: int) -> int:
    """Return a neighbour of camera 0, or the camera opposite, in turn."""
    return 1 + number % 2


def _record(
    masks: Iterator[Mask], lines: int, number: int, side: int, size: tuple[int, int] = SIZE
) -> Recording:
    return record_masks(masks, size, lines, 1000 * number + side)


def _pair(masks_a: Iterator[Mask], masks_b: Iterator[Mask], lines: int, number: int) -> Pair:
    """Record two streams of masks, of which no truth is known."""
    return Pair(_record(masks_a, lines, number, 0), _record(masks_b, lines, number, 1))


def _pair_of(scene: Scene, lines: int, number: int, b: int, a: int = 0) -> Pair:
    """Record two cameras of a scene with its truth."""
    sizes = scene.cameras[a].size, scene.cameras[b].size
    return Pair(
        _record(scene.iter_masks(a), lines, number, 0, sizes[0]),
        _record(scene.iter_masks(b), lines, number, 1, sizes[1]),
        scene.fundamental(a, b),
        scene.volume_correspondences(a, b),
    )


# --- without an answer ---


def unrelated(number: int, frames: int, lines: int) -> Pair:
    """The same two cameras, each before a motion of its own."""
    a, b = _scene(number, frames), _scene(number, frames, motion_seed=number + 1000)
    return _pair(a.iter_masks(0), b.iter_masks(_partner(number)), lines, number)


def reversed_time(number: int, frames: int, lines: int) -> Pair:
    """One of the two runs backwards."""
    scene, b = _scene(number, frames), _partner(number)
    backwards = (scene.masks(b, frame, frame + 1)[0] for frame in reversed(range(frames)))
    return _pair(scene.iter_masks(0), backwards, lines, number)


def _specks(rng: np.random.Generator, frames: int) -> Iterator[Mask]:
    """Single pixels, so few that lines have zeros and ones."""
    for _ in range(frames):
        yield (rng.random(SIZE[::-1]) < 5e-4).astype(np.uint8)


def _blobs(rng: np.random.Generator, frames: int) -> Iterator[Mask]:
    """Ellipses that are somewhere else in every frame."""
    for _ in range(frames):
        mask = np.zeros(SIZE[::-1], np.uint8)
        for _ in range(rng.poisson(6)):
            centre = [int(value) for value in rng.uniform(0, 1, 2) * SIZE]
            axes = [int(value) for value in rng.uniform(5, 40, 2)]
            cv2.ellipse(mask, centre, axes, float(rng.uniform(0, 180)), 0, 360, 1, -1)
        yield mask


def noise(number: int, frames: int, lines: int) -> Pair:
    """Nothing but noise: specks and blobs in turn."""
    kind = _specks if number % 2 else _blobs
    return _pair(kind(_rng(number, 0), frames), kind(_rng(number, 1), frames), lines, number)


def _flooded(masks: Iterator[Mask], on: np.ndarray) -> Iterator[Mask]:
    for mask, lit in zip(masks, on, strict=True):
        yield np.ones_like(mask) if lit else mask


def _room_light(number: int, frames: int, lines: int, together: bool) -> Pair:
    """Unrelated motion, and in both views a light that fills the image for single frames."""
    a, b = _scene(number, frames), _scene(number, frames, motion_seed=number + 1000)
    times = [_rng(number, 10 if together else 10 + side).random(frames) < FLASH_RATE for side in (0, 1)]
    flooded_b = _flooded(b.iter_masks(_partner(number)), times[1])
    return _pair(_flooded(a.iter_masks(0), times[0]), flooded_b, lines, number)


def room_light_same(number: int, frames: int, lines: int) -> Pair:
    """The light comes on at the same times in both."""
    return _room_light(number, frames, lines, together=True)


def room_light_other(number: int, frames: int, lines: int) -> Pair:
    """The light comes on at times of its own in each."""
    return _room_light(number, frames, lines, together=False)


def _lamps(places: np.random.Generator, times: np.random.Generator, frames: int) -> Iterator[Mask]:
    """Lamps at fixed places that blink, each at its own random times."""
    centres, radii = places.uniform(0.08, 0.92, (LAMPS, 2)) * SIZE, places.uniform(6, 30, LAMPS)
    on = times.random((frames, LAMPS)) < FLASH_RATE
    for lit in on:
        mask = np.zeros(SIZE[::-1], np.uint8)
        for (x, y), radius in zip(centres[lit], radii[lit], strict=True):
            cv2.circle(mask, (round(x), round(y)), round(radius), 1, -1)
        yield mask


def _blinking(number: int, frames: int, lines: int, together: bool) -> Pair:
    times = 30, 30 if together else 31
    a, b = (_lamps(_rng(number, 20 + side), _rng(number, times[side]), frames) for side in (0, 1))
    return _pair(a, b, lines, number)


def lamps_same(number: int, frames: int, lines: int) -> Pair:
    """Six lamps blink at the same times in both, at places and with sizes that no geometry relates."""
    return _blinking(number, frames, lines, together=True)


def lamps_other(number: int, frames: int, lines: int) -> Pair:
    """Six lamps blink in each, at times of their own."""
    return _blinking(number, frames, lines, together=False)


def no_baseline(number: int, frames: int, lines: int) -> Pair:
    """Two cameras at one place, the second turned and zoomed."""
    scene, rng = _scene(number, frames), _rng(number, 40)
    first = scene.cameras[0]
    # Where the first camera looks, at the distance of the middle of the scene.
    target = first.centre + first.R[2] * np.linalg.norm(first.centre) + rng.uniform(-0.8, 0.8, 3)
    zoom, roll = float(rng.uniform(0.7, 1.3)), float(rng.uniform(-8, 8))
    turned = Camera.look_at(first.centre, target, float(first.K[0, 0]) * zoom, first.size, roll, "turned")
    scene = replace(scene, cameras=[first, turned, *scene.cameras[2:]])
    return _pair(scene.iter_masks(0), scene.iter_masks(1), lines, number)


def same_camera(number: int, frames: int, lines: int) -> Pair:
    """One camera taken for two."""
    scene = _scene(number, frames)
    return _pair(scene.iter_masks(0), scene.iter_masks(0), lines, number)


def one_path(number: int, frames: int, lines: int) -> Pair:
    """Everybody on one straight line: there is a truth, but the motion leaves it undetermined."""
    scene = synthetic.people(number, one_path=True, frames=frames)
    return _pair_of(scene, lines, number, _partner(number))


def _still(value: int, frames: int) -> Iterator[Mask]:
    for _ in range(frames):
        yield np.full(SIZE[::-1], value, np.uint8)


def empty(number: int, frames: int, lines: int) -> Pair:
    """Nothing moves in either."""
    return _pair(_still(0, frames), _still(0, frames), lines, number)


def one_empty(number: int, frames: int, lines: int) -> Pair:
    """Nothing moves in one of the two."""
    return _pair(_scene(number, frames).iter_masks(0), _still(0, frames), lines, number)


def full(number: int, frames: int, lines: int) -> Pair:
    """Everything moves all the time in both."""
    return _pair(_still(1, frames), _still(1, frames), lines, number)


# --- with an answer ---


def _answerable(name: str) -> Case:
    def make(number: int, frames: int, lines: int) -> Pair:
        return _pair_of(SCENES[name](number, frames), lines, number, _partner(number))

    return Case(make, answerable=True)


CASES: dict[str, Case] = {
    "unrelated": Case(unrelated),
    "reversed": Case(reversed_time),
    "noise": Case(noise),
    "room_light_same": Case(room_light_same),
    "room_light_other": Case(room_light_other),
    "lamps_same": Case(lamps_same),
    "lamps_other": Case(lamps_other),
    "no_baseline": Case(no_baseline),
    "same_camera": Case(same_camera),
    "one_path": Case(one_path),
    "one_empty": Case(one_empty),
    "empty": Case(empty, repeats=False),
    "full": Case(full, repeats=False),
    "cubes": _answerable("cubes"),
    "high": _answerable("high"),
    "low": _answerable("low"),
}
