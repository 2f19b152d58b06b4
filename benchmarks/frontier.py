"""How good the methods are, and how far to trust their verdicts, on made-up scenes with known cameras."""

from __future__ import annotations

from argparse import ArgumentParser
from itertools import groupby

from common import FACTORS, SCENES, Outcome, measure_scene
from options import METHODS, add_common, add_first_pairs, add_frames, add_method, add_names, add_seeds
from tables import counted, mean, percent, progress, px, table, worst, write_json

HEADER = [
    "scene",
    "method",
    "pairs",
    "good",
    "no F",
    "mean px, good",
    "mean px, all",
    "worst px",
    "image px, all",
    "accepted",
    "wrongly accepted",
    "refused though good",
    *(f"error < {factor} x expected" for factor in FACTORS),
    "true candidates",
    "s per pair",
    "winners' sources",
]


def summary(scene: str, method: str, outcomes: list[Outcome]) -> dict[str, object]:
    """Return the figures of one scene by one method."""
    accepted = [o for o in outcomes if o.accepted]
    good = [o for o in outcomes if o.good]
    return {
        "scene": scene,
        "method": method,
        "pairs": len(outcomes),
        "good": len(good),
        "without_F": sum(o.F is None for o in outcomes),
        "mean_good": mean(o.error for o in good),
        "mean": mean(o.error for o in outcomes),
        "worst": worst(o.error for o in outcomes),
        "image_mean": mean(o.image_error for o in outcomes),
        "accepted": len(accepted),
        "wrongly_accepted": sum(o.wrongly_accepted for o in outcomes),
        "refused_though_good": sum(o.refused_though_good for o in outcomes),
        "within_expected": {
            str(factor): mean(float(o.error < factor * o.expected_error) for o in accepted)
            for factor in FACTORS
        },
        "true_candidates": mean(o.true_candidates for o in outcomes),
        "seconds": mean(o.seconds for o in outcomes),
        "sources": counted(o.source for o in outcomes),
        "refusals": counted(o.kind for o in outcomes if not o.accepted),
    }


def cells(s: dict) -> list[str]:
    """Return the figures as a row of the table."""
    return [
        s["scene"],
        s["method"],
        str(s["pairs"]),
        str(s["good"]),
        str(s["without_F"]),
        px(s["mean_good"]),
        px(s["mean"]),
        px(s["worst"]),
        px(s["image_mean"]),
        str(s["accepted"]),
        str(s["wrongly_accepted"]),
        str(s["refused_though_good"]),
        *(percent(s["within_expected"][str(factor)]) for factor in FACTORS),
        percent(s["true_candidates"]),
        f"{s['seconds']:.1f}",
        s["sources"],
    ]


def summaries(outcomes: list[Outcome]) -> list[dict[str, object]]:
    """Return the figures of every scene by every method, and of all scenes together."""

    def key(outcome: Outcome) -> tuple[str, str]:
        return outcome.method, outcome.scene

    # Sorting is stable: within a method the scenes stay in the order they were asked for.
    ordered = sorted(outcomes, key=lambda o: o.method)
    rows = [summary(scene, method, list(group)) for (method, scene), group in groupby(ordered, key)]
    if len({o.scene for o in outcomes}) > 1:
        rows += [summary("all", m, list(group)) for m, group in groupby(ordered, lambda o: o.method)]
    return rows


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    add_common(parser, lines=20_000)
    add_names(parser, "--scenes", SCENES)
    add_seeds(parser, 5)
    add_method(parser)
    add_frames(parser, 800)
    add_first_pairs(parser)
    parser.add_argument(
        "--focal-error",
        type=float,
        metavar="SHARE",
        help="tell the camera matrices, with focal lengths wrong by this share (0: the true ones)",
    )
    args = parser.parse_args()

    outcomes: list[Outcome] = []
    for name in args.scenes:
        for seed in args.seeds:
            progress(f"{name}, seed {seed} ...")
            outcomes += measure_scene(
                SCENES[name](seed, args.frames),
                name,
                seed,
                args.lines,
                METHODS[args.method],
                args.pairs,
                (lambda outcome: print(outcome.line(), flush=True)) if args.verbose else None,
                args.focal_error,
            )
            write_json(args.json, args, outcomes, summaries(outcomes))
    print(f"\n{args.lines} lines per camera, {args.frames} frames, seeds {args.seeds}\n")
    print(table(HEADER, map(cells, summaries(outcomes))))
    wrong = [outcome for outcome in outcomes if outcome.wrongly_accepted]
    if wrong:
        print("\nWrongly accepted:\n" + "\n".join(f"- {outcome.line()}" for outcome in wrong))


if __name__ == "__main__":
    main()
