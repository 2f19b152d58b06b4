"""Which lines of the crate its tests reach, room by room: `make coverage` calls it.

The tests are built with counters in the crates of the workspace alone, so that dependencies run at full
speed, and each test program is run. What they wrote is read by `cov` of llvm_profparser, which needs no
LLVM of the compiler's version. The folder of another checkout, as a second argument, measures that one with
this same program.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parents[1]
LINE = re.compile(r" *\d+\| *(\d+)\|")
"""A line of code that `cov show` prints, and how often it was reached."""

TESTS = re.compile(r"#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))?\s+)?mod ")


def programs(root: Path) -> list[Path]:
    """Build the test programs of a checkout with counters, and return them."""
    command = ["cargo", "test", "--package", "epibar", "--lib", "--tests", "--no-run", "--locked"]
    environment = os.environ | {
        "RUSTC_WORKSPACE_WRAPPER": str(HERE / "benchmarks" / "instrumented_rustc.sh"),
        "CARGO_TARGET_DIR": str(root / "target" / "coverage"),
    }
    environment.pop("PYO3_BUILD_EXTENSION_MODULE", None)
    done = subprocess.run(
        [*command, "--message-format=json"], cwd=root, env=environment, stdout=subprocess.PIPE, check=True
    )
    messages = map(json.loads, done.stdout.splitlines())
    return [Path(one["executable"]) for one in messages if one.get("executable") and one["profile"]["test"]]


def run(program: Path, root: Path) -> Path:
    """Run one test program of a checkout; the file with its counts."""
    counts = root / "target" / "coverage" / f"{program.name}.profraw"
    counts.unlink(missing_ok=True)
    # Threads wait for each other at the counters, so there is one.
    one_thread = {"LLVM_PROFILE_FILE": str(counts), "RAYON_NUM_THREADS": "1"}
    print(f"{program.name} ...", file=sys.stderr, flush=True)
    command = [program, "--test-threads=1", "--quiet"]
    subprocess.run(command, cwd=root / "rust" / "epibar", env=os.environ | one_thread, check=True)
    return counts


def lines_of(
    cov: str, counts: list[Path], objects: list[Path], source: Path
) -> Iterator[tuple[Path, int, bool]]:
    """File, number and whether it was reached, of every line of the source that holds code and is no test."""
    command = [cov, "show"]
    for flag, paths in (("--instr-profile", counts), ("--object", objects)):
        command += [word for path in paths for word in (flag, str(path))]
    shown = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    path, tests_from = Path(), 0
    for line in shown.splitlines():
        if line.startswith("/"):
            path = Path(line.rstrip(":"))
            if path.is_relative_to(source):
                text = path.read_text()
                tests = TESTS.search(text)
                tests_from = text[: tests.start()].count("\n") + 1 if tests else sys.maxsize
        elif (found := LINE.match(line)) and path.is_relative_to(source):
            number = int(line.split("|")[0])
            if number < tests_from:
                yield path.relative_to(source), number, int(found[1]) > 0


def main(cov: str, checkout: str = str(HERE)) -> None:
    root = Path(checkout).resolve()
    objects = programs(root)
    counts = [run(program, root) for program in objects]
    reached: dict[tuple[Path, int], bool] = {}
    for path, number, hit in lines_of(cov, counts, objects, root / "rust" / "epibar" / "src"):
        reached[path, number] = reached.get((path, number), False) or hit
    lines, hits = Counter[str](), Counter[str]()
    for (path, _), hit in reached.items():
        room = path.parts[0] if len(path.parts) > 1 else path.name
        for name in (room, "all"):
            lines[name] += 1
            hits[name] += hit
    if not lines:
        raise SystemExit("no line of the crate was found in what the tests wrote")
    for room in [*sorted(lines.keys() - {"all"}), "all"]:
        print(f"{room:22} {hits[room]:6} of {lines[room]:6} lines  {100 * hits[room] / lines[room]:5.1f} %")


if __name__ == "__main__":
    main(*sys.argv[1:])
