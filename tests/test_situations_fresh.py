"""The program that measures on fresh situations: seeds, what counts as right, and going on after a break."""

import json
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture(scope="module")
def programs():
    """The measuring programs, which are no package."""
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import fresh
        import fresh_report
        import fresh_seeds

        yield fresh, fresh_report, fresh_seeds
    finally:
        sys.path.remove(str(BENCHMARKS))


def outcome(**changes):
    return {
        "family": "low",
        "seed": 1,
        "pair": "1-2",
        "method": "frontier",
        "answer": True,
        "why_not": "",
        "truth": True,
        "accepted": True,
        "kind": "accepted",
        "stated": 0.3,
        "error": 0.2,
        "room_error": 0.4,
        "image_error": 1.0,
        "bound": 0.1,
        "seconds": 1.0,
        **changes,
    }


def test_seeds_of_a_commit_are_never_those_of_development(programs):
    fresh, _, seeds = programs
    found = {seeds.commit_seed("abc", family, index) for family in ("low", "high") for index in range(50)}
    assert len(found) == 100
    assert min(found) >= 2**63 > fresh.DEVELOPMENT_SEEDS
    assert max(found) < 2**64
    assert seeds.commit_seed("abc", "low", 3) == seeds.commit_seed("abc", "low", 3)
    assert seeds.commit_seed("abd", "low", 3) not in found


def test_what_is_right(programs):
    _, report, _ = programs
    assert report.right(outcome())
    assert not report.right(outcome(error=3.1))
    assert not report.right(outcome(error=None))
    assert not report.right(outcome(offset_error=0.6))
    assert report.right(outcome(offset_error=-0.1, room_error=50.0))
    assert not report.right(outcome(answer=False, room_error=29.0))
    assert report.right(outcome(answer=False))
    assert not report.right(outcome(answer=False, truth=False, error=0.1))


def test_tables_keep_families_apart(programs):
    _, report, _ = programs
    outcomes = [
        *(outcome(seed=seed) for seed in range(58)),
        outcome(seed=58, error=0.5, swapped=True, other_seeds=[True, False]),
        outcome(family="high", error=788.0, seed=7),
        outcome(
            family="unrelated", answer=False, truth=False, why_not="unrelated", accepted=False, kind="no"
        ),
    ]
    text = report.report(outcomes, {"low": report.Counter({"little in common": 2})}, "seeds", 100)
    assert "high 7 1-2: 788.00 px over the volume" in text
    assert "low (little in common 2)" in text
    steady = [line for line in text.splitlines() if line.startswith("| low")][1]
    assert "100.0 %" in steady
    assert "0.0 %" in steady
    answered = next(line for line in text.splitlines() if line.startswith("| low"))
    assert "5.0 %" in answered  # 1 − 0.05^(1/59), nothing wrong in 59
    assert "98.3 %" in answered  # 58 of 59 errors not above what was stated


def test_an_interrupted_run_goes_on(programs, tmp_path, monkeypatch, capsys):
    fresh, _, _ = programs
    path = tmp_path / "fresh.jsonl"
    job = fresh.Job("few", 1, ("lines",), 300, 1, False, 1)
    done = fresh.run(job)
    assert len(done["outcomes"]) == 1
    assert done["outcomes"][0]["frames"] > 100
    path.write_text(json.dumps({"key": job.key, **done}) + '\n{"key": "cut o')
    words = ["fresh.py", "--seeds", "1", "--families", "few", "--pairs", "1", "--lines", "300"]
    monkeypatch.setattr(sys, "argv", [*words, "--method", "lines", "--out", str(path)])
    fresh.main()
    shown = capsys.readouterr()
    assert "1 situations, 1 of them done" in shown.err
    assert "cut off" in shown.err
    assert "| few" in shown.out
    assert path.read_text().endswith("\n")


def test_a_seed_of_a_commit_cannot_be_given_by_hand(programs, monkeypatch, tmp_path):
    fresh, _, _ = programs
    monkeypatch.setattr(sys, "argv", ["fresh.py", "--seeds", str(2**63), "--out", str(tmp_path / "x")])
    with pytest.raises(SystemExit, match="development"):
        fresh.main()
