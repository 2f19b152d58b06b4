"""Tables of `fresh`: a row for each family with a bound of its own, nothing pooled."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from tables import counted, percent, px, table
from verdicts import upper_bound

from epibar.evaluation import GOOD_PAIR_PX

Outcome = dict[str, Any]
OFFSET_FRAMES = 0.5
"""An offset that is off by more is wrong."""


def _below(value: float | None, limit: float) -> bool:
    """Whether a number is there and not above a limit."""
    return value is not None and value <= limit


def right(o: Outcome) -> bool:
    """F within 3 px over the volume; of a pair without an answer, over the room too."""
    if not o["truth"]:
        return False
    good = _below(o.get("error"), GOOD_PAIR_PX)
    if "offset_error" in o:
        good &= o["offset_error"] is not None and abs(o["offset_error"]) <= OFFSET_FRAMES
    if not o["answer"]:
        good &= _below(o.get("room_error"), GOOD_PAIR_PX)
    return good


def share(parts: Sequence[bool]) -> float:
    """Share of what is true; NaN of nothing."""
    return sum(parts) / len(parts) if parts else math.nan


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else math.nan


WITH = [
    "family",
    "situations",
    "pairs",
    "right",
    "of pairs",
    "accepted",
    "right ones accepted",
    "accepted and wrong",
    "95 % bound",
    "median px, right",
    "best possible",
    "error ≤ stated",
    "≤ 2 × stated",
    "refused as",
    "s per pair",
]


def answered(family: str, group: list[Outcome]) -> list[str]:
    """Return the row of a family with an answer."""
    good, accepted = [o for o in group if right(o)], [o for o in group if o["accepted"]]
    wrong = sum(not right(o) for o in accepted)
    held = [factor_held(o, 1.0) for o in accepted], [factor_held(o, 2.0) for o in accepted]
    return [
        family,
        str(len({o["seed"] for o in group})),
        str(len(group)),
        str(len(good)),
        percent(len(good) / len(group)),
        str(len(accepted)),
        percent(share([o["accepted"] for o in good])),
        str(wrong),
        percent(upper_bound(wrong, len(group))),
        px(_median([o["error"] for o in good])),
        px(_median([o["bound"] for o in good])),
        *(percent(share(part)) for part in held),
        counted(o["kind"] for o in group if not o["accepted"]) or "-",
        f"{_median([o['seconds'] for o in group]):.1f}",
    ]


def factor_held(o: Outcome, factor: float) -> bool:
    """Whether the true error over the volume is not above so many times the stated one."""
    return o["stated"] is not None and _below(o.get("error"), factor * o["stated"])


WITHOUT = [
    "family",
    "pairs",
    "accepted",
    "of these right over the room",
    "accepted and wrong",
    "95 % bound",
    "refused as",
    "s per pair",
]


def unanswered(family: str, group: list[Outcome]) -> list[str]:
    """Return the row of a family without an answer."""
    accepted = [o for o in group if o["accepted"]]
    wrong = sum(not right(o) for o in accepted)
    return [
        family,
        str(len(group)),
        str(len(accepted)),
        str(len(accepted) - wrong),
        str(wrong),
        percent(upper_bound(wrong, len(group))),
        counted(o["kind"] for o in group if not o["accepted"]) or "-",
        f"{_median([o['seconds'] for o in group]):.1f}",
    ]


STEADY = ["family", "pairs", "same verdict for (b, a)", "same verdict for all seeds"]


def steady(family: str, group: list[Outcome]) -> list[str]:
    """Return the row that tells whether the verdict depends on order or seed."""
    swapped = [o["swapped"] == o["accepted"] for o in group if "swapped" in o]
    seeds = [all(v == o["accepted"] for v in o["other_seeds"]) for o in group if "other_seeds" in o]
    return [family, str(len(group)), percent(share(swapped)), percent(share(seeds))]


def report(outcomes: list[Outcome], left_out: dict[str, Counter[str]], seeds: str, lines: int) -> str:
    """Set all tables in Markdown; ``left_out`` counts, by family and reason, pairs without an answer."""
    parts = []

    def rows(chosen: list[Outcome], row: Callable[[str, list[Outcome]], list[str]]) -> list[list[str]]:
        ordered = sorted(
            chosen, key=lambda o: list(dict.fromkeys(p["family"] for p in chosen)).index(o["family"])
        )
        return [row(family, list(group)) for family, group in groupby(ordered, lambda o: o["family"])]

    for method in dict.fromkeys(o["method"] for o in outcomes):
        own = [o for o in outcomes if o["method"] == method]
        parts.append(f'method="{method}", {lines} lines, {seeds}')
        known, unknown = [o for o in own if o["answer"]], [o for o in own if not o["answer"]]
        if known:
            parts.append(table(WITH, rows(known, answered)))
        if unknown:
            parts.append("No answer:\n\n" + table(WITHOUT, rows(unknown, unanswered)))
        tried = [o for o in own if "swapped" in o or "other_seeds" in o]
        if tried:
            parts.append(table(STEADY, rows(tried, steady)))
        wrong = [o for o in own if o["accepted"] and not right(o)]
        if wrong:
            named = (
                f"- {o['family']} {o['seed']} {o['pair']}: {errors(o)}, stated {px(o['stated'] or math.nan)}"
                for o in wrong
            )
            parts.append("Accepted and wrong:\n" + "\n".join(named))
    named = [f"{family} ({counted(found.elements())})" for family, found in left_out.items() if found]
    if named:
        parts.append("Pairs left out: " + "; ".join(named))
    return "\n" + "\n\n".join(parts)


def errors(o: Outcome) -> str:
    """Return the errors of an outcome in words."""
    if not o["truth"]:
        return str(o["why_not"])
    found = [o.get(name) for name in ("error", "room_error", "image_error")]
    volume, room, image = (px(math.nan if error is None else error) for error in found)
    return f"{volume} px over the volume, {room} over the room, {image} over the image"
