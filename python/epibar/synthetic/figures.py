"""Bodies of what moves: walkers with limbs, cyclists, cars, animals on four legs, and flat things.

A body is posed at any moments (K of them) from a `Track`: its solids are ellipsoids and boxes that stand on
the floor z = 0. Lengths of walkers and animals are in units of their height. Proportions of people: D. A.
Winter, "Biomechanics and Motor Control of Human Movement", figure 4.1, rounded.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..arguments import Array, Bits, Index
from .tracks import STEP, Track

LEG = 0.245
"""Thigh and shank alike, in body heights."""

ANKLE = 0.04

MEAN_HEIGHT = 1.72
"""Of people, metres: those of one scene are as tall as they happen to be."""


@dataclass(frozen=True, eq=False)
class Posture:
    """Solids at K moments: centres (K, M, 3), half-axes in columns (K, M, 3, 3), which are there (K, M)."""

    centres: Array
    axes: Array
    present: Bits


class Movers(Protocol):
    """Some movers of one kind: which of their M solids are boxes, whose they are, and where they are when."""

    box: Bits
    owner: Index

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""


def between(values: Array, seconds: Array) -> Array:
    """Values of samples `STEP` apart at other moments, (K, ...); straight between two samples."""
    place = np.clip(seconds / STEP, 0, len(values) - 1.000001)
    first = place.astype(np.int64)
    share = (place - first).reshape(-1, *(1,) * (values.ndim - 1))
    return values[first] + share * (values[first + 1] - values[first])


def there_at(present: Bits, seconds: Array) -> Bits:
    """Who is there at moments between samples: who is there at both."""
    first = np.clip(seconds / STEP, 0, len(present) - 1.000001).astype(np.int64)
    return present[first] & present[first + 1]


def heights(rng: np.random.Generator, count: int) -> Array:
    """Draw how tall people are, metres."""
    return np.clip(rng.normal(MEAN_HEIGHT, 0.09, count), 1.4, 2.1)


class Body:
    """Collects the solids of N movers at K moments, part by part."""

    def __init__(self, position: Array, heading: Array, height: Array | float = 0.0) -> None:
        """Stand at (K, N, 2) places, looking along (K, N) headings; ``height`` is of the ground below."""
        self.ground = np.empty((*heading.shape, 3))
        self.ground[..., :2], self.ground[..., 2] = position, height
        cos, sin, zero = np.cos(heading), np.sin(heading), np.zeros_like(heading)
        self.forward = np.stack([cos, sin, zero], axis=2)
        self.left = np.stack([-sin, cos, zero], axis=2)
        self.centres: list[Array] = []
        self.axes: list[Array] = []

    def put(
        self,
        ahead: Array | float,
        aside: Array | float,
        above: Array | float,
        half: Array,
        pitch: Array | float = 0.0,
    ) -> None:
        """Add a solid: centre, (N, 3) or (3,) half-axes (forward, left, up), and how far it leans back."""
        shape = self.forward.shape[:2]
        ahead, aside, above, pitch = (np.broadcast_to(v, shape) for v in (ahead, aside, above, pitch))
        centre = self.ground + ahead[..., None] * self.forward + aside[..., None] * self.left
        centre[..., 2] += above
        cos, sin = np.cos(pitch)[..., None], np.sin(pitch)[..., None]
        half = np.broadcast_to(half, (shape[1], 3))
        axes = np.empty((*shape, 3, 3))
        axes[..., 0] = cos * half[:, :1] * self.forward
        axes[..., 2, 0] += sin[..., 0] * half[:, 0]
        axes[..., 1] = half[:, 1:2] * self.left
        axes[..., 2] = -sin * half[:, 2:] * self.forward
        axes[..., 2, 2] += cos[..., 0] * half[:, 2]
        self.centres.append(centre)
        self.axes.append(axes)

    def bar(
        self,
        ahead: Array | float,
        aside: Array | float,
        above: Array,
        angle: Array,
        length: Array,
        thick: Array,
    ) -> tuple[Array, Array]:
        """Add a limb from a joint, at an angle (0: hanging, positive: its end forward); returns its end."""
        along, down = np.sin(angle) * length, np.cos(angle) * length
        half = np.stack(np.broadcast_arrays(thick, thick, length / 2 + 0.3 * thick), axis=-1)
        self.put(ahead + along / 2, aside, above - down / 2, half, angle)
        return ahead + along, above - down

    def posture(self, present: Bits) -> Posture:
        """Return all of it; ``present`` is (K, N)."""
        parts = len(self.centres)
        centres, axes = np.concatenate(self.centres, axis=1), np.concatenate(self.axes, axis=1)
        return Posture(centres, axes, np.tile(present, (1, parts)))


def stepping(phase: Array) -> Array:
    """How far a leg is forward, −1 … 1, most at phase π/2: evenly back, and swinging forward."""
    share = np.mod(phase / (2 * np.pi) - 0.25, 1.0)
    return np.where(share < 0.5, 1.0 - 4.0 * share, -np.cos(2 * np.pi * (share - 0.5)))


class Walkers:
    """People who walk, stand or dance: 13 ellipsoids each.

    Parameters
    ----------
    rng : Generator
    track : Track
    dance : (N,) bool array, optional
        Who dances: swinging arms and legs on the spot.
    alike : bool
        All of one build and in step, as soldiers are.
    """

    PARTS = 13

    def __init__(
        self,
        rng: np.random.Generator,
        track: Track,
        dance: Bits | None = None,
        alike: bool = False,
    ) -> None:
        count = track.count
        self.track = track
        self.height = heights(rng, count)
        self.girth = rng.uniform(0.85, 1.25, count)
        first = rng.uniform(0, 2 * np.pi, count)
        if alike:
            self.height[:], self.girth[:], first[:] = self.height[:1], self.girth[:1], 0.0
        dance = np.zeros(count, bool) if dance is None else dance
        speed = track.speed()
        # Strides grow with speed, 0.8 heights at 1.3 m/s; legs swing so far that a foot on the floor stays.
        stride = 0.8 * self.height * np.sqrt(np.maximum(speed, 0.05) / 1.3)
        tempo = np.where(dance, rng.uniform(0.4, 1.1, count), rng.uniform(0.02, 0.1, count))
        turned = np.cumsum(speed / stride + tempo, axis=0) * STEP
        self.phase = first + 2 * np.pi * turned
        gait = np.arcsin(np.clip(stride / (8 * LEG * self.height), 0, 0.8)) * np.minimum(speed / 0.3, 1.0)
        self.legs = gait + np.where(dance, rng.uniform(0.1, 0.35, count), 0.01)
        self.arms = 0.8 * gait + np.where(dance, rng.uniform(0.4, 1.3, count), rng.uniform(0.02, 0.1, count))
        self.raised = np.where(dance, rng.uniform(0.2, 1.6, count), 0.0)
        self.box = np.zeros(self.PARTS * count, bool)
        self.owner = np.tile(np.arange(count), self.PARTS)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        track, h, g = self.track, self.height, self.girth * self.height
        phase = between(self.phase, seconds)
        legs, arms = between(self.legs, seconds), between(self.arms, seconds)
        swings = []
        for side in (1.0, -1.0):
            thigh = legs * stepping(phase + (0.0 if side > 0 else np.pi))
            # The knee gives way while the leg swings forward.
            shank = thigh - (0.05 + 2.0 * legs * np.maximum(side * np.cos(phase), 0.0))
            swings.append((side, thigh, shank))
        # The lower of the two feet is on the floor.
        hip = h * np.maximum.reduce([LEG * (np.cos(a) + np.cos(b)) + ANKLE for _, a, b in swings])
        body = Body(between(track.position, seconds), between(track.heading, seconds))
        up = hip - 0.53 * h

        def solid(ahead: float, above: float, half: tuple[float, float, float]) -> None:
            size = np.column_stack([half[0] * g, half[1] * g, half[2] * h])
            body.put(ahead * h, 0.0, above * h + up, size)

        solid(0.015, 0.932, (0.051, 0.042, 0.068))
        solid(0.0, 0.69, (0.065, 0.115, 0.19))
        solid(0.0, 0.51, (0.06, 0.09, 0.1))
        for side, thigh, shank in swings:
            aside = side * 0.05 * h
            knee = body.bar(0.0, aside, hip, thigh, LEG * h, 0.042 * g)
            ankle = body.bar(knee[0], aside, knee[1], shank, LEG * h, 0.03 * g)
            foot = np.column_stack([0.075 * h, 0.026 * h, 0.02 * h])
            body.put(ankle[0] + 0.03 * h, aside, ankle[1] - 0.02 * h, foot)
            swing = self.raised - side * arms * np.sin(phase)
            elbow = body.bar(0.0, side * 0.125 * h, 0.81 * h + up, swing, 0.17 * h, 0.025 * g)
            fore = swing + 0.25 + 0.4 * arms
            body.bar(elbow[0], side * 0.125 * h, elbow[1], fore, 0.2 * h, 0.02 * g)
        return body.posture(there_at(track.present, seconds))


class Cyclists:
    """People on bicycles: 13 ellipsoids each, two of them wheels."""

    PARTS = 13

    def __init__(self, rng: np.random.Generator, track: Track) -> None:
        count = track.count
        self.track = track
        self.height = heights(rng, count)
        self.lean = rng.uniform(0.1, 0.7, count)
        # One turn of the pedals moves a bicycle on by 4–6 m.
        self.phase = 2 * np.pi * np.cumsum(track.speed(), axis=0) * STEP / rng.uniform(4, 6, count)
        self.box = np.zeros(self.PARTS * count, bool)
        self.owner = np.tile(np.arange(count), self.PARTS)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        h, phase = self.height, between(self.phase, seconds)
        body = Body(between(self.track.position, seconds), between(self.track.heading, seconds))
        wheel = np.array([0.34, 0.025, 0.34])
        body.put(0.52, 0.0, 0.34, wheel)
        body.put(-0.52, 0.0, 0.34, wheel)
        body.put(0.05, 0.0, 0.6, np.array([0.42, 0.03, 0.06]), 0.1)
        body.put(0.48, 0.0, 0.95, np.array([0.06, 0.26, 0.04]))
        saddle = 0.3 + 0.38 * h
        reach = 0.3 * h
        shoulder = -0.2 + np.sin(self.lean) * reach, saddle + np.cos(self.lean) * reach
        trunk = np.column_stack([0.075 * h, 0.11 * h, 0.5 * reach + 0.1 * h])
        body.put((shoulder[0] - 0.2) / 2, 0.0, (shoulder[1] + saddle) / 2, trunk, -self.lean)
        head = np.column_stack([0.055 * h, 0.045 * h, 0.068 * h])
        body.put(shoulder[0] + 0.06 * h, 0.0, shoulder[1] + 0.12 * h, head)
        for side in (1.0, -1.0):
            pedal = 0.05 + 0.17 * np.cos(phase) * side, 0.29 + 0.17 * np.sin(phase) * side
            self._leg(body, side, pedal, saddle)
            down = np.arctan2(0.45 - shoulder[0], shoulder[1] - 0.97)
            length = np.hypot(0.45 - shoulder[0], shoulder[1] - 0.97)
            body.bar(np.zeros_like(phase) + shoulder[0], side * 0.2, shoulder[1], down, length, 0.03 * h)
        body.put(0.05, 0.0, 0.29, np.array([0.1, 0.02, 0.1]))
        return body.posture(there_at(self.track.present, seconds))

    def _leg(self, body: Body, side: float, pedal: tuple[Array, Array], saddle: Array) -> None:
        """Thigh and shank from the hip to a pedal, the knee forward: two circles meet."""
        length = 0.27 * self.height
        ahead, below = pedal[0] + 0.15, saddle - pedal[1]
        far = np.minimum(np.hypot(ahead, below), 1.99 * length)
        straight = np.arctan2(ahead, below)
        opened = np.arccos(far / (2 * length))
        hip = np.full_like(pedal[0], -0.15)
        knee = body.bar(
            hip, side * 0.1, saddle + np.zeros_like(hip), straight + opened, length, 0.05 * self.height
        )
        body.bar(knee[0], side * 0.1, knee[1], straight - opened, length, 0.035 * self.height)


class Cars:
    """Cars and vans: two boxes and four wheels each."""

    PARTS = 6

    def __init__(self, rng: np.random.Generator, track: Track) -> None:
        count = track.count
        self.track = track
        self.length, self.width = rng.uniform(3.6, 5.2, count), rng.uniform(1.6, 2.0, count)
        self.roof, self.hood = rng.uniform(1.4, 2.3, count), rng.uniform(0.75, 1.05, count)
        self.cabin = rng.uniform(0.45, 0.85, count)
        self.box = np.repeat([True, True, False, False, False, False], count)
        self.owner = np.tile(np.arange(count), self.PARTS)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        length, width = self.length, self.width
        body = Body(between(self.track.position, seconds), between(self.track.heading, seconds))
        low = 0.22
        body.put(0.0, 0.0, (low + self.hood) / 2, np.column_stack([length, width, self.hood - low]) / 2)
        top = np.column_stack([self.cabin * length, 0.9 * width, self.roof - self.hood + 0.02]) / 2
        body.put(-0.06 * length, 0.0, (self.roof + self.hood) / 2 - 0.01, top)
        for ahead in (0.3, -0.3):
            for aside in (0.45, -0.45):
                body.put(ahead * length, aside * width, 0.32, np.array([0.32, 0.11, 0.32]))
        return body.posture(there_at(self.track.present, seconds))


class Animals:
    """Animals on four legs, from a dog to a horse: eight ellipsoids each."""

    PARTS = 8

    def __init__(self, rng: np.random.Generator, track: Track) -> None:
        count = track.count
        self.track = track
        self.height = np.exp(rng.uniform(np.log(0.35), np.log(1.6), count))
        self.length, self.girth = rng.uniform(0.45, 0.65, count), rng.uniform(0.16, 0.26, count)
        self.neck = rng.uniform(0.2, 0.6, count)
        speed = track.speed()
        stride = 1.1 * self.height * np.sqrt(np.maximum(speed, 0.05))
        self.phase = (
            rng.uniform(0, 2 * np.pi, count) + 2 * np.pi * np.cumsum(speed / stride + 0.03, axis=0) * STEP
        )
        gait = np.arcsin(np.clip(stride / (4 * 0.55 * self.height), 0, 0.55))
        self.swing = gait * np.minimum(speed / 0.3, 1.0) + 0.02
        self.box = np.zeros(self.PARTS * count, bool)
        self.owner = np.tile(np.arange(count), self.PARTS)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        h, turn = self.height, between(self.swing, seconds) * np.sin(between(self.phase, seconds))
        body = Body(between(self.track.position, seconds), between(self.track.heading, seconds))
        half, thick, rise = self.length * h, self.girth * h, np.sin(self.neck)
        # All four feet on the floor: legs swing by the same angle, in diagonal pairs.
        belly = 0.55 * h * np.cos(turn)
        body.put(0.0, 0.0, belly + 0.75 * thick, np.column_stack([1.15 * half, 0.75 * thick, thick]))
        neck = np.column_stack([0.28 * h, 0.09 * h, 0.1 * h])
        body.put(1.2 * half, 0.0, belly + (0.9 + rise) * thick, neck, self.neck + 0.3)
        head = np.column_stack([0.16 * h, 0.07 * h, 0.08 * h])
        body.put(1.2 * half + 0.3 * h, 0.0, belly + thick + (0.12 + 0.3 * rise) * h, head, -0.3)
        body.bar(-1.05 * half, 0.0, belly + 1.2 * thick, -0.6 + 0.5 * turn, 0.4 * h, 0.025 * h)
        for ahead, aside, sign in ((0.8, 1, 1.0), (0.8, -1, -1.0), (-0.8, 1, -1.0), (-0.8, -1, 1.0)):
            body.bar(ahead * half, aside * 0.5 * thick, belly, sign * turn, 0.55 * h, 0.055 * h)
        return body.posture(there_at(self.track.present, seconds))


class Discs:
    """Low flat things on the floor: an ellipsoid each, some centimetres high."""

    def __init__(
        self, rng: np.random.Generator, track: Track, radius: tuple[float, float], height: tuple[float, float]
    ):
        count = track.count
        self.track = track
        self.half = np.column_stack(
            [rng.uniform(*radius, count), rng.uniform(*radius, count), rng.uniform(*height, count) / 2]
        )
        self.box = rng.random(count) < 0.3
        self.owner = np.arange(count)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        body = Body(between(self.track.position, seconds), between(self.track.heading, seconds))
        body.put(0.0, 0.0, self.half[:, 2], self.half)
        return body.posture(there_at(self.track.present, seconds))
