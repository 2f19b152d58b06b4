"""Fresh situations, family by family: what is right, what is accepted, and whether what is stated holds.

The seeds of a reported table come from the commit's own hash, so that nobody can have looked at them.

What is judged is F, in the pixels that were given. So an accepted F of a mirrored film is right where it is
right for the mirrored pixels, over the volume and over the room; ``mirrored`` still is a family without an
answer, as nothing says that it must be accepted.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from fresh_report import report
from fresh_seeds import commit, commit_seed
from options import METHODS, add_method, natural, numbers
from tables import progress

from epibar.synthetic import FAMILIES, WITH_ANSWER, WITHOUT_ANSWER

DEVELOPMENT_SEEDS = 2**32
"""Seeds that were given by hand are below, those of commits above."""


@dataclass(frozen=True)
class Job:
    """One situation, and what to do with it; equal jobs give equal results but for the seconds."""

    family: str
    seed: int
    methods: tuple[str, ...]
    lines: int
    pairs: int
    swap: bool
    search_seeds: int
    any_offset: bool = False

    @property
    def key(self) -> str:
        """What tells whether a job was done already."""
        return json.dumps(asdict(self), sort_keys=True)


def start_worker() -> None:
    """One thread for each worker: there are as many workers as cores."""
    os.environ["RAYON_NUM_THREADS"] = "1"
    os.nice(10)
    import cv2

    cv2.setNumThreads(1)


def chosen_pairs(situation: Any, job: Job) -> tuple[list[tuple[int, int]], dict[str, int]]:
    """Choose at most so many pairs of those that the family is about; and count why others are not."""
    import numpy as np

    wanted, left_out = [], Counter()
    for a, b in situation.pairs():
        answer = situation.answer(a, b)
        if job.family in WITHOUT_ANSWER or answer.exists or situation.groups[a] != situation.groups[b]:
            wanted.append((a, b))
        else:
            left_out[answer.reason] += 1
    order = np.random.default_rng((job.seed, 99)).permutation(len(wanted))[: job.pairs]
    return [wanted[index] for index in sorted(order)], dict(left_out)


def run(job: Job) -> dict[str, Any]:
    """Draw the situation, record the cameras that are needed, and calibrate the pairs.

    Returns what is kept: ``outcomes``, and ``left_out``, which counts reasons.
    """
    from epibar import synthetic

    situation = synthetic.situation(job.seed, job.family)
    pairs, left_out = chosen_pairs(situation, job)
    known = any(camera.distorted for camera in situation.cameras)
    recordings, seconds = {}, {}
    for index in sorted({camera for pair in pairs for camera in pair}):
        started = time.perf_counter()
        recordings[index] = situation.recording(index, job.lines, undistorted=known)
        seconds[index] = time.perf_counter() - started
    outcomes = [
        {**judged(situation, recordings, pair, job, method), "recording": seconds[pair[0]] + seconds[pair[1]]}
        for pair in pairs
        for method in job.methods
    ]
    return {"outcomes": outcomes, "left_out": left_out}


def judged(
    situation: Any, recordings: dict[int, Any], pair: tuple[int, int], job: Job, method: str
) -> dict[str, Any]:
    """Calibrate one pair, and hold the result against the truth."""
    import epibar
    from epibar.errors import EpibarError
    from epibar.evaluation import image_correspondences
    from epibar.synthetic import error_bound

    a, b = pair
    answer = situation.answer(a, b)
    known = situation.synchronised or situation.groups[a] != situation.groups[b]
    offset: Any = 0.0 if known and not job.any_offset else "search"

    def calibrated(first: int, second: int, seed: int) -> Any:
        return epibar.calibrate(
            recordings[first], recordings[second], method=method, seed=seed, time_offset=offset
        )

    started = time.perf_counter()
    cal = calibrated(a, b, job.seed % 2**32)
    found: dict[str, Any] = {
        "pair": f"{a + 1}-{b + 1}",
        "method": method,
        "answer": answer.exists,
        "why_not": answer.reason,
        "truth": situation.has_fundamental(a, b),
        "accepted": cal.accepted,
        "kind": cal.kind,
        "source": cal.source,
        "stated": cal.expected_error,
        "seconds": time.perf_counter() - started,
        "frames": recordings[a].frames,
        "F": None if cal.F is None else cal.F.tolist(),
        "evidence": {name: value for name, value in cal.evidence.items() if math.isfinite(value)},
    }
    if found["truth"]:
        found["bound"] = error_bound(situation, a, b)
    if cal.F is not None and found["truth"]:
        found["error"] = situation.error(cal.F, a, b)
        found["room_error"] = situation.error(cal.F, a, b, situation.room_points)
        try:
            sizes = situation.cameras[a].size, situation.cameras[b].size
            matches = image_correspondences(situation.fundamental(a, b), *sizes)
            found["image_error"] = float(epibar.symmetric_epipolar_distance(cal.F, *matches).mean())
        except EpibarError:  # the epipolar lines of one miss the other
            found["image_error"] = None
        if offset == "search":
            found["offset_error"] = cal.time_offset - situation.time_offset(a, b)
    if job.swap:
        found["swapped"] = calibrated(b, a, job.seed % 2**32).accepted
    if job.search_seeds > 1:
        others = [calibrated(a, b, (job.seed + step) % 2**32).accepted for step in range(1, job.search_seeds)]
        found["other_seeds"] = others
    return {name: plain(value) for name, value in found.items()}


def plain(value: Any) -> Any:
    """What JSON can say; not a number and infinity become null and a large number."""
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else math.copysign(1e9, value)
    return value


# --- which situations ---


def families_of(text: str) -> list[str]:
    """Read names of families, or ``answer``, ``no_answer``, ``network``, ``all``."""
    groups = {
        "answer": list(WITH_ANSWER),
        "no_answer": list(WITHOUT_ANSWER),
        "network": [name for name in FAMILIES if name.startswith("network")],
        "all": [*WITH_ANSWER, *WITHOUT_ANSWER],
    }
    found: list[str] = []
    for name in text.split(","):
        if name not in groups and name not in FAMILIES:
            raise ArgumentTypeError(f"{name!r}: choose from {', '.join([*groups, *FAMILIES])}")
        found += groups.get(name, [name])
    return list(dict.fromkeys(found))


def jobs_of(args: Namespace, origin: str) -> Iterator[Job]:
    """List the situations that were asked for, families in turn, so that all grow alike."""
    count = len(args.seeds) if args.seeds else args.situations
    for index in range(count):
        for family in args.families:
            seed = args.seeds[index] if args.seeds else commit_seed(origin, family, index)
            rest = args.lines, args.pairs, args.swap, args.search_seeds, args.any_offset
            yield Job(family, seed, METHODS[args.method], *rest)


def done(path: Path) -> dict[str, dict[str, Any]]:
    """Read what was done; a line that was cut off by an interruption is left out."""
    found = {}
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                entry = json.loads(line)
                found[entry["key"]] = {name: entry[name] for name in ("outcomes", "left_out")}
            except (json.JSONDecodeError, KeyError):
                progress(f"{path}: a line that was cut off is left out")
    return found


def parser() -> ArgumentParser:
    """Make the parser of the command line."""
    made = ArgumentParser(description=__doc__)
    made.add_argument(
        "--families",
        type=families_of,
        default=families_of("all"),
        help="names, or answer, no_answer, network, all (default: all, which are those without network)",
    )
    made.add_argument("--situations", type=natural, default=20, help="of each family (default %(default)s)")
    made.add_argument(
        "--seeds-from", choices=["commit"], default="commit", help="seeds of the hash of HEAD (default)"
    )
    made.add_argument("--seeds", type=numbers, help="development seeds instead, such as 1-20")
    made.add_argument(
        "--pairs", type=natural, default=3, help="of a situation, at most (default %(default)s)"
    )
    made.add_argument("--lines", type=natural, default=20_000, help="of a camera (default %(default)s)")
    add_method(made)
    made.add_argument("--swap", action="store_true", help="also calibrate (b, a): is the verdict the same?")
    made.add_argument(
        "--search-seeds", type=natural, default=1, metavar="N", help="calibrate with N seeds: same verdict?"
    )
    made.add_argument("--any-offset", action="store_true", help="search for the offsets of all pairs")
    made.add_argument("--workers", type=natural, default=os.cpu_count() or 1, help="default: all cores")
    made.add_argument(
        "--out",
        type=Path,
        default=Path("fresh.jsonl"),
        help="one line for each situation; what stands there is not done again (default %(default)s)",
    )
    made.add_argument("--report-only", action="store_true", help="print the tables of what stands there")
    made.add_argument("--verbose", action="store_true", help="print every pair as it is done")
    return made


def main() -> None:
    args = parser().parse_args()
    if args.seeds and max(args.seeds) >= DEVELOPMENT_SEEDS:
        raise SystemExit(f"--seeds: development seeds are below {DEVELOPMENT_SEEDS}")
    origin = "" if args.seeds else commit()
    jobs = list(jobs_of(args, origin))
    kept = done(args.out)
    missing = [] if args.report_only else [job for job in jobs if job.key not in kept]
    progress(f"{len(jobs)} situations, {len(jobs) - len(missing)} of them done")
    with (
        ProcessPoolExecutor(args.workers, get_context("spawn"), start_worker) as pool,
        args.out.open("a", encoding="utf-8") as out,
    ):
        if args.out.stat().st_size and not args.out.read_bytes().endswith(b"\n"):
            out.write("\n")
        running = {pool.submit(run, job): job for job in missing}
        for number, future in enumerate(as_completed(running), 1):
            job = running[future]
            kept[job.key] = future.result()
            out.write(json.dumps({"key": job.key, "commit": origin, **kept[job.key]}, allow_nan=False) + "\n")
            out.flush()
            progress(f"{number}/{len(missing)} {job.family} {job.seed}")
            if args.verbose:
                for outcome in kept[job.key]["outcomes"]:
                    print(json.dumps({"family": job.family, "seed": job.seed, **outcome}), file=sys.stderr)
    present = [(job, kept[job.key]) for job in jobs if job.key in kept]
    outcomes = [
        {"family": job.family, "seed": job.seed, **outcome}
        for job, found in present
        for outcome in found["outcomes"]
    ]
    left_out: dict[str, Counter[str]] = {}
    for job, found in present:
        left_out.setdefault(job.family, Counter()).update(found["left_out"])
    seeds = f"commit {origin}" if origin else f"development seeds {args.seeds[0]}–{args.seeds[-1]}"
    print(report(outcomes, left_out, seeds, args.lines))


if __name__ == "__main__":
    main()
