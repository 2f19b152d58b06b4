"""The job of ``many_cameras.py`` by this checkout and another, in turn: times, and what is not the same."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from argparse import ArgumentTypeError
from pathlib import Path
from typing import Any

import numpy as np
from tables import progress, table

import epibar

JOB = Path(__file__).with_name("many_cameras_job.py")
OWN = Path(epibar.__file__).resolve().parents[1]

Results = dict[str, list[dict[str, Any]]]
"""What the job printed each time, by the checkout."""


def checkout(text: str) -> Path:
    """Read a folder that holds the package ``epibar`` with its compiled module."""
    folder = Path(text).resolve()
    if not list(folder.glob("epibar/_core.*so")) + list(folder.glob("epibar/_core.*pyd")):
        raise ArgumentTypeError(f"{text!r}: expected a folder with epibar, built, in it: CHECKOUT/python")
    return folder


def run_job(package: Path, asked: dict[str, Any]) -> dict[str, Any]:
    """Run the job by the package in a folder."""
    done = subprocess.run(
        [sys.executable, str(JOB), json.dumps(asked)],
        env={**os.environ, "PYTHONPATH": str(package)},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"the job failed by {package}:\n{done.stderr}")
    found: dict[str, Any] = json.loads(done.stdout)
    if Path(found["package"]).resolve().parents[1] != package:
        raise SystemExit(f"{package} was asked for, but {found['package']} was imported")
    return found


def in_turn(method: str, lines: int, masks: list[Path], folder: Path, other: Path, rounds: int) -> Results:
    """Run the job so many times by each, the one that begins being another each time."""
    packages = {"this": OWN, "beside": other}
    results: Results = {name: [] for name in packages}
    for number in range(rounds):
        for name in sorted(packages, reverse=number % 2 == 0):
            progress(f"{method}, round {number + 1} of {rounds}: {name} ...")
            out = folder / f"{method} {number} {name}"
            asked = {"masks": list(map(str, masks)), "out": str(out), "method": method, "lines": lines}
            results[name].append(run_job(packages[name], asked))
    return results


def differing(results: Results) -> list[str]:
    """Pairs whose F or verdict is not the same in every run, bit for bit."""
    runs = [run["pairs"] for some in results.values() for run in some]
    names = dict.fromkeys(name for pairs in runs for name in pairs)
    return [name for name in names if any(pairs.get(name) != runs[0].get(name) for pairs in runs)]


def compared(results: Results) -> dict[str, Any]:
    """Medians of both, and of the ratios of this checkout to the other in each round."""
    pairs = len(results["this"][0]["pairs"])
    summary: dict[str, Any] = {"pairs": pairs, "differing": differing(results)}
    for what in ("seconds", "cpu"):
        this, beside = (np.array([run[what] for run in results[name]]) for name in ("this", "beside"))
        ratios = this / beside
        summary[what] = {
            "this": float(np.median(this)),
            "beside": float(np.median(beside)),
            "this, a pair": float(np.median(this)) / pairs,
            "beside, a pair": float(np.median(beside)) / pairs,
            "ratio": float(np.median(ratios)),
            "ratios": [float(ratio) for ratio in ratios],
        }
    return summary


def report(summary: dict[str, Any]) -> str:
    """Both times in a table, and whether all came out the same."""
    pairs, differ = summary["pairs"], summary["differing"]
    rows = []
    for what, words in (("seconds", "seconds"), ("cpu", "CPU seconds of all threads")):
        one = summary[what]
        each = [f"{one[name]:.1f}, {one[f'{name}, a pair']:.4f}" for name in ("this", "beside")]
        low, high = min(one["ratios"]), max(one["ratios"])
        rows.append([words, *each, f"{one['ratio']:.3f}", f"{low:.3f} to {high:.3f}"])
    head = ["median", "this, a pair", "beside, a pair", "this : beside", "in rounds"]
    same = f"F and verdict of all {pairs} pairs are the same in every run, bit for bit"
    if differ:
        same = f"F or verdict of {len(differ)} of {pairs} pairs are not the same: {', '.join(differ)}"
    return f"{table(head, rows)}\n\n{same}"
