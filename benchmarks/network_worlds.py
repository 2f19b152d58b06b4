"""Vertical, floor and metres of made-up networks beside the truth, and whether what is stated holds."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from tables import table

import epibar
from epibar import synthetic
from epibar.network.metres import NINE_IN_TEN
from epibar.synthetic.figures import MEAN_HEIGHT
from epibar.synthetic.settings import stream

LENGTH, MEASURED = 5.0, 0.01
"""Of the distances between two cameras the nearest to so many metres is told; its standard error, metres."""

STREAM = 90
"""Number of the random stream of a situation that the error of its measured distance is drawn from."""


def world(situation: Any, network: Any) -> dict[str, Any] | None:
    """Errors of a network's world and those stated; None where fewer than two cameras are accepted."""
    found = synthetic.accepted_cameras(network)
    if len(found) < 2:
        return None
    wrong, ground = synthetic.world_error(situation, found), network.ground
    outcome: dict[str, Any] = {"source": ground.source}
    if ground.source == "floor":
        outcome |= {"vertical": wrong.vertical, "vertical_error": ground.vertical_error}
        level_error = (ground.level_error or 0.0) * wrong.unit
        outcome |= {"floor": wrong.floor, "level_error": level_error}
        outcome["people"] = scale(network, wrong.unit, person_height=MEAN_HEIGHT)
    one, other, apart = measured_distance(situation, list(found))
    outcome["apart"] = apart
    outcome["distance"] = scale(network, wrong.unit, distance=(one, other, apart, MEASURED))
    return outcome


def measured_distance(situation: Any, names: list[str]) -> tuple[str, str, float]:
    """Two of some cameras, those nearest to :data:`LENGTH` apart, and what was measured between them, metres.

    The same situation is measured with the same error each time.
    """
    centres = {camera.name: camera.centre for camera in situation.cameras}
    apart = {
        pair: float(np.linalg.norm(centres[pair[0]] - centres[pair[1]])) for pair in combinations(names, 2)
    }
    one, other = min(apart, key=lambda pair: abs(apart[pair] - LENGTH))
    error = stream(situation.seed, situation.family, STREAM).normal(0.0, MEASURED)
    return one, other, apart[one, other] + float(error)


def scale(network: Any, unit: float, **known: Any) -> list[float] | str:
    """Relative error of the metres by some length and the one stated, or why there are none."""
    try:
        metres = network.scaled(**known)
    except epibar.EpibarError as error:
        return str(error)
    first, second = [name for name, camera in network.cameras.items() if camera.accepted][:2]
    before, after = (
        np.linalg.norm(net.cameras[first].position - net.cameras[second].position)
        for net in (network, metres)
    )
    return [abs(float(after / before) / unit - 1), metres.scale.error]


HEAD = (
    *("family", "networks with a floor", "vertical °, median, 90 %", "stated, median", "within, %"),
    *("floor cm, median, 90 %", "stated, median", "within, %"),
    *("metres from people, %, median, 90 %", "stated, median", "within, %"),
    *("refused", "told a distance of m, median", "from it, %, median, 90 %", "stated, median", "within, %"),
)


def row(family: str, worlds: list[dict[str, Any]]) -> list[str]:
    """One family in a row of the table."""
    floors = [one for one in worlds if one["source"] == "floor"]
    people = [one["people"] for one in floors]
    return [
        family,
        f"{len(floors)} of {len(worlds)}",
        *beside([[one["vertical"], NINE_IN_TEN * one["vertical_error"]] for one in floors], 1),
        *beside([[one["floor"], NINE_IN_TEN * one["level_error"]] for one in floors], 100),
        *beside([one for one in people if not isinstance(one, str)], 100),
        str(sum(isinstance(one, str) for one in people)),
        f"{np.median([one['apart'] for one in worlds]):.1f}",
        *beside([one["distance"] for one in worlds if not isinstance(one["distance"], str)], 100),
    ]


def beside(pairs: list[list[float]], unit: float) -> list[str]:
    """Errors, those stated, and how many hold."""
    if not pairs:
        return ["-"] * 3
    true, stated = np.array(pairs).T
    holds = f"{100 * (true <= stated).mean():.0f}"
    return [spread(list(true), unit), f"{unit * np.median(stated):.2f}", holds]


def spread(values: list[float], unit: float) -> str:
    """Median and what nine in ten are below."""
    return f"{unit * np.median(values):.2f}, {unit * np.quantile(values, 0.9):.2f}" if values else "-"


def worlds_table(outcomes: list[dict[str, Any]]) -> str:
    """Worlds of all families."""
    worlds: dict[str, list[dict[str, Any]]] = {}
    for outcome in outcomes:
        if outcome["world"]:
            worlds.setdefault(outcome["family"], []).append(outcome["world"])
    return table(HEAD, [row(*of_family) for of_family in worlds.items()])
