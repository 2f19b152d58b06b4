"""Habits: how movers go about on a floor. Every number is drawn from the generator that is handed over.

A `Track` holds places and headings every `STEP` seconds from second 0 of the world; between two they change
evenly, so that cameras with any clocks film one and the same world.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Bits

Range = tuple[float, float]

STEP = 0.1
"""Seconds between two samples of a track."""

PACE: Range = (0.7, 1.7)
"""Metres per second, of people who walk."""


@dataclass(frozen=True, eq=False)
class Track:
    """Where N movers are, T samples.

    Attributes
    ----------
    position : (T, N, 2) array
        Metres.
    heading : (T, N) array
        Radians, without jumps.
    present : (T, N) bool array
        Whether the mover is there at all.
    """

    position: Array
    heading: Array
    present: Bits

    @classmethod
    def of(cls, position: Array, heading: Array) -> Track:
        """Make a track of movers who are always there."""
        return cls(position, heading, np.ones(heading.shape, bool))

    @property
    def count(self) -> int:
        """Number of movers."""
        return len(self.heading.T)

    def joined(self, other: Track) -> Track:
        """Put the movers of two tracks into one."""
        return Track(
            np.concatenate([self.position, other.position], axis=1),
            np.concatenate([self.heading, other.heading], axis=1),
            np.concatenate([self.present, other.present], axis=1),
        )

    def speed(self) -> Array:
        """Metres per second at every sample, (T, N), evened out over half a second."""
        moved = np.linalg.norm(np.diff(self.position, axis=0, append=self.position[-1:]), axis=2) / STEP
        moved[-1:] = moved[-2:-1]
        # Where somebody comes or goes the step is a jump.
        there = self.present & np.concatenate([self.present[1:], self.present[-1:]])
        return evened(np.where(there, moved, 0.0), 5)


def evened(values: Array, width: int) -> Array:
    """Running mean along the first axis over an odd number of samples."""
    padded = np.concatenate([np.repeat(values[:1], width // 2 + 1, axis=0), values])
    padded = np.concatenate([padded, np.repeat(values[-1:], width // 2, axis=0)])
    total = np.cumsum(padded, axis=0)
    mean: Array = (total[width:] - total[:-width]) / width
    return mean


def samples(length: float) -> Array:
    """Seconds of the samples of a world of this length, with a little more at its end."""
    return np.arange(int(np.ceil(length / STEP)) + 3, dtype=np.float64) * STEP


def free(
    rng: np.random.Generator,
    count: int,
    length: float,
    area: tuple[float, float],
    pace: Range = PACE,
    turn: float = 1.6,
    pauses: float = 0.2,
) -> Track:
    """Random waypoints on an area about the origin, with steady turning.

    Parameters
    ----------
    length : float
        Seconds.
    area : (float, float)
        Metres along x and y.
    pace : (low, high)
        Metres per second, drawn anew for every way.
    turn : float
        Fastest turning, radians per second.
    pauses : float
        Chance of a pause of 1–4 s at the end of a way.
    """
    half = np.maximum(np.array(area) / 2 - 0.4, 0.1)
    near = max(0.5, 0.6 * pace[1] / turn)
    place, goal = rng.uniform(-1, 1, (2, count, 2)) * half
    facing, wish = rng.uniform(-np.pi, np.pi, count), rng.uniform(*pace, count)
    speed, pause = wish.copy(), np.zeros(count)
    patience = np.full(count, 4 + 2 * float(np.hypot(*area)) / pace[0])
    times = samples(length)
    position, heading = np.empty((len(times), count, 2)), np.empty((len(times), count))
    for index in range(len(times)):
        position[index], heading[index] = place, facing
        toward = goal - place
        error = np.arctan2(toward[:, 1], toward[:, 0]) - facing
        error = (error + np.pi) % (2 * np.pi) - np.pi
        # Slow down in a turn, or a mover circles round a goal that is inside its turning circle.
        wanted = np.where(pause > 0, 0.0, wish * (0.35 + 0.65 * np.maximum(np.cos(error), 0.0)))
        speed += (wanted - speed) * min(1.0, 3.0 * STEP)
        facing = facing + np.clip(2.0 * error, -turn, turn) * np.minimum(1.0, speed / 0.5) * STEP
        place = place + (speed * STEP)[:, None] * np.column_stack([np.cos(facing), np.sin(facing)])
        pause, patience = pause - STEP, patience - STEP
        for mover in np.flatnonzero((np.hypot(*toward.T) < near) | (patience < 0)):
            goal[mover] = rng.uniform(-1, 1, 2) * half
            wish[mover], patience[mover] = rng.uniform(*pace), 4 + 2 * float(np.hypot(*area)) / pace[0]
            if rng.random() < pauses:
                pause[mover] = rng.uniform(1.0, 4.0)
    return Track.of(position, heading)


def wandering(rng: np.random.Generator, count: int, times: Array, period: Range = (3.0, 15.0)) -> Array:
    """Smooth random curves in −1 … 1, (T, count)."""
    periods, phases = rng.uniform(*period, (3, count)), rng.uniform(0, 2 * np.pi, (3, count))
    shares = rng.dirichlet(np.ones(3), count).T
    angle = 2 * np.pi * times[:, None, None] / periods + phases
    curves: Array = (np.sin(angle) * shares).sum(axis=1)
    return curves


def to_and_fro(
    rng: np.random.Generator,
    times: Array,
    start: Array,
    end: Array,
    width: Array | float = 0.0,
    pace: Range = PACE,
    turning: float = 0.8,
) -> Track:
    """Go to and fro between two points each, (N, 2), and across that within a width, metres."""
    count = len(start)
    along = np.maximum(np.linalg.norm(end - start, axis=1), 1e-6)
    speed = rng.uniform(*pace, count)
    way = rng.uniform(0, 2, count) * along + speed * times[:, None]
    leg, rest = np.floor(way / along), np.mod(way, along)
    share = np.where(leg % 2 == 0, rest, along - rest) / along
    direction = (end - start) / along[:, None]
    aside = np.column_stack([-direction[:, 1], direction[:, 0]])
    across = np.asarray(width) / 2 * wandering(rng, count, times)
    position = start + share[..., None] * (end - start) + across[..., None] * aside
    # Half a turn at each end, over `turning` seconds: before and after the end alike.
    ahead = np.clip(0.5 - (along - rest) / speed / turning, 0, 0.5)
    behind = np.clip(0.5 - rest / speed / turning, 0, 0.5)
    heading = np.arctan2(direction[:, 1], direction[:, 0]) + np.pi * (leg + ahead - behind)
    return Track.of(position, heading)


def path(
    rng: np.random.Generator,
    count: int,
    length: float,
    reach: float,
    width: float,
    pace: Range = PACE,
    direction: float | None = None,
    offset: float = 0.0,
) -> Track:
    """Everybody to and fro on one straight path of some width and 2 · reach metres length, past the origin.

    ``offset`` is how far the path passes from the origin, and its direction is drawn where it is not given.
    """
    turn = rng.uniform(-np.pi, np.pi) if direction is None else direction
    along = np.array([np.cos(turn), np.sin(turn)])
    middle = offset * np.array([-along[1], along[0]])
    ends = (
        np.broadcast_to(middle - reach * along, (count, 2)),
        np.broadcast_to(middle + reach * along, (count, 2)),
    )
    return to_and_fro(rng, samples(length), *ends, width, pace)


def pacing(rng: np.random.Generator, count: int, length: float, area: tuple[float, float]) -> Track:
    """Everybody to and fro on a line of 1.5–5 m of their own, somewhere on the area."""
    middle = rng.uniform(-0.5, 0.5, (count, 2)) * np.array(area) * 0.8
    turn, reach = rng.uniform(-np.pi, np.pi, count), rng.uniform(0.75, 2.5, count)
    half = reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return to_and_fro(rng, samples(length), middle - half, middle + half, 0.3)


def on_a_spot(
    rng: np.random.Generator, count: int, length: float, area: tuple[float, float], sway: Range, turn: float
) -> Track:
    """Everybody near a spot of their own: swaying by some metres, turning by up to some radians."""
    times = samples(length)
    spots = rng.uniform(-0.5, 0.5, (count, 2)) * np.array(area) * 0.9
    reach = rng.uniform(*sway, count)
    moved = np.stack([wandering(rng, count, times, (1.0, 4.0)) for _ in range(2)], axis=2)
    heading = rng.uniform(-np.pi, np.pi, count) + turn * wandering(rng, count, times, (2.0, 9.0))
    return Track.of(spots + moved * reach[:, None], heading)


def queueing(rng: np.random.Generator, count: int, length: float) -> Track:
    """A queue: now and then the first leaves and lines up at the end again, and all others step forward."""
    times = samples(length)
    spacing, turn = rng.uniform(0.6, 1.0), rng.uniform(-np.pi, np.pi)
    along = np.array([np.cos(turn), np.sin(turn)])
    aside = np.array([-along[1], along[0]]) * rng.choice([-1, 1])
    bend = rng.uniform(-0.6, 0.6)
    slots = np.arange(count) * spacing
    # A line that bends a little, its middle at the origin.
    places = slots[:, None] * along + (bend * (slots / max(slots[-1], 1.0)) ** 2 * slots)[:, None] * aside
    places = places - places.mean(axis=0)
    wait = rng.uniform(2.0, 7.0)
    slot, place = np.arange(count), places.copy()
    facing = np.full(count, turn + np.pi)
    ways: list[list[Array]] = [[] for _ in range(count)]
    pace, delay = rng.uniform(0.9, 1.5, count), np.zeros(count)
    following = rng.exponential(wait)
    position, heading = np.empty((len(times), count, 2)), np.empty((len(times), count))
    for index, now in enumerate(times):
        position[index], heading[index] = place, facing
        if now >= following:
            following = now + max(1.5, rng.exponential(wait))
            first = int(np.argmin(slot))
            slot -= 1
            slot[first] = count - 1
            delay = 0.25 * slot + rng.uniform(0, 0.3, count)
            out = rng.uniform(1.0, 2.5) * aside
            ways[first] = [places[0] + out - along, places[-1] + out + along]
        delay = delay - STEP
        goal = np.array([ways[i][0] if ways[i] else places[slot[i]] for i in range(count)])
        toward = goal - place
        distance = np.hypot(*toward.T)
        for mover in np.flatnonzero(distance < 0.2):
            if ways[mover]:
                ways[mover].pop(0)
        goes = np.where((distance > 0.04) & (delay <= 0), np.minimum(pace, 1.5 * distance + 0.1), 0.0)
        place = place + toward / np.maximum(distance, 1e-9)[:, None] * (goes * STEP)[:, None]
        wish = np.where(goes > 0.3, np.arctan2(toward[:, 1], toward[:, 0]), turn + np.pi)
        error = (wish - facing + np.pi) % (2 * np.pi) - np.pi
        facing = facing + np.clip(3.0 * error, -3, 3) * STEP
    return Track.of(position, heading)


def timetable(rng: np.random.Generator, count: int, length: float) -> list[list[tuple[float, float]]]:
    """When each of some movers comes and goes: lists of first and last second."""
    table = []
    for _ in range(count):
        now, visits = rng.uniform(-8.0, 12.0), []
        while now < length:
            stay = rng.uniform(5.0, 20.0)
            visits.append((now, now + stay))
            now += stay + rng.exponential(8.0) + 1.0
        table.append(visits)
    return table


def visits(track: Track) -> list[list[tuple[float, float]]]:
    """When each of the movers of a track was there, as a `timetable`."""
    table = []
    for there in track.present.T:
        edges = np.flatnonzero(np.diff(there.astype(np.int8), prepend=0, append=0)) * STEP
        table.append([(float(first), float(last) - STEP) for first, last in edges.reshape(-1, 2)])
    return table


def one_way(
    rng: np.random.Generator,
    count: int,
    length: float,
    area: tuple[float, float],
    pace: float,
    spread: float,
) -> Track:
    """Cross the area along x, in a lane and at a speed drawn anew each time, leave, and come in again later.

    Parameters
    ----------
    pace : float
        Metres per second.
    spread : float
        Standard deviation of a speed, as a share of it.
    """
    times = samples(length)
    reach = area[0] + 2.0
    position = np.zeros((len(times), count, 2))
    present = np.zeros((len(times), count), bool)
    for mover in range(count):
        first = -rng.uniform(0, reach / pace)
        while first < length:
            speed, lane = pace * (1 + spread * rng.normal()), rng.uniform(-0.5, 0.5) * area[1]
            there = (times >= first) & (times <= first + reach / speed)
            position[there, mover, 0] = speed * (times[there] - first) - reach / 2
            position[there, mover, 1] = lane
            present[there, mover] = True
            first += reach / speed + 2 * STEP + rng.exponential(0.5 * reach / pace)
    return Track(position, np.zeros((len(times), count)), present)


def coming_and_going(
    rng: np.random.Generator,
    table: list[list[tuple[float, float]]],
    length: float,
    area: tuple[float, float],
) -> Track:
    """Come in from one side at the times of a table, cross the area along a bow, and leave."""
    times = samples(length)
    half = np.array(area) / 2 + 1.0
    position = np.zeros((len(times), len(table), 2))
    heading = np.zeros((len(times), len(table)))
    present = np.zeros((len(times), len(table)), bool)

    def edge() -> Array:
        point = rng.uniform(-1, 1, 2) * half
        side = rng.integers(2)
        point[side] = rng.choice([-1, 1]) * half[side]
        return point

    for mover, visits in enumerate(table):
        for first, last in visits:
            start, end = edge(), edge()
            while np.hypot(*(end - start)) < 0.6 * half.min():
                end = edge()
            bow = 0.25 * rng.uniform(-1, 1) * np.array([-(end - start)[1], (end - start)[0]])
            there = np.flatnonzero((times >= first) & (times <= last))
            share = ((times[there] - first) / (last - first))[:, None]
            position[there, mover] = start + share * (end - start) + 4 * share * (1 - share) * bow
            way = (end - start) + 4 * (1 - 2 * share) * bow
            heading[there, mover] = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
            present[there, mover] = True
    return Track(position, heading, present)
