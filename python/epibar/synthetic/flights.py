"""What does not walk: thrown things, things in one plane, a pendulum and a carousel."""

from __future__ import annotations

import numpy as np

from ..arguments import Array
from .figures import Posture
from .motion import rotations

GRAVITY = 9.81


class Thrown:
    """Balls, boxes and sticks that are thrown again and again: parabolas from 0.5–2 m height to the floor.

    Parameters
    ----------
    rng : Generator
    count : int
    length : float
        Seconds of the world.
    area : (float, float)
        Metres that the throws start on.
    half : (low, high)
        Half-axes, metres.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        count: int,
        length: float,
        area: tuple[float, float],
        half: tuple[float, float] = (0.06, 0.3),
    ) -> None:
        kind = rng.integers(3, size=count)
        size = np.exp(rng.uniform(np.log(half[0]), np.log(half[1]), (count, 1)))
        shape = np.where(kind[:, None] == 2, [0.5, 0.5, 2.5], rng.uniform(0.8, 1.2, (count, 3)))
        self.half = np.where(kind[:, None] == 0, 1.0, shape) * size
        self.box = kind > 0
        self.owner = np.arange(count)
        self.axis = rng.normal(size=(count, 3))
        self.axis /= np.linalg.norm(self.axis, axis=1, keepdims=True)
        self.spin = rng.uniform(0.5, 8.0, count)
        self.throws = [self._throws(rng, length, area) for _ in range(count)]

    def _throws(self, rng: np.random.Generator, length: float, area: tuple[float, float]) -> Array:
        """List the throws of one thing: start, duration, place (3), velocity (3)."""
        now, rows = rng.uniform(-1.0, 2.0), []
        while now < length:
            place = np.append(rng.uniform(-0.5, 0.5, 2) * area, rng.uniform(0.5, 2.0))
            speed, rise = rng.uniform(3.0, 9.0), np.deg2rad(rng.uniform(20.0, 80.0))
            # Towards somewhere on the area, so that it stays about there.
            goal = rng.uniform(-0.5, 0.5, 2) * area
            turn = np.arctan2(*(goal - place[:2])[::-1])
            flat = np.array([np.cos(turn), np.sin(turn)]) * speed * np.cos(rise)
            up = speed * np.sin(rise)
            lasts = (up + np.sqrt(up**2 + 2 * GRAVITY * place[2])) / GRAVITY
            rows.append([now, lasts, *place, *flat, up])
            now += lasts + rng.exponential(0.8) + 0.2
        return np.array(rows)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        count = len(self.owner)
        centres, present = np.zeros((len(seconds), count, 3)), np.zeros((len(seconds), count), bool)
        for thing, throws in enumerate(self.throws):
            row = np.searchsorted(throws[:, 0], seconds, side="right") - 1
            throw = throws[np.maximum(row, 0)]
            since = seconds - throw[:, 0]
            present[:, thing] = (row >= 0) & (since <= throw[:, 1])
            centres[:, thing] = throw[:, 2:5] + since[:, None] * throw[:, 5:]
            centres[:, thing, 2] -= 0.5 * GRAVITY * since**2
        axis = np.broadcast_to(self.axis, (len(seconds), count, 3))
        return Posture(
            centres, rotations(axis, self.spin * seconds[:, None]) * self.half[:, None, :], present
        )


class InOnePlane:
    """Flat things that fly to and fro within a rectangle of one plane, turning in it.

    Parameters
    ----------
    rng : Generator
    count : int
    frame : (3, 3) array
        Two directions in the plane, and its normal, in columns.
    middle : (3,) array
        Of the rectangle, metres.
    reach : (float, float)
        Half of its sides, metres.
    thickness : float
        Of the things, metres.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        count: int,
        frame: Array,
        middle: Array,
        reach: tuple[float, float],
        thickness: float,
    ) -> None:
        self.frame, self.middle, self.reach = frame, middle, np.array(reach)
        self.half = np.column_stack([rng.uniform(0.12, 0.5, (count, 2)), np.full(count, thickness / 2)])
        self.box = rng.random(count) < 0.5
        self.owner = np.arange(count)
        self.start = rng.uniform(0, 4, (count, 2)) * self.reach
        self.velocity = rng.uniform(0.3, 1.5, (count, 2)) * rng.choice([-1, 1], (count, 2))
        self.turn, self.spin = rng.uniform(0, 2 * np.pi, count), rng.normal(0, 0.6, count)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        # To and fro between −reach and reach is a triangle wave of period 4·reach.
        way = np.mod(self.start + seconds[:, None, None] * self.velocity, 4 * self.reach)
        flat = np.where(way < 2 * self.reach, way, 4 * self.reach - way) - self.reach
        angle = self.turn + self.spin * seconds[:, None]
        turned = self.frame @ rotations(np.broadcast_to([0.0, 0.0, 1.0], (*angle.shape, 3)), angle)
        return Posture(
            self.middle + flat @ self.frame[:, :2].T,
            turned * self.half[:, None, :],
            np.ones(angle.shape, bool),
        )


class Pendulum:
    """A ball on a string of 1.5–4 m that swings in a plane, and does not tire."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.string, self.swing = rng.uniform(1.5, 4.0), rng.uniform(0.3, 0.8)
        self.radius = rng.uniform(0.15, 0.45)
        self.first, turn = rng.uniform(0, 2 * np.pi), rng.uniform(-np.pi, np.pi)
        self.across = np.array([np.cos(turn), np.sin(turn), 0.0])
        self.hook = np.array([0.0, 0.0, self.string + self.radius + rng.uniform(0.1, 0.8)])
        self.box, self.owner = np.zeros(1, bool), np.zeros(1, np.int64)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        angle = self.swing * np.sin(self.first + np.sqrt(GRAVITY / self.string) * seconds)
        hangs = np.sin(angle)[:, None] * self.across - np.cos(angle)[:, None] * [0, 0, 1.0]
        centres = (self.hook + self.string * hangs)[:, None]
        axes = np.broadcast_to(self.radius * np.eye(3), (*centres.shape[:2], 3, 3))
        return Posture(centres, axes, np.ones(centres.shape[:2], bool))


class Carousel:
    """Equal seats, evenly on a ring that turns evenly: turned by one seat it looks the same."""

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        self.radius, self.pace = rng.uniform(1.8, 4.0), rng.uniform(0.6, 2.5) * rng.choice([-1, 1])
        self.half = rng.uniform([0.4, 0.2, 0.4], [0.8, 0.35, 0.9])
        self.height = float(self.half[2] + rng.uniform(0.1, 1.0))
        self.places = 2 * np.pi * np.arange(count) / count
        self.box = np.full(count, bool(rng.integers(2)))
        self.owner = np.arange(count)

    def at(self, seconds: Array) -> Posture:
        """Return the solids at K seconds of the world."""
        angle = self.places + self.pace / self.radius * seconds[:, None]
        turned = rotations(np.broadcast_to([0.0, 0.0, 1.0], (*angle.shape, 3)), angle)
        centres = self.radius * turned[..., 0]
        centres[..., 2] = self.height
        # Seats look along the way they go.
        return Posture(centres, turned * self.half[[1, 0, 2]], np.ones(angle.shape, bool))
