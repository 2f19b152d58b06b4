"""Who moves: casts of movers with their habits, each ``cast(rng, count, length, area)``."""

from __future__ import annotations

import numpy as np

from . import tracks
from .figures import Animals, Cars, Cyclists, Movers, Walkers
from .flights import Thrown

Rng = np.random.Generator
Area = tuple[float, float]

ROOM_OF_A_CAR = 60.0
"""Square metres."""

CAR = 4.0
"""Metres that cars keep from the edge of the area, both edges together."""


def walkers(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People on random ways."""
    return [Walkers(rng, tracks.free(rng, count, length, area))]


def two_paths(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People on two paths of 0–1.5 m width that cross at 30–150°."""
    reach, turn = 0.5 * float(np.hypot(*area)), rng.uniform(-np.pi, np.pi)
    first, half = rng.uniform(0.5, 2.6), count // 2
    one = tracks.path(rng, count - half, length, reach, rng.uniform(0, 1.5), direction=turn)
    offset = rng.uniform(-0.15, 0.15) * min(area)
    other = tracks.path(rng, half, length, reach, rng.uniform(0, 1.5), direction=turn + first, offset=offset)
    return [Walkers(rng, one.joined(other))]


def wide_path(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People on one path that is 2–4 m wide."""
    reach = 0.5 * float(np.hypot(*area))
    return [Walkers(rng, tracks.path(rng, count, length, reach, rng.uniform(2.0, 4.0)))]


def queue(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """A queue, and a few who walk about."""
    about = max(1, count // 4)
    line = tracks.queueing(rng, max(count - about, 3), length)
    return [Walkers(rng, line.joined(tracks.free(rng, about, length, area)))]


def pacers(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People who pace to and fro, each on a line of their own."""
    return [Walkers(rng, tracks.pacing(rng, count, length, area))]


def dancers(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People who dance, each on a spot of their own."""
    track = tracks.on_a_spot(rng, count, length, area, (0.1, 0.6), 2.5)
    return [Walkers(rng, track, dance=np.ones(count, bool))]


def passers(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People who come, cross the area and go."""
    table = tracks.timetable(rng, count, length)
    return [Walkers(rng, tracks.coming_and_going(rng, table, length, area))]


def mixed_habits(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """People of two habits, drawn from all."""
    habits = (walkers, two_paths, wide_path, queue, pacers, dancers, passers)
    first, second = rng.choice(len(habits), 2, replace=False)
    part = count // 2
    return [*habits[first](rng, count - part, length, area), *habits[second](rng, max(part, 1), length, area)]


def traffic(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Cyclists and cars, at most one to 60 m², and a walker now and then."""
    cars = int(rng.integers(0, min(count, int(area[0] * area[1] / ROOM_OF_A_CAR)) + 1))
    found: list[Movers] = []
    if cars:
        inner = area[0] - CAR, area[1] - CAR
        found.append(Cars(rng, tracks.free(rng, cars, length, inner, (2.0, 9.0), 0.6, 0.1)))
    if count > cars:
        found.append(Cyclists(rng, tracks.free(rng, count - cars, length, area, (2.0, 6.5), 1.0, 0.1)))
    if rng.random() < 0.5:
        found.append(Walkers(rng, tracks.free(rng, int(rng.integers(1, 4)), length, area)))
    return found


def beasts(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Animals on four legs, with a person in every third."""
    found: list[Movers] = [Animals(rng, tracks.free(rng, count, length, area, (0.4, 3.0), 2.0, 0.4))]
    if rng.random() < 1 / 3:
        found.append(Walkers(rng, tracks.free(rng, 1, length, area)))
    return found


def throwers(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Thrown things, with people who walk about in half of the situations."""
    found: list[Movers] = [Thrown(rng, count, length, area)]
    if rng.random() < 0.5:
        found.append(Walkers(rng, tracks.free(rng, int(rng.integers(1, 4)), length, area)))
    return found


def anything(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Two kinds of movers, drawn from all."""
    kinds = (mixed_habits, traffic, beasts, throwers)
    first, second = rng.choice(len(kinds), 2, replace=False)
    part = count // 2
    return [*kinds[first](rng, count - part, length, area), *kinds[second](rng, max(part, 1), length, area)]
