"""Families of networks without an answer: the motion, or where cameras stand, leaves their geometry open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .camera import Camera
from .networks import NETWORK, another_world
from .settings import draw, stream
from .situations import Fault, Situation
from .unanswerable import (
    PLANE_RIG,
    in_one_plane,
    on_the_floor,
    one_standing,
    path_and_strays,
    path_walkers,
    undetermined,
)

OPEN = replace(NETWORK, cameras=(3, 5), frames=(800, 1500))
ON_PATH = replace(OPEN, movers=path_walkers)


def no_baseline(seed: int, family: str) -> Situation:
    """All cameras within a centimetre, each turned by up to 11°."""
    made, rng = draw(seed, family, OPEN), stream(seed, family, 20)
    first = made.cameras[0]
    far = float(np.linalg.norm(first.centre))
    cameras = [first]
    for camera in made.cameras[1:]:
        away = rng.normal(size=3)
        place = first.centre + away / np.linalg.norm(away) * rng.uniform(0.0005, 0.01)
        aim = first.centre + first.R[2] * far + rng.uniform(-0.12, 0.12, 3) * far
        aimed = Camera.look_at(place, aim, float(camera.K[0, 0]), camera.size, 0.0, camera.name)
        cameras.append(replace(camera, R=aimed.R, t=aimed.t))
    films = [replace(film, camera=camera) for film, camera in zip(made.films, cameras, strict=True)]
    return replace(made, cameras=cameras, films=films, undetermined="no baseline")


def unrelated(seed: int, family: str) -> Situation:
    """Every camera before a motion of its own."""
    made, rng = draw(seed, family, OPEN), stream(seed, family, 20)
    films = [made.films[0], *(replace(film, world=another_world(made, rng, OPEN)) for film in made.films[1:])]
    everyone = tuple(range(len(films)))
    return replace(made, films=films, groups=everyone, faults=(Fault("unrelated", everyone),))


NETWORKS_WITHOUT_ANSWER: dict[str, Callable[[int, str], Situation]] = {
    "network_one_path": undetermined(ON_PATH, "one path"),
    "network_one_path_strays": undetermined(
        replace(ON_PATH, movers=path_and_strays), "one path, a few strays"
    ),
    "network_one_plane": undetermined(
        replace(
            OPEN, movers=in_one_plane, area=((4.0, 8.0), (2.0, 6.0)), rig=replace(PLANE_RIG, one_size=True)
        ),
        "one plane",
    ),
    "network_pure_floor": undetermined(replace(OPEN, movers=on_the_floor), "pure floor"),
    "network_one_mover_standing": undetermined(
        replace(OPEN, movers=one_standing, area=((3.0, 6.0), (3.0, 6.0))), "one mover, standing"
    ),
    "network_no_baseline": no_baseline,
    "network_unrelated": unrelated,
}
