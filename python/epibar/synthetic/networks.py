"""Families of networks: lenses, focal lengths, clocks and poses unknown, and faults that are planted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from . import casts
from .film import Clock, Film
from .made_up_world import MadeUpWorld
from .motion import rotations
from .rigs import FisheyeLenses, Lenses, Rig
from .settings import POINTS, Rng, Setting, draw, ragged, stream, turned, whole
from .situations import Fault, Situation

OFFSET = 20.0
"""Seconds between the first camera to start and the last, at most."""

DRIFT = 20.0
"""Parts per million: standard deviation of a clock's rate."""


def hand_started(rng: Rng, fps: float, frames: int, count: int) -> list[Clock]:
    """Every camera started by hand: 25 or 30 frames a second, within 20 s of each other, for about as long.

    The first camera is the reference: the drift of its clock is 0.
    """
    starts = rng.uniform(0, OFFSET, count)
    rates = rng.choice([25.0, 30.0], count)
    drifts = np.concatenate([[0.0], rng.normal(0, DRIFT, count - 1)])
    seconds = frames / fps
    return [
        Clock(float(start), float(rate), int(seconds * rate * rng.uniform(0.95, 1.05)), float(drift))
        for start, rate, drift in zip(starts, rates, drifts, strict=True)
    ]


SIZES = {(640, 480): 0.4, (720, 576): 0.2, (800, 600): 0.2, (960, 540): 0.2}

NETWORK = Setting(
    casts.mixed_habits,
    count=(3, 12),
    area=((5.0, 12.0), (5.0, 12.0)),
    rig=Rig(
        ("ring", "corners", "row"),
        height=(1.5, 4.0),
        beyond=(1.0, 6.0),
        focal=(0.6, 1.6),
        roll=0.15,
        sizes=SIZES,
        least_seen=0.4,
        least_span=0.35,
        one_size=True,
    ),
    cameras=(3, 8),
    frames=(1500, 3000),
    rates=(25.0,),
    dirt=ragged,
    lenses=Lenses(),
    clocks=hand_started,
    budget=8e9,
)

SETTINGS: dict[str, Setting] = {
    "network": NETWORK,
    "network_off_centre": replace(NETWORK, lenses=Lenses(tangential=3e-4, off_centre=0.02, aspect=0.003)),
    "network_fisheye": replace(NETWORK, lenses=FisheyeLenses()),
    "network_plain": replace(NETWORK, lenses=None, clocks=None, frames=(800, 1500), rates=(7.0, 12.5)),
    "network_large": replace(NETWORK, cameras=(9, 16), frames=(1200, 1800)),
}


def _plain(seed: int, family: str) -> Situation:
    return draw(seed, family, SETTINGS[family])


def _faulty(seed: int, family: str) -> tuple[Situation, int, Rng]:
    """Draw a network of 4–8 cameras, and which of them is to be faulty."""
    made = draw(seed, family, replace(NETWORK, cameras=(4, 8), spare=100.0))
    rng = stream(seed, family, 10)
    return made, int(rng.integers(len(made.cameras))), rng


def _blamed(made: Situation, index: int, film: Film, kind: str, detail: str) -> Situation:
    """Put another film into a network, whose camera then has no answer with the others."""
    films = [film if number == index else other for number, other in enumerate(made.films)]
    groups = tuple(int(number == index) for number in range(len(films)))
    return replace(made, films=films, groups=groups, faults=(Fault(kind, (index,), detail),))


def another_world(made: Situation, rng: Rng, setting: Setting) -> MadeUpWorld:
    """Draw another motion on as much room, which lasts as long."""
    length = max(float(film.moments[-1]) for film in made.films)
    return MadeUpWorld(setting.movers(rng, whole(rng, setting.count), length, made.area))


def stranger(seed: int, family: str) -> Situation:
    """One camera filmed another scene."""
    made, index, rng = _faulty(seed, family)
    film = replace(made.films[index], world=another_world(made, rng, NETWORK))
    return _blamed(made, index, film, "another scene", "")


def backwards(seed: int, family: str) -> Situation:
    """One video runs backwards."""
    made, index, _ = _faulty(seed, family)
    film = made.films[index]
    return _blamed(made, index, replace(film, moments=film.moments[::-1].copy()), "reversed", "")


def shifted(seed: int, family: str) -> Situation:
    """One camera started 60–90 s after what its place in time says; the clocks tell the truth."""
    made, index, rng = _faulty(seed, family)
    late = float(rng.uniform(60.0, 90.0))
    film, clocks = made.films[index], list(made.clocks)
    clocks[index] = replace(clocks[index], start=clocks[index].start + late)
    found = _blamed(made, index, replace(film, moments=film.moments + late), "shifted", f"{late:.1f} s")
    return replace(found, clocks=clocks)


def knocked(seed: int, family: str) -> Situation:
    """One camera was turned by 2–10° at half time."""
    made, index, rng = _faulty(seed, family)
    film, degrees = made.films[index], float(rng.uniform(2.0, 10.0))
    after = turned(film.camera, rng, degrees)
    film = replace(film, knocked=after, knocked_at=len(film.moments) // 2)
    return _blamed(made, index, film, "knocked", f"{degrees:.1f} degrees")


def split(seed: int, family: str) -> Situation:
    """Two groups of cameras that share nothing: each before a scene of its own."""
    made, _, rng = _faulty(seed, family)
    count = len(made.cameras)
    other = another_world(made, rng, NETWORK)
    groups = tuple(int(number >= count // 2) for number in range(count))
    films = [
        replace(film, world=other) if group else film for film, group in zip(made.films, groups, strict=True)
    ]
    fault = Fault("two groups", tuple(number for number in range(count) if groups[number]), "")
    length = max(float(film.moments[-1]) for film in films)
    points = np.concatenate([made.volume_points[::2], other.random_points(rng, length, POINTS // 2)])
    return replace(made, films=films, groups=groups, faults=(fault,), volume_points=points)


def false_pair(seed: int, family: str) -> Situation:
    """Two cameras see more people than the others, 8–14 whom one of the two shows as from elsewhere.

    As a large mirror would: the two agree on a geometry that is not theirs, and that no other pair has. What
    all see is still there, and so is the true geometry.
    """
    made, index, rng = _faulty(seed, family)
    other = int(rng.choice([number for number in range(len(made.cameras)) if number != index]))
    length = max(float(film.moments[-1]) for film in made.films)
    besides = MadeUpWorld(casts.walkers(rng, int(rng.integers(8, 15)), length, made.area))
    films = list(made.films)
    camera = films[other].camera
    # The same camera, a quarter to three quarters of a turn round the middle of the room.
    turn = rotations(np.array([0.0, 0.0, 1.0]), np.array(rng.uniform(np.pi / 2, 3 * np.pi / 2)))
    mirrored = replace(camera, R=camera.R @ turn.T, t=camera.t)
    for number, seen_from in ((index, films[index].camera), (other, mirrored)):
        more = replace(films[number], world=besides, camera=seen_from)
        films[number] = replace(films[number], also=more)
    fault = Fault("false pair", (min(index, other), max(index, other)))
    return replace(made, films=films, faults=(fault,))


NETWORKS: dict[str, Callable[[int, str], Situation]] = {
    **dict.fromkeys(SETTINGS, _plain),
    "network_stranger": stranger,
    "network_reversed": backwards,
    "network_shifted": shifted,
    "network_knocked": knocked,
    "network_split": split,
    "network_false_pair": false_pair,
}
