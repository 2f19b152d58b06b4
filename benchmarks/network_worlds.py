"""Vertical, floor and metres of made-up networks beside the truth, and whether what is stated holds."""

from __future__ import annotations

from typing import Any

import numpy as np
from tables import table

import epibar
from epibar import synthetic
from epibar.network.metres import NINE_IN_TEN
from epibar.synthetic.figures import MEAN_HEIGHT

MEASURED = 0.01
"""A distance between two cameras is measured to so many metres."""


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
    one, other = list(found)[:2]
    true = {camera.name: camera.centre for camera in situation.cameras}
    apart = float(np.linalg.norm(true[one] - true[other]))
    outcome["distance"] = scale(network, wrong.unit, distance=(one, other, apart, MEASURED))
    return outcome


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
    *("refused", "from a distance, %, median, 90 %", "stated, median", "within, %"),
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
