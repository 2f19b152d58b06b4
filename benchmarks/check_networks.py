"""Made-up networks that ``check.py`` and ``added.py`` film anew: drawn, recorded, calibrated."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from networks import distortions

FPS = 6.25
CALIBRATED, CHECKED = 1000, 375
"""Frames that a network is made of, and of a minute that is held against it."""

SIZE = (640, 480)
PAUSE = 125
"""Frames between two stretches of film."""


def situation(seed: int, count: int, minutes: int) -> Any:
    """Draw cameras with their lenses before walkers, for as long as all films together."""
    from epibar.synthetic.networks import NETWORK
    from epibar.synthetic.settings import draw

    frames = CALIBRATED + minutes * (PAUSE + CHECKED)
    setting = replace(
        NETWORK,
        cameras=(count, count),
        frames=(frames, frames),
        rates=(FPS,),
        seconds=(0.0, 1e6),
        clocks=None,
        budget=1e12,
        rig=replace(NETWORK.rig, sizes={SIZE: 1.0}),
    )
    return draw(seed, f"check {count}", setting)


def recorded(film: Any, first: int, last: int, seed: int, lines: int) -> Any:
    """Record some frames of a film."""
    from epibar.recording import MIN_COMPONENT_AREA, Recording, new_recorder

    recorder = new_recorder(*film.camera.size, lines, seed, MIN_COMPONENT_AREA)
    for frame, mask in enumerate(film.iter_masks(first, last)):
        recorder.push(np.ascontiguousarray(mask), frame / FPS)
    return Recording(recorder.finish(), name=film.camera.name)


def true_network(made: Any) -> Any:
    """The true cameras as a network, in metres."""
    import epibar
    from epibar.network import Ground, NetworkCamera, NetworkClock, NetworkPair
    from epibar.network.parts import METRE, NetworkPairs

    nothing = {"focal": 0.0, "rotation": 0.0, "position": 0.0}
    cameras = {
        c.name: NetworkCamera(
            *(c.name, c.size, True, "accepted", "true", c.K),
            *(distortions(c), c.R, c.t, nothing),
        )
        for c in made.cameras
    }
    pairs = [
        NetworkPair(made.names[a], made.names[b], True, "confirmed", made.fundamental(a, b))
        for a, b in made.pairs()
    ]
    clocks = {name: NetworkClock(0.0, 0.0, 0.0) for name in cameras}
    return epibar.Network(
        cameras, NetworkPairs(pairs), clocks, True, "the true one", METRE, Ground("floor"), 1.0
    )


def calibrated_network(made: Any, lines: int) -> Any:
    """What is made of the first frames, nothing known of the cameras but the geometry of pairs."""
    films = {
        film.camera.name: recorded(film, 0, CALIBRATED, 7 * k, lines) for k, film in enumerate(made.films)
    }
    return joined(made, films)


def joined(made: Any, films: Any) -> Any:
    """Calibrate a network: cameras that filmed together, and of which the geometry of pairs is true.

    ``films`` are recordings by the names of the cameras, in the order of ``made``, which holds what is
    true of these.
    """
    from epibar import _core
    from epibar.network.core_result import network_of
    from epibar.network.knowledge import knowledge_of

    pairs = [
        {
            "a": a,
            "b": b,
            "geometries": [(made.fundamental(a, b).tolist(), 1.0)],
            "offset": 0.0,
            "frames_per_frame": 1.0,
            "z": 10.0,
            "accepted": True,
        }
        for a, b in made.pairs()
    ]
    cores = [one._core for one in films.values()]
    clocks = ([0.0] * len(films), False, True)
    found = _core.join_network(cores, list(films), knowledge_of(films, None), pairs, clocks, None)
    return network_of(found, films)
