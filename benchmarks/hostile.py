"""Hostile inputs at every entry of the Python package: what becomes of them, and what they cost.

Files are those of ``tests/corpus``, damaged: bytes changed, cut out, doubled, numbers and words put in that
no camera gives. Functions get arrays and options of any kind. A good input of about the same size is the
measure of time and memory.
"""

from __future__ import annotations

import random
import signal
import sys
import time
import warnings
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from tables import progress, table, write_json

import epibar
from epibar import EpibarError, Recording, synthetic

TESTS = Path(__file__).parents[1] / "tests"
sys.path.insert(0, str(TESTS))

import fuzzed  # noqa: E402  # what coverage-guided fuzzing runs

PATIENCE, ASLEEP = 60, 900
"""Seconds of work, and of waiting, after which an input counts as one that hangs."""
SLOW = ("calibrate", "calibrate_network")
"""Entries with a tenth of the inputs: `make fuzz` tries more."""
LEAST = 0.005
"""Seconds below which a good input is not timed: a page that is not in memory takes as long."""
LEAST_MEMORY = 1.0
"""Megabytes, likewise."""

WORDS = [
    *(
        b"null",
        b"true",
        b"-1",
        b"0",
        b"1e999",
        b"1e308",
        b"NaN",
        b"[]",
        b"{}",
        b'""',
        b"..",
        b"../../etc/passwd",
    ),
    *(
        b"18446744073709551616",
        b"-9223372036854775809",
        b"9" * 400,
        b"[" * 500,
        b"(" * 500,
        b"\x00",
        b"\xff" * 8,
    ),
    *(b"|O", b"<U4000000000", b"<f8", b"(1000000000000,)", b"(-1,)", b"inf", b"\n", b","),
]

Input = tuple[Callable[[Any], object], Any]
"""A function, and what it is given."""


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Return a file with one to four changes."""
    for _ in range(chance.randint(1, 4)):
        # Headers come first, and damage there is worth more.
        at = chance.randrange(min(len(data), chance.choice((64, 256, 1 << 20))) or 1)
        until = at + chance.choice((0, 1, 1, 4, 8, 40))
        change = chance.choice(("other", "word", "word", "cut", "double", "end"))
        if change == "other":
            data = data[:at] + chance.randbytes(until - at) + data[until:]
        elif change == "word":
            data = data[:at] + chance.choice(WORDS) + data[until:]
        elif change == "cut":
            data = data[:at] + data[until:]
        elif change == "double":
            data = data[:until] + data[at:]
        elif chance.random() < 0.2:
            data = data[:at]
    return data


def files(name: str, function: Callable[[bytes], bool], chance: random.Random) -> Iterator[Input]:
    """Yield the good file, then damaged ones without end."""
    good = [path.read_bytes() for path in sorted((TESTS / "corpus" / name).iterdir())]
    good = [data for data in good if function(data)]
    yield function, max(good, key=len)
    while True:
        yield function, damaged(chance.choice(good), chance)


def any_array(chance: random.Random) -> np.ndarray:
    """Return an array of any kind and shape."""
    kind = chance.choice(["?", "u1", "f8", "i8", "u8", "f4", "U3", "O"])
    shape = tuple(chance.choice((0, 1, 2, 4, 9, 40)) for _ in range(chance.randint(0, 4)))
    while np.prod(shape, dtype=float) > 40_000:
        shape = shape[1:]
    random_bytes = np.frombuffer(chance.randbytes(int(np.prod(shape))), np.uint8).reshape(shape)
    with np.errstate(all="ignore"):
        made = random_bytes.astype(kind)
    if kind in ("f8", "f4") and chance.random() < 0.4 and made.size:
        made.flat[chance.randrange(made.size)] = chance.choice((np.nan, np.inf, -np.inf, 1e300, -1e30))
    return made


def any_value(chance: random.Random) -> Any:
    """Return an option of any kind."""
    odd = (
        None,
        True,
        -1,
        0,
        1,
        3,
        10**400,
        2**63,
        1e308,
        -0.5,
        float("nan"),
        float("inf"),
        "",
        "search",
        "lines",
        [],
    )
    return chance.choice(odd)


def masks(chance: random.Random) -> np.ndarray:
    """Return masks in which a few things move."""
    made = np.zeros((60, 30, 40), np.uint8)
    for _ in range(chance.randint(0, 3)):
        x, y, speed = chance.randrange(40), chance.randrange(20), chance.randint(-2, 2)
        for frame in range(60):
            left = (x + speed * frame) % 40
            made[frame, y : y + 8, left : left + 6] = 1
    return made


def functions(chance: random.Random) -> dict[str, Iterator[Input]]:
    """Return the inputs of every public function that takes arrays, a good one first."""
    scene = synthetic.cubes(3, cameras=3, objects=4, frames=60, size=(64, 48), size_m=(0.4, 0.7))
    recordings = [Recording.from_masks(scene.masks(index), fps=25.0, lines=300) for index in range(3)]
    recordings += [Recording.from_masks(masks(chance), fps=25.0, lines=200) for _ in range(3)]
    barcodes = np.arange(200, dtype=np.uint64).reshape(100, 2)
    lines = np.array([[0.0, 5, 39, 9], [3, 0, 30, 29]] * 30)
    names = ("method", "seed", "time_offset", "upright", "search_seconds", "max_expected_error", "essential")

    def options() -> dict[str, Any]:
        return {name: any_value(chance) for name in chance.sample(names, chance.randint(0, 2))}

    def calls(
        function: Callable[..., object], good: Callable[[], tuple], odd: Callable[[], tuple]
    ) -> Iterator[Input]:
        def call(given: tuple) -> object:
            positional, named = given
            return function(*positional, **named)

        yield call, good()
        while True:
            yield call, odd()

    def spoilt(*good: Any) -> tuple:
        given = [any_array(chance) if chance.random() < 0.5 else one for one in good]
        return given, {}

    def joined(given: dict[str, Recording], **named: Any) -> object:
        return epibar.calibrate_network(given, **named)

    two, three = recordings[:2], dict(zip("abc", recordings, strict=False))
    some = lambda count: [chance.choice(recordings) for _ in range(count)]  # noqa: E731
    return {
        "Recording.from_masks": calls(
            lambda given, **named: Recording.from_masks(given, **{"fps": 25.0, "lines": 100, **named}),
            lambda: ([masks(chance)], {}),
            lambda: (
                [any_array(chance) if chance.random() < 0.7 else masks(chance)],
                {name: any_value(chance) for name in chance.sample(("fps", "lines", "seed", "matrix"), 1)},
            ),
        ),
        "barcodes": calls(
            epibar.barcodes, lambda: ([masks(chance), lines], {}), lambda: spoilt(masks(chance), lines)
        ),
        "match_barcodes": calls(
            epibar.match_barcodes,
            lambda: ([barcodes, barcodes, 128], {}),
            lambda: ([*spoilt(barcodes, barcodes)[0], chance.choice((128, any_value(chance)))], {}),
        ),
        "symmetric_epipolar_distance": calls(
            epibar.symmetric_epipolar_distance,
            lambda: ([np.eye(3), np.ones((100, 2)), np.ones((100, 2))], {}),
            lambda: spoilt(np.eye(3), np.ones((100, 2)), np.ones((100, 2))),
        ),
        "calibrate": calls(epibar.calibrate, lambda: (two, {}), lambda: (some(2), options())),
        "calibrate_network": calls(
            joined,
            lambda: ([three], {}),
            lambda: ([dict(zip("abc", some(3), strict=True))], {"time_offset": any_value(chance)}),
        ),
    }


def memory() -> float:
    """Return the most memory since the mark was reset, MB."""
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def tried(function: Callable[[Any], object], given: Any) -> tuple[str, float, float]:
    """Try one input: what became of it, its seconds of work, and MB above what there was before."""
    Path("/proc/self/clear_refs").write_text("5")
    # Of this process, as others use the machine too.
    before, started = memory(), time.process_time()
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    signal.alarm(ASLEEP)
    try:
        outcome = "accepted" if function(given) is not False else "errors"
    except EpibarError:
        outcome = "errors"
    except TimeoutError:
        outcome = "hangs"
    except BaseException as error:  # a panic of the compiled module is no Exception
        if isinstance(error, KeyboardInterrupt):
            raise
        outcome = "panics"
        progress(f"{type(error).__name__}: {error}")
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
    return outcome, time.process_time() - started, memory() - before


def row_of(name: str, inputs: Iterator[Input], count: int) -> dict[str, Any]:
    """Try so many inputs of an entry."""
    function, good = next(inputs)
    usual = [tried(function, good) for _ in range(9)]
    if any(outcome != "accepted" for outcome, _, _ in usual):
        raise SystemExit(f"{name}: the good input is not accepted")
    seconds = max(LEAST, float(np.median([one[1] for one in usual])))
    room = max(LEAST_MEMORY, max(one[2] for one in usual))
    found: Counter[str] = Counter()
    slowest = most = 0.0
    for _ in range(count):
        outcome, took, used = tried(*next(inputs))
        found[outcome] += 1
        slowest, most = max(slowest, took), max(most, used)
    outcomes = {key: found[key] for key in ("accepted", "errors", "panics", "hangs")}
    return {"inputs": count, **outcomes, "time": slowest / seconds, "memory": most / room}


def main() -> int:
    """Run it."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=1000, help="of each entry; default: %(default)s")
    parser.add_argument("--entries", help="only these, e.g. network,calibrate")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, help="file for all of it")
    args = parser.parse_args()
    warnings.simplefilter("ignore")

    def late(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    signal.signal(signal.SIGPROF, late)
    chance = random.Random(args.seed)
    entries = {f"file: {one.__name__}": files(one.__name__, one, chance) for one in fuzzed.ALL} | functions(
        chance
    )
    rows = {}
    for name, inputs in entries.items():
        if args.entries is None or name.removeprefix("file: ") in args.entries.split(","):
            rows[name] = row_of(name, inputs, args.inputs // (10 if name in SLOW else 1))
            progress(f"{name}: {rows[name]}")
            write_json(args.json, args, [], rows)
    columns = ["inputs", "accepted", "errors", "panics", "hangs"]
    cells = [
        [name, *(str(row[column]) for column in columns), f"{row['time']:.1f} x", f"{row['memory']:.1f} x"]
        for name, row in rows.items()
    ]
    print(table(["entry", *columns, "slowest", "most memory"], cells))
    return int(any(row["panics"] or row["hangs"] for row in rows.values()))


if __name__ == "__main__":
    sys.exit(main())
