"""Seconds of several ways of doing one thing, taken in turn: only ratios within a run mean anything."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

__all__ = ["in_turn"]


def in_turn(ways: Mapping[str, Callable[[], Any]], rounds: int = 5, budget: float = 60.0) -> dict[str, float]:
    """Least wall seconds of each way.

    Each round runs every way once, so that what else the machine does hits all alike; what takes very long is
    left out of later rounds when the budget (seconds) is spent.
    """
    least: dict[str, float] = {}
    spent = 0.0
    for turn in range(rounds):
        for name, way in ways.items():
            if turn and spent + least[name] > budget:
                continue
            started = time.perf_counter()
            way()
            seconds = time.perf_counter() - started
            spent += seconds
            least[name] = min(seconds, least.get(name, seconds))
    return least
