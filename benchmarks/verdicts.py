"""Can the verdict be trusted? Pairs that have no answer must be refused, pairs that have one accepted."""

from __future__ import annotations

import math
import time
from argparse import ArgumentParser
from dataclasses import asdict, dataclass

from options import METHODS, Method, add_common, add_frames, add_method, add_names, natural, numbers
from tables import counted, percent, progress, px, table, write_json
from verdict_cases import CASES, Pair

import epibar
from epibar.evaluation import GOOD_PAIR_PX, compare

CONFIDENCE = 0.95

HEADER = [
    "case",
    "answer",
    "pairs",
    "accepted",
    "refused",
    "wrongly accepted",
    "false rate, 95 % bound",
    "good but refused",
    "refused as",
    "s per pair",
]


@dataclass(frozen=True)
class Judgement:
    """What was said of one pair. Errors in pixels, NaN where there is no truth or no F."""

    case: str
    number: int
    method: str
    answerable: bool
    accepted: bool
    kind: str
    reason: str
    source: str
    error: float
    image_error: float
    expected_error: float
    evidence: dict[str, float]
    seconds: float

    @property
    def wrongly_accepted(self) -> bool:
        """Accepted, though 3 px or more off over the volume; without an answer, over the image too.

        Where the motion leaves F undetermined a wrong F may fit all that moved, so that is not enough there.
        """
        if not self.accepted:
            return False
        errors = (self.error,) if self.answerable else (self.error, self.image_error)
        return not all(error < GOOD_PAIR_PX for error in errors)

    @property
    def refused_though_good(self) -> bool:
        """A pair with an answer, whose F was good, was refused."""
        return self.answerable and not self.accepted and self.error < GOOD_PAIR_PX

    def line(self) -> str:
        """The judgement in one line."""
        flag = " WRONG" if self.wrongly_accepted else ""
        error = "" if math.isnan(self.error) else f", {px(self.error)} px over the volume"
        return f"{self.case} {self.number} {self.method}: {self.kind}{flag}{error}. {self.reason}"


def upper_bound(wrong: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """One-sided exact (Clopper-Pearson) upper bound of a rate of which ``wrong`` in ``trials`` was seen.

    It is the largest rate at which so few would still come with probability 1 - confidence.
    """
    if trials == 0 or wrong >= trials:
        return math.nan if trials == 0 else 1.0

    def at_most(rate: float) -> float:
        return sum(math.comb(trials, k) * rate**k * (1 - rate) ** (trials - k) for k in range(wrong + 1))

    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if at_most(middle) > 1 - confidence else (low, middle)
    return high


def judge(case: str, number: int, pair: Pair, method: Method) -> Judgement:
    """Calibrate a pair, and hold the result against its truth where it has one."""
    started = time.perf_counter()
    cal = epibar.calibrate(pair.a, pair.b, method=method, seed=number)
    seconds = time.perf_counter() - started
    error = image_error = math.nan
    if cal.F is not None and pair.truth is not None:
        figures = compare(cal.F, pair.truth, pair.a.size, pair.b.size, pair.volume)
        error, image_error = figures.volume_error, figures.image_error
    return Judgement(
        case=case,
        number=number,
        method=method,
        answerable=CASES[case].answerable,
        accepted=cal.accepted,
        kind=cal.kind,
        reason=cal.reason,
        source=cal.source,
        error=error,
        image_error=image_error,
        expected_error=math.nan if cal.expected_error is None else cal.expected_error,
        evidence=dict(cal.evidence),
        seconds=seconds,
    )


def summary(name: str, answer: str, judgements: list[Judgement]) -> dict[str, object]:
    """Return the figures of one case, or of several together."""
    wrong = sum(j.wrongly_accepted for j in judgements)
    return {
        "case": name,
        "answer": answer,
        "pairs": len(judgements),
        "accepted": sum(j.accepted for j in judgements),
        "refused": sum(not j.accepted for j in judgements),
        "wrongly_accepted": wrong,
        "false_rate_bound": upper_bound(wrong, len(judgements)),
        "refused_though_good": sum(j.refused_though_good for j in judgements),
        "refusals": counted(j.kind for j in judgements if not j.accepted),
        "seconds": sum(j.seconds for j in judgements) / max(len(judgements), 1),
    }


def summaries(judgements: list[Judgement], method: str) -> list[dict[str, object]]:
    """Return a row for every case, and one for all without and one for all with an answer."""
    chosen = [j for j in judgements if j.method == method]
    rows = []
    for answerable, answer in ((False, "no"), (True, "yes")):
        group = [j for j in chosen if j.answerable == answerable]
        for case in dict.fromkeys(j.case for j in group):
            rows.append(summary(case, answer, [j for j in group if j.case == case]))
        if group:
            rows.append(summary(f"all, answer: {answer}", answer, group))
    return rows


def cells(s: dict) -> list[str]:
    """Return the figures as a row of the table."""
    return [
        s["case"],
        s["answer"],
        *(str(s[key]) for key in ("pairs", "accepted", "refused", "wrongly_accepted")),
        percent(s["false_rate_bound"]),
        str(s["refused_though_good"]) if s["answer"] == "yes" else "-",
        s["refusals"] or "-",
        f"{s['seconds']:.1f}",
    ]


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    add_common(parser, lines=8_000)
    parser.add_argument("--pairs", type=natural, default=5, help="of each case (default %(default)s)")
    parser.add_argument("--numbers", type=numbers, help="only these of the pairs, such as 3 or 6-10")
    add_frames(parser, 400)
    add_names(parser, "--cases", CASES)
    add_method(parser)
    args = parser.parse_args()

    methods = METHODS[args.method]
    judgements: list[Judgement] = []
    for name in args.cases:
        # A case without chance in it is made once.
        for number in (args.numbers or range(1, args.pairs + 1)) if CASES[name].repeats else [1]:
            progress(f"{name} {number} ...")
            pair = CASES[name].make(number, args.frames, args.lines)
            for method in methods:
                judgements.append(judge(name, number, pair, method))
                if args.verbose:
                    print(judgements[-1].line(), flush=True)
        rows = {method: summaries(judgements, method) for method in methods}
        write_json(args.json, args, [asdict(j) for j in judgements], rows)
    for method in methods:
        print(f'\nmethod="{method}", {args.lines} lines per camera, {args.frames} frames\n')
        print(table(HEADER, map(cells, summaries(judgements, method))))
    wrong = [judgement for judgement in judgements if judgement.wrongly_accepted]
    if wrong:
        print("\nWrongly accepted:\n" + "\n".join(f"- {judgement.line()}" for judgement in wrong))


if __name__ == "__main__":
    main()
