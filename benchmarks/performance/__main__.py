"""How fast every stage is, beside its limit and its peers: ``make bench``."""

from __future__ import annotations

import json
import os
import platform
import sys
from argparse import ArgumentParser
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from barcodes import LINES, recording_stages
from data import Pair
from machine import measure
from matching import huge_stage, matching_stages
from memory import memory_stage
from plan import plan_stages
from record import record_stages
from scores import score_stages
from table import print_tables, to_json
from whole import whole_stages

PEERS = ("numpy", "opencv-python-headless", "numkong", "faiss-cpu", "scikit-image", "poselib")
PARTS = ("recording", "matching", "huge", "scores", "whole", "record", "memory", "plan")


def main() -> None:
    parser = ArgumentParser(prog="benchmarks/performance", description=__doc__)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    parser.add_argument("--only", default=",".join(PARTS), help="parts: %(default)s")
    parser.add_argument("--frames", default="500", help="lengths of the long videos: 500,20000")
    parser.add_argument("--sizes", default="1280x720,1920x1080", help="of part record: %(default)s")
    parser.add_argument("--length", type=int, default=300, help="frames of part record: %(default)s")
    options = parser.parse_args()
    parts = options.only.split(",")
    if unknown := set(parts) - set(PARTS):
        parser.error(f"unknown parts {', '.join(sorted(unknown))}; choose from {', '.join(PARTS)}")

    pair = Pair()
    tell("rendering masks, measuring the machine")
    machine = measure(pair.masks[0], LINES)
    print(
        f"{machine.threads} threads; memory is read at {machine.bytes_per_second / 1e9:.1f} GB/s, "
        f"{machine.words_per_second / 1e9:.1f} billion words are counted per second"
    )
    stages = []
    for part in parts:
        tell(part)
        if part == "recording":
            stages += recording_stages(pair, machine)
        elif part == "matching":
            stages += matching_stages(pair, machine)
        elif part == "huge":
            stages.append(huge_stage(machine))
        elif part == "scores":
            stages += score_stages(pair)
        elif part == "whole":
            stages += whole_stages(pair, machine)
        elif part == "record":
            for size in options.sizes.split(","):
                width, height = map(int, size.split("x"))
                stages += record_stages(options.length, (width, height))
        elif part == "memory":
            stages += [memory_stage(int(frames)) for frames in options.frames.split(",")]
        elif part == "plan":
            stages += plan_stages()
    print_tables(stages)
    if options.json:
        about = {"python": platform.python_version(), "cpus": os.cpu_count(), "platform": platform.platform()}
        found = {
            "about": about,
            "versions": versions(),
            "machine": asdict(machine),
            "stages": to_json(stages),
        }
        options.json.write_text(json.dumps(found, indent=1) + "\n")


def versions() -> dict[str, str]:
    """Of epibar and the peers that are installed."""
    found = {}
    for name in ("epibar", *PEERS):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def tell(what: str) -> None:
    print(f"{what} ...", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
