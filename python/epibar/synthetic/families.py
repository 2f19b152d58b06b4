"""Families of situations by name, and `situation`, which draws one.

`benchmarks/README.md` has them in a table.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from . import casts, networks
from .open_networks import NETWORKS_WITHOUT_ANSWER
from .rigs import Rig
from .settings import Setting, dirty, draw, ragged
from .situations import Situation
from .unanswerable import WITHOUT_ANSWER

LOW_SIZES = ((720, 576), (640, 480))

LOW = Setting(
    casts.walkers,
    count=(6, 6),
    area=((14.0, 14.0), (10.0, 10.0)),
    rig=Rig(("circle",), (1.5, 2.2), (14.0, 20.0), focal_px=(700.0, 1000.0), roll=0.15, sizes=LOW_SIZES),
    cameras=(4, 4),
    frames=(800, 800),
    rates=(7.0,),
)
"""Six walkers in a circle of cameras that stand as high as their heads, 14–20 m from the middle."""

GENERAL = Setting(casts.mixed_habits, dirt=ragged)
LOW_RIG = Rig(height=(1.2, 2.4), roll=0.25)
ROAD = ((18.0, 40.0), (12.0, 30.0))

WITH_ANSWER: dict[str, Setting] = {
    "low": LOW,
    "low_wide": replace(GENERAL, movers=casts.walkers, count=(3, 12), rig=LOW_RIG),
    "high": replace(GENERAL, movers=casts.walkers, rig=Rig(height=(2.4, 8.0))),
    "mixed": replace(GENERAL, movers=casts.anything, strangers=0.3, furniture=0.3),
    "crowd": replace(GENERAL, count=(16, 30), area=((8.0, 18.0), (8.0, 18.0)), cameras=(2, 5)),
    "few": replace(GENERAL, movers=casts.walkers, count=(1, 2)),
    "cyclists_and_cars": replace(GENERAL, movers=casts.traffic, area=ROAD, count=(2, 8)),
    "animals": replace(GENERAL, movers=casts.beasts, count=(1, 10)),
    "thrown": replace(GENERAL, movers=casts.throwers, count=(2, 10), area=((4.0, 10.0), (4.0, 10.0))),
    "dirty": replace(GENERAL, dirt=dirty, strangers=0.3, furniture=0.3),
    "boxes": replace(GENERAL, dirt=None, outlines="boxes", jitter=(0.0, 0.03)),
    "ellipses": replace(GENERAL, dirt=None, outlines="ellipses", jitter=(0.0, 0.03)),
    "shadows": replace(GENERAL, shadows=1.0),
    "short": replace(GENERAL, movers=casts.anything, frames=(100, 300), seconds=(2.0, 150.0)),
    "queueing": replace(GENERAL, movers=casts.queue, count=(4, 14)),
    "pacing": replace(GENERAL, movers=casts.pacers, count=(2, 12)),
    "dancing": replace(GENERAL, movers=casts.dancers, count=(2, 14)),
    "paths": replace(GENERAL, movers=casts.two_paths, count=(4, 12)),
    "started_by_hand": replace(GENERAL, clocks=networks.hand_started, frames=(1500, 3000), rates=(25.0,)),
    "coming_and_going": replace(GENERAL, movers=casts.passers, count=(3, 12)),
}
"""Every pair that has enough in common has an answer: at offset 0, but for what was started by hand."""

FAMILIES: dict[str, Callable[[int, str], Situation]] = {
    **dict.fromkeys(WITH_ANSWER, lambda seed, family: draw(seed, family, WITH_ANSWER[family])),
    **WITHOUT_ANSWER,
    **networks.NETWORKS,
    **NETWORKS_WITHOUT_ANSWER,
}


def situation(seed: int, family: str = "mixed") -> Situation:
    """Draw a whole situation: cameras, movers, motion, masks; every number of it from the seed.

    Parameters
    ----------
    seed : int
        Not negative, of any size.
    family : str
        One of `FAMILIES`.

    Examples
    --------
    >>> from epibar import synthetic
    >>> made = synthetic.situation(1, "low")
    >>> len(made.cameras), made.answer(0, 1).exists
    (4, True)
    """
    if family not in FAMILIES:
        raise ValueError(f"family = {family!r}: choose from {', '.join(FAMILIES)}")
    return FAMILIES[family](seed, family)
