"""Coverage-guided fuzzing of every entry, in both languages: inputs tried, what they reach, and what failed.

The crate by cargo-fuzz, the Python readers by Atheris. What is new is kept in ``target/fuzz``, so that the
next run goes on from there; inputs that fail are kept beside it. It begins with those of the tests.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from argparse import ArgumentParser
from pathlib import Path

from tables import progress, table, write_json

ROOT = Path(__file__).parents[1]
CRATE = ROOT / "rust" / "epibar"
WORK = ROOT / "target" / "fuzz"
LIMITS = ["-timeout=30", "-rss_limit_mb=4096", "-max_len=16384", "-print_final_stats=1"]
"""An input that takes longer, or more memory, is a failure."""


def targets() -> dict[str, list[str]]:
    """Names and commands of all targets."""
    found = {}
    for path in sorted((CRATE / "fuzz" / "fuzz_targets").glob("*.rs")):
        words = ["cargo", "+nightly", "fuzz", "run", "--fuzz-dir", str(CRATE / "fuzz"), "--sanitizer", "none"]
        found[f"rust/{path.stem}"] = [*words, path.stem]
    for path in sorted((ROOT / "tests" / "corpus").iterdir()):
        if path.is_dir():
            found[f"python/{path.name}"] = [
                sys.executable,
                str(ROOT / "tests" / "fuzz_readers.py"),
                path.name,
            ]
    return found


def inputs(target: str) -> Path:
    """Where a target's inputs are that the tests replay."""
    language, name = target.split("/")
    return (CRATE if language == "rust" else ROOT) / "tests" / "corpus" / name


def run(target: str, words: list[str], seconds: int) -> dict[str, object]:
    """Fuzz one target, and return its figures."""
    found = WORK / target
    found.mkdir(parents=True, exist_ok=True)
    folders = [str(found), str(inputs(target))]
    options = [*LIMITS, f"-max_total_time={seconds}", f"-artifact_prefix={WORK / target.replace('/', '-')}-"]
    order = [*folders, "--", *options] if target.startswith("rust") else [*options, *folders]
    # One input at a time; many threads only slow small ones down.
    environment = {**os.environ, "RAYON_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    # The Python module is built as one, and the targets are programs.
    environment.pop("PYO3_BUILD_EXTENSION_MODULE", None)
    done = subprocess.run([*words, *order], capture_output=True, text=True, env=environment, errors="replace")
    log = WORK / f"{target.replace('/', '-')}.log"
    log.write_text(done.stdout + done.stderr)
    coverage = re.findall(r"cov: (\d+) ft: (\d+) corp: (\d+)", done.stderr)
    executions = re.search(r"number_of_executed_units: *(\d+)", done.stderr)
    worst = re.search(r"slowest_unit_time_sec: *(\d+)", done.stderr)
    memory = re.search(r"peak_rss_mb: *(\d+)", done.stderr)
    if done.returncode and not executions:
        progress(f"{target}: {log} says why it failed")
    return {
        "executions": int(executions[1]) if executions else 0,
        "edges": int(coverage[-1][0]) if coverage else 0,
        "features": int(coverage[-1][1]) if coverage else 0,
        "inputs": int(coverage[-1][2]) if coverage else 0,
        "slowest, s": int(worst[1]) if worst else "-",
        "memory, MB": int(memory[1]) if memory else "-",
        "failed": "yes" if done.returncode else "no",
    }


def main() -> int:
    """Run it."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=30, help="for each target; default: %(default)s")
    parser.add_argument("--targets", help="only these, e.g. rust/calibrate,python/network")
    parser.add_argument("--json", type=Path, help="file for all of it")
    args = parser.parse_args()
    known = targets()
    chosen = args.targets.split(",") if args.targets else list(known)
    rows: dict[str, dict[str, object]] = {}
    for target in chosen:
        rows[target] = run(target, known[target], args.seconds)
        progress(f"{target}: {rows[target]}")
        write_json(args.json, args, [], rows)
    columns = list(next(iter(rows.values())))
    print(table(["target", *columns], [[name, *map(str, row.values())] for name, row in rows.items()]))
    return int(any(row["failed"] == "yes" for row in rows.values()))


if __name__ == "__main__":
    sys.exit(main())
