"""Has a camera moved? Made-up networks with new footage: a camera turned, shifted, zoomed or left alone.

The stored network is the true one, or (``--stored calibrated``) what the package makes of other footage of
the same cameras, nothing known of their lenses; only its pairs are given the true geometry, so that no search
is waited for. Every camera starts with the others. Seeds of a reported table come from the commit's own hash.
"""

from __future__ import annotations

import os
import time
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from check_networks import (
    CALIBRATED,
    CHECKED,
    FPS,
    PAUSE,
    calibrated_network,
    recorded,
    situation,
    true_network,
)
from check_updates import HEAD_FRESH, beside_fresh, fresh_row, searched, update_error
from fresh_seeds import sizes_asked_for
from networks import outcomes_of
from options import natural, numbers
from tables import table
from verdicts import upper_bound

UNMOVED = "unmoved"
DAMAGE = (
    *("turned 0.1°", "turned 0.3°", "turned 1°", "turned 3°"),
    *("shifted 1 cm", "shifted 5 cm", "shifted 20 cm"),
    *("zoomed 1 %", "zoomed 3 %", "turned 1° half way"),
)


@dataclass(frozen=True)
class Damage:
    """What was done to a camera."""

    what: str

    @property
    def size(self) -> float:
        """By how much: degrees, metres, or a share of the focal length."""
        value = float(self.what.split()[1].rstrip("°"))
        return value if self.kind == "turned" else 0.01 * value

    @property
    def kind(self) -> str:
        """Turned, shifted or zoomed."""
        return self.what.split()[0]

    def done_to(self, film: Any, rng: np.random.Generator) -> Any:
        """Return what the camera films then."""
        from epibar.synthetic.settings import turned

        camera = film.camera
        if self.kind == "turned":
            moved = turned(camera, rng, self.size)
        elif self.kind == "shifted":
            way = rng.normal(size=3)
            moved = replace(camera, t=camera.t - camera.R @ (self.size * way / np.linalg.norm(way)))
        else:
            by = 1 + self.size * rng.choice([-1, 1])
            moved = replace(camera, K=camera.K * [[by, 1, 1], [1, by, 1], [1, 1, 1]])
        if "half way" in self.what:
            return replace(film, knocked=moved, knocked_at=film.knocked_at + CHECKED // 2)
        return replace(film, camera=moved)


def run(count: int, seed: int, arguments: Namespace) -> list[dict[str, Any]]:
    """Check a network against some minutes as it stood, and with each damage done to a camera in each."""
    made = situation(seed, count, arguments.minutes)
    stored = true_network(made)
    if arguments.stored == "calibrated":
        stored = calibrated_network(made, arguments.lines)
        if not stored.accepted:
            return [{"cameras": count, "seed": seed, "what": "not calibrated", "reason": stored.reason}]
    outcomes = []
    for minute in range(arguments.minutes):
        first = CALIBRATED + PAUSE + minute * (PAUSE + CHECKED)
        films = {
            film.camera.name: recorded(film, first, first + CHECKED, 31 * minute + k, arguments.lines)
            for k, film in enumerate(made.films)
        }
        outcomes.append({**checked(made, stored, films, UNMOVED, None, None), "seed": seed})
        if minute == 0 and arguments.searched:
            outcomes[-1]["searched"] = searched(made, first, arguments.searched, seed)
        for what in arguments.damage:
            index, rng = drawn(seed, count, what, minute)
            film = Damage(what).done_to(replace(made.films[index], knocked_at=first), rng)
            again = recorded(film, first, first + CHECKED, 31 * minute + index, arguments.lines)
            name = made.names[index]
            outcomes.append({**checked(made, stored, {**films, name: again}, what, name, film), "seed": seed})
    return outcomes


def drawn(seed: int, count: int, what: str, minute: int) -> tuple[int, np.random.Generator]:
    """Draw which camera is damaged in a minute, all in turn, and what the damage itself is drawn from.

    Neither depends on the other damages and minutes that were asked for.
    """
    stream = (seed, 99, DAMAGE.index(what))
    order = np.random.default_rng(stream).permutation(count)
    return int(order[minute % count]), np.random.default_rng((*stream, minute + 1))


def checked(made: Any, stored: Any, films: Any, what: str, name: str | None, film: Any) -> dict[str, Any]:
    """Check a network, and hold what is said of the camera to which something was done against the truth."""
    started = time.perf_counter()
    check = stored.check(films, 0.0)
    outcome = {
        "cameras": len(films),
        "what": what,
        "name": name,
        "moved": check.moved,
        "suspects": check.suspects,
        "unsure": check.unsure,
        "seconds": time.perf_counter() - started,
        "answers": {
            key: [one.turned, one.turned_error, one.shifted, one.shifted_error, one.focal, one.focal_error]
            for key, one in check.cameras.items()
        },
        "reasons": {key: check.cameras[key].reason for key in (*check.moved, *check.suspects)},
    }
    after = made
    if film is not None:
        cameras = [film.knocked or film.camera if one.name == name else one for one in made.cameras]
        after = replace(made, cameras=cameras)
    if film is None or film.knocked is None:
        outcome["fresh"] = beside_fresh(after, stored, check, films)
    if name is None or name not in check.moved:
        return outcome
    one, damage = check.cameras[name], Damage(what)
    unit = float(np.linalg.norm(made.cameras[0].centre - made.cameras[1].centre))
    places = [stored.cameras[key].position for key in made.names[:2]]
    unit /= float(np.linalg.norm(places[0] - places[1]))
    found, error = {
        "turned": (one.turned, one.turned_error),
        "shifted": (unit * (one.shifted or 0), unit * (one.shifted_error or 0)),
        "zoomed": (abs(one.focal or 0), one.focal_error),
    }[damage.kind]
    outcome |= {"error": abs(found - damage.size), "stated": error, "since": one.since}
    outcome["focal"] = one.place is not None and one.place.zoomed
    if one.place is not None:
        outcome["update"] = update_error(after, stored.updated(check), name)
    return outcome


HEAD = (
    *("what was done", "cameras", "checks", "it alone is named", "it or another", "others named", "unsure"),
    *("taken for a zoom", "error, median", "stated, median", "within, %", "updates: within, % (f R C)"),
    *("since, s off", "check, s"),
)


def names_others(outcome: dict[str, Any]) -> bool:
    """Whether a camera is said to have moved that did not, or suspects among which is none that did."""
    suspects = outcome["suspects"]
    return bool(set(outcome["moved"]) - {outcome["name"]} or (suspects and outcome["name"] not in suspects))


def row(what: str, count: int, outcomes: list[dict[str, Any]]) -> list[str]:
    """One kind of damage in a row of the table."""
    right = [o for o in outcomes if o["moved"] == [o["name"]] and not o["suspects"]]
    among = sum(not o["moved"] and o["name"] in o["suspects"] for o in outcomes)
    wrong = sum(names_others(o) for o in outcomes)
    cells = [what, str(count), str(len(outcomes)), f"{len(right)}", str(among), str(wrong)]
    cells.append(str(sum(bool(o["unsure"]) for o in outcomes)))
    known = [o for o in right if "error" in o]
    cells.append(str(sum(o["focal"] for o in known)) if known else "")
    if known:
        scale, unit = {"turned": (1, "°"), "shifted": (100, " cm"), "zoomed": (100, " %")}[what.split()[0]]
        error, stated = (scale * np.array([o[key] for o in known]) for key in ("error", "stated"))
        cells += [f"{np.median(error):.2g}{unit}", f"{np.median(stated):.2g}{unit}"]
        cells.append(f"{100 * (error <= stated).mean():.0f}")
        updates = np.array([o["update"] for o in known if "update" in o]).reshape(-1, 6)
        within = updates[:, :3] <= updates[:, 3:] + 1e-9
        shares = " ".join(f"{100 * share:.0f}" for share in within.mean(axis=0)) if len(updates) else "-"
        cells.append(f"{len(updates)}: {shares}")
        late = [abs((o["since"] or 0) - CHECKED / FPS / 2) for o in known]
        cells.append(f"{np.median(late):.1f}, {max(late):.1f}" if "half way" in what else "")
    else:
        cells += [""] * 5
    return [*cells, f"{np.median([o['seconds'] for o in outcomes]):.1f}"]


def of_size(outcomes: list[dict[str, Any]], count: int) -> list[dict[str, Any]]:
    """Those of networks of so many cameras."""
    return [o for o in outcomes if o["cameras"] == count]


def alarms(calm: list[dict[str, Any]]) -> str:
    """False alarms among the checks in which no camera moved."""
    cameras = sum(o["cameras"] for o in calm)
    false = sum(len(o["moved"]) + len(o["suspects"]) for o in calm)
    return (
        f"false alarms: {false} of {cameras} cameras in {len(calm)} checks; with 95 % confidence below "
        f"{100 * upper_bound(false, max(cameras, 1)):.1f} % of cameras"
    )


MOVE = ("turned", "shifted", "zoomed")
"""What is found of a camera, as the columns of an outcome's answers: each with its stated error after it."""

HEAD_UNMOVED = (
    *("cameras of a network", "unmoved ones"),
    *(f"{what} by more than stated, %; most, times" for what in MOVE),
)


def unmoved_row(count: int, outcomes: list[dict[str, Any]]) -> list[str]:
    """How many cameras that did not move are found to have moved by more than its stated error.

    Nine in ten should be below. Cameras of damaged networks are left out: their minutes are the same.
    """
    answers = [one for o in outcomes for one in o["answers"].values()]
    cells = [str(count), str(len(answers))]
    for k in range(len(MOVE)):
        pairs = [(abs(one[2 * k]), one[2 * k + 1]) for one in answers if one[2 * k] is not None]
        if not pairs:
            cells.append("-")
            continue
        found, stated = np.array(pairs).T
        cells.append(f"{100 * (found > stated).mean():.0f}; {(found / stated).max():.1f}")
    return cells


def main(arguments: Namespace) -> None:
    origin, jobs = sizes_asked_for(arguments, "check")
    arguments.damage = [what for what in DAMAGE if not arguments.only or what.split()[0] in arguments.only]
    outcomes = outcomes_of(run, [(*job, arguments) for job in jobs], arguments, origin)
    print(f"commit {origin}" if origin else "seeds by hand: no table to report")
    chosen = {
        (what, count): some
        for what in (UNMOVED, *arguments.damage)
        for count in arguments.cameras
        if (some := of_size([o for o in outcomes if o["what"] == what], count))
    }
    print(table(HEAD, [row(*kind, some) for kind, some in chosen.items()]))
    calm = [o for o in outcomes if o["what"] == UNMOVED]
    sizes = {count: some for count in arguments.cameras if (some := of_size(calm, count))}
    print(f"\n{table(HEAD_UNMOVED, [unmoved_row(*one) for one in sizes.items()])}")
    print(f"\n{alarms(calm)}")
    fresh = [fresh_row(*kind, some) for kind, some in chosen.items() if "fresh" in some[0]]
    print(f"\n{table(HEAD_FRESH, fresh)}\n")
    missing = sum(len(o["fresh"]["missing"]) for o in outcomes if "fresh" in o)
    if missing:
        print(f"{missing} cameras that were updated have no place in a fresh network: not held against it")
    lost = sum(o["what"] == "not calibrated" for o in outcomes)
    if lost:
        print(f"{lost} networks were not accepted, and not checked")


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--networks", type=natural, default=10, help="of each size (default %(default)s)")
    parser.add_argument("--cameras", type=numbers, default=[3, 6], help="sizes (default 3,6)")
    parser.add_argument(
        "--minutes", type=natural, default=3, help="of new footage, of each (default %(default)s)"
    )
    parser.add_argument("--only", nargs="*", help="some of: turned shifted zoomed; 'none' for unmoved alone")
    parser.add_argument("--stored", choices=("true", "calibrated"), default="true", help="what is stored")
    parser.add_argument("--seeds", type=numbers, help="such as 1-5: for a trial, instead of the commit's")
    parser.add_argument(
        "--lines", type=natural, default=100, help="per camera, of no use here (default %(default)s)"
    )
    parser.add_argument(
        "--searched",
        type=natural,
        metavar="LINES",
        help="time a calibration that searches its pairs too, by so many lines per camera",
    )
    parser.add_argument("--workers", type=natural, default=os.cpu_count() or 1)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every outcome there too")
    main(parser.parse_args())
