"""Where the time of a pair goes: CPU seconds by stage, of hard pairs beside an easy one.

The easy pair is the one of ``performance``: eight walkers, 768x576, 800 frames. The hard ones are those of
real recordings (``--only``, default ``four_people``), with their camera matrices known. Each is calibrated as
often as ``--rounds`` says, in turn with the others, and the least of each counts.
"""

from __future__ import annotations

import statistics
import sys
import time
from itertools import combinations, pairwise
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "performance"))

from data import Pair
from options import natural
from recordings_views import DATA, parser_of, present, view
from tables import progress, table

import epibar
from epibar import Recording
from epibar.lens.cameras_toml import load_cameras

Seconds = dict[str, float]


def timed(a: Recording, b: Recording) -> tuple[Seconds, epibar.Calibration]:
    """Calibrate; CPU seconds between what the search tells of its stages, by stage."""
    begins: list[tuple[str, float]] = []

    def tell(stage: str, share: float) -> None:
        begins.append((stage, time.process_time()))

    started = time.process_time()
    cal = epibar.calibrate(a, b, progress=tell)
    seconds: Seconds = {"clock": begins[0][1] - started if begins else 0.0}
    for (stage, begin), (_, end) in pairwise([*begins, ("", time.process_time())]):
        seconds[stage] = seconds.get(stage, 0.0) + end - begin
    return seconds, cal


def main() -> None:
    """Time every pair and print the table."""
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=natural, default=2, help="of which the least counts (default 2)")
    parser.set_defaults(only=["four_people"])
    args = parser.parse_args()
    pairs: dict[str, tuple[Recording, Recording]] = {"easy": tuple(Pair().recordings)}
    for name in present(args):
        data, folder = DATA[name], args.data_dir / DATA[name].folder
        known = load_cameras(folder / "cameras.toml")
        views = [
            view(folder / file, camera, i, known, data, args)
            for i, (camera, file) in enumerate(data.files.items())
        ]
        for a, b in combinations(views, 2):
            pairs[f"{name} {a.name}-{b.name}"] = (a.recording, b.recording)
    least: dict[str, Seconds] = {}
    kinds: dict[str, str] = {}
    for round_ in range(args.rounds):
        for name, (a, b) in pairs.items():
            seconds, cal = timed(a, b)
            kinds[name] = cal.kind
            progress(f"{name}: {sum(seconds.values()):.2f} s, round {round_ + 1}")
            if name not in least or sum(seconds.values()) < sum(least[name].values()):
                least[name] = seconds
    stages = list(dict.fromkeys(stage for seconds in least.values() for stage in seconds))
    easy = sum(least["easy"].values())
    rows = []
    for name, seconds in least.items():
        whole = sum(seconds.values())
        cells = [f"{seconds.get(stage, 0.0):.2f}" for stage in stages]
        rows.append([name, kinds[name], f"{whole:.2f}", f"{whole / easy:.2f}", *cells])
    print(table(["pair", "kind", "CPU s", "times the easy one", *stages], rows))
    hard = [sum(seconds.values()) / easy for name, seconds in least.items() if name != "easy"]
    if hard:
        print(
            f"\nHard pairs: median {statistics.median(hard):.2f}, worst {max(hard):.2f} times the easy one."
        )


if __name__ == "__main__":
    main()
