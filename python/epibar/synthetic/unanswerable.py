"""Families of pairs that have no answer: what each camera filmed, or what moved, determines no geometry.

Either the two films have nothing to do with each other, so that any F is wrong, or they have, and the motion
leaves F open: then there is a true F, which the motion does not tell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..arguments import Bits
from . import casts, tracks
from .camera import Camera
from .dirt import Dirt
from .figures import Discs, Movers, Walkers
from .film import Film, Lights
from .flights import Carousel, InOnePlane, Pendulum
from .made_up_world import MadeUpWorld
from .motion import rotations
from .networks import hand_started
from .rigs import Rig
from .settings import Area, Rng, Setting, draw, ragged, stream, turned, whole
from .situations import Fault, Situation
from .tracks import Track

PAIR = Setting(casts.anything, cameras=(2, 2), frames=(200, 1500), dirt=ragged)
SEARCHED = 21.0
"""Seconds either way that a search for the offset looks, unless told."""

FLASHES = 0.06
"""Share of frames in which a lamp, or the light of the room, is on."""


# --- two films that have nothing to do with each other ---


def _parted(made: Situation, film: Film, kind: str, detail: str = "") -> Situation:
    """Put another film into the second camera's place, which then has nothing to do with the first."""
    fault = Fault(kind, (1,), detail)
    return replace(made, films=[made.films[0], film], groups=(0, 1), faults=(fault,))


def _elsewhere(seed: int, family: str, made: Situation) -> MadeUpWorld:
    """Draw what moves in another place, on as much room."""
    rng = stream(seed, family, 20)
    length = max(float(film.moments[-1]) for film in made.films)
    return MadeUpWorld(PAIR.movers(rng, whole(rng, PAIR.count), length, made.area))


def unrelated(seed: int, family: str) -> Situation:
    """Two cameras, each before a motion of its own."""
    made = draw(seed, family, PAIR)
    film = replace(made.films[1], world=_elsewhere(seed, family, made))
    return _parted(made, film, "unrelated")


def reversed_time(seed: int, family: str) -> Situation:
    """One video runs backwards."""
    made = draw(seed, family, PAIR)
    film = made.films[1]
    return _parted(made, replace(film, moments=film.moments[::-1].copy()), "reversed")


def shifted(seed: int, family: str) -> Situation:
    """One camera started 25–120 s later than it says, which is more than a search looks for."""
    late = float(stream(seed, family, 20).uniform(SEARCHED + 4.0, 120.0))
    made = draw(seed, family, replace(PAIR, spare=late))
    film = made.films[1]
    return _parted(made, replace(film, moments=film.moments + late), "shifted", f"{late:.1f} s")


def camera_moved(seed: int, family: str) -> Situation:
    """One camera was turned by 1–15° at half time."""
    rng, made = stream(seed, family, 20), draw(seed, family, PAIR)
    film, degrees = made.films[1], float(rng.uniform(1.0, 15.0))
    film = replace(film, knocked=turned(film.camera, rng, degrees), knocked_at=len(film.moments) // 2)
    return _parted(made, film, "moved at half time", f"{degrees:.1f} degrees")


def mirrored(seed: int, family: str) -> Situation:
    """One video has left and right changed about.

    Its pixels have an F with those of the other, as of a camera that cannot exist.
    """
    made = draw(seed, family, PAIR)
    return _parted(made, replace(made.films[1], mirrored=True), "mirrored")


def same_timetable(seed: int, family: str) -> Situation:
    """Two rooms, in which people come and go at the same times on ways of their own."""
    setting = replace(PAIR, movers=casts.passers, count=(2, 10))
    made = draw(seed, family, setting)
    rng = stream(seed, family, 20)
    length = max(float(film.moments[-1]) for film in made.films)
    (people,) = made.films[0].world.movers
    assert isinstance(people, Walkers)
    table = tracks.visits(people.track)
    world = MadeUpWorld([Walkers(rng, tracks.coming_and_going(rng, table, length, made.area))])
    return _parted(made, replace(made.films[1], world=world), "another room, the same timetable")


def _flashing(rng: Rng, frames: int, count: int) -> Bits:
    """When things flash, (frames, count): in 6 % of the frames, for 1–5 frames on end."""
    lasts = int(rng.integers(1, 6))
    starts = rng.random((frames, count)) < FLASHES / lasts
    on = starts.copy()
    for late in range(1, lasts):
        on[late:] |= starts[:-late]
    return on


def lights(seed: int, family: str) -> Situation:
    """Motion of its own in each, and a light of the room that floods both images, mostly together."""
    rng, made = stream(seed, family, 21), unrelated(seed, family)
    together, frames = rng.random() < 0.8, made.clocks[0].frames
    flashes = [_flashing(rng, frames, 1)[:, 0] for _ in range(2)]
    nothing = np.empty((0, 3)), np.empty((frames, 0), bool)
    films = [
        replace(film, lights=Lights(*nothing, flashes[0 if together else index]))
        for index, film in enumerate(made.films)
    ]
    fault = Fault("unrelated, room light", (1,), "in step" if together else "")
    return replace(made, films=films, faults=(fault,))


def lamps(seed: int, family: str) -> Situation:
    """3–10 lamps blink in each, mostly at the same times, at places that no geometry relates."""
    rng, made = stream(seed, family, 21), draw(seed, family, PAIR)
    together, frames, count = rng.random() < 0.8, made.clocks[0].frames, int(rng.integers(3, 11))
    flashes = [_flashing(rng, frames, count) for _ in range(2)]
    films = []
    for index, film in enumerate(made.films):
        places = rng.uniform([0.08, 0.08], [0.92, 0.92], (count, 2)) * film.camera.size
        radius = rng.uniform(0.01, 0.06, (count, 1)) * film.camera.size[0]
        on = Lights(np.hstack([places, radius]), flashes[0 if together else index], np.zeros(frames, bool))
        films.append(replace(film, world=MadeUpWorld([]), dirt=None, cleaned=False, lights=on))
    fault = Fault("lamps", (1,), "in step" if together else "")
    return replace(made, films=films, groups=(0, 1), faults=(fault,))


def noise(seed: int, family: str) -> Situation:
    """Nothing but false blobs, other ones in each."""
    rng, made = stream(seed, family, 21), draw(seed, family, PAIR)
    low = rng.uniform(2, 10)
    dirt = Dirt(rng.uniform(1, 10), (low, rng.uniform(1.5, 5) * low), 0.0, 1, 0.0, missed=0.0)
    films = [replace(film, world=MadeUpWorld([]), dirt=dirt, cleaned=False) for film in made.films]
    return replace(made, films=films, groups=(0, 1), faults=(Fault("noise", (0, 1)),))


# --- motion that leaves the geometry open ---


def undetermined(setting: Setting, reason: str) -> Callable[[int, str], Situation]:
    """Make a family of which the motion leaves the geometry open."""

    def make(seed: int, family: str) -> Situation:
        return replace(draw(seed, family, setting), undetermined=reason)

    return make


def path_walkers(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Everybody on one straight path, up to a metre wide."""
    reach, offset = 0.5 * float(np.hypot(*area)), rng.uniform(-0.25, 0.25) * min(area)
    track = tracks.path(rng, count, length, reach, rng.uniform(0.0, 1.0), offset=offset)
    return [Walkers(rng, track)]


def path_and_strays(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """As `path_walkers`, and one or two who cross elsewhere, once each, for 2–6 s."""
    found = path_walkers(rng, count, length, area)
    strays = tracks.free(rng, int(rng.integers(1, 3)), length, area, pauses=0.0)
    times = np.arange(len(strays.heading)) * tracks.STEP
    first = rng.uniform(0, max(length - 6.0, 1.0), strays.count)
    present = (times[:, None] >= first) & (times[:, None] <= first + rng.uniform(2.0, 6.0, strays.count))
    return [*found, Walkers(rng, Track(strays.position, strays.heading, present))]


def one_way(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """All walk one way, at 1–1.7 m/s, and at that speed to within 0–3 %."""
    return [
        Walkers(rng, tracks.one_way(rng, count, length, area, rng.uniform(1.0, 1.7), rng.uniform(0, 0.03)))
    ]


def in_one_plane(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Flat things in one plane: upright, leaning, or level at the height of a table."""
    level = rng.random() < 0.25
    lean = np.pi / 2 if level else rng.uniform(-0.6, 0.6) * rng.integers(2)
    turn = rng.uniform(-0.4, 0.4)
    frame = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, 1.0, 0]])
    frame = rotations(np.array([1.0, 0, 0]), np.array(lean)) @ frame
    frame = rotations(np.array([0, 0, 1.0]), np.array(turn)) @ frame
    reach = rng.uniform(1.5, 4.0), rng.uniform(0.8, 2.5)
    height = rng.uniform(0.5, 1.0) if level else reach[1] * abs(np.cos(lean)) + rng.uniform(0.3, 1.0)
    thickness = rng.uniform(0.0, 0.03)
    return [InOnePlane(rng, count, frame, np.array([0.0, 0.0, height]), reach, thickness)]


def on_the_floor(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """Low flat things, 1–8 cm high."""
    high = rng.uniform(0.01, 0.08)
    track = tracks.free(rng, count, length, area, (0.2, 1.5), 2.0)
    return [Discs(rng, track, (0.08, 0.5), (0.5 * high, high))]


def one_standing(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """One who stands, and may wave."""
    track = tracks.on_a_spot(rng, 1, length, (1.0, 1.0), (0.0, 0.1), rng.uniform(0.0, 0.5))
    return [Walkers(rng, track, dance=rng.random(1) < 0.5)]


def marching(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """An endless column of equal people in step along x: moved by one place it looks the same."""
    gap, pace, rows = rng.uniform(1.0, 2.0), rng.uniform(0.8, 1.6), int(rng.integers(1, 3))
    times, number = tracks.samples(length), int(36.0 / gap)
    long = number * gap
    along = (np.arange(number) * gap + pace * times[:, None]) % long - long / 2
    sides = np.repeat((np.arange(rows) - (rows - 1) / 2) * rng.uniform(0.8, 1.5), number)
    x = np.tile(along, (1, rows))
    position = np.stack([x, np.broadcast_to(sides, x.shape)], axis=2)
    # Where one starts anew at the other end nobody looks.
    track = Track(position, np.zeros(x.shape), np.abs(x) < long / 2 - 3 * pace * tracks.STEP)
    return [Walkers(rng, track, alike=True)]


def swinging(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """One pendulum."""
    return [Pendulum(rng)]


def going_round(rng: Rng, count: int, length: float, area: Area) -> list[Movers]:
    """A carousel of 4–12 equal seats."""
    return [Carousel(rng, int(rng.integers(4, 13)))]


REPEATED = {
    "marching": replace(
        PAIR,
        movers=marching,
        frames=(200, 500),
        area=((6.0, 9.0), (2.0, 3.0)),
        rig=Rig(("beside",), (1.2, 4.0), (4.0, 8.0), (1.0, 2.0), roll=0.1, least_seen=0.02),
    ),
    "pendulum": replace(PAIR, movers=swinging, area=((4.0, 6.0), (4.0, 6.0))),
    "carousel": replace(PAIR, movers=going_round, area=((8.0, 10.0), (8.0, 10.0))),
}


def repeated_pattern(seed: int, family: str) -> Situation:
    """A column that marches, a pendulum or a carousel."""
    kind = str(stream(seed, family, 20).choice(list(REPEATED)))
    return replace(draw(seed, family, REPEATED[kind]), undetermined=kind)


def no_baseline(seed: int, family: str) -> Situation:
    """Two cameras within a centimetre, the second turned and zoomed.

    Every F of the family [e]×H fits, all points of the room too, so that no error tells a wrong one.
    """
    made, rng = draw(seed, family, PAIR), stream(seed, family, 20)
    first, size = made.cameras[0], made.cameras[1].size
    far = float(np.linalg.norm(first.centre))
    aim = first.centre + first.R[2] * far + rng.uniform(-0.08, 0.08, 3) * far
    away = rng.normal(size=3)
    place = first.centre + away / np.linalg.norm(away) * rng.uniform(0.0005, 0.01)
    focal = float(first.K[0, 0]) / first.size[0] * size[0] * rng.uniform(0.75, 1.3)
    second = Camera.look_at(place, aim, focal, size, float(np.rad2deg(rng.uniform(-0.2, 0.2))), "cam02")
    found = _parted(made, replace(made.films[1], camera=second), "no baseline")
    return replace(found, cameras=[first, second])


PATH = replace(PAIR, movers=path_walkers)
ONE_WAY = replace(
    PAIR,
    movers=one_way,
    count=(4, 14),
    area=((8.0, 14.0), (2.0, 5.0)),
    clocks=hand_started,
    frames=(600, 1500),
    rates=(25.0,),
)
PLANE_RIG = Rig(("before",), (0.8, 5.0), (4.0, 12.0), roll=0.2)

WITHOUT_ANSWER: dict[str, Callable[[int, str], Situation]] = {
    "unrelated": unrelated,
    "reversed": reversed_time,
    "shifted": shifted,
    "one_path": undetermined(PATH, "one path"),
    "one_path_strays": undetermined(replace(PATH, movers=path_and_strays), "one path, a few strays"),
    "one_way": undetermined(ONE_WAY, "one way at one speed, and nobody knows when"),
    "one_plane": undetermined(
        replace(PAIR, movers=in_one_plane, area=((4.0, 8.0), (2.0, 6.0)), rig=PLANE_RIG), "one plane"
    ),
    "pure_floor": undetermined(
        replace(PAIR, movers=on_the_floor, area=((4.0, 10.0), (4.0, 10.0))), "pure floor"
    ),
    "no_baseline": no_baseline,
    "one_mover_standing": undetermined(
        replace(PAIR, movers=one_standing, area=((3.0, 6.0), (3.0, 6.0))), "one mover, standing"
    ),
    "lamps": lamps,
    "lights": lights,
    "noise": noise,
    "repeated_pattern": repeated_pattern,
    "camera_moved": camera_moved,
    "mirrored": mirrored,
    "same_timetable": same_timetable,
}
