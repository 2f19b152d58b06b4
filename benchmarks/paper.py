"""The paper's figures beside ours: its method (``method="lines"``), its settings, scenes like its own.

Cubes and thin cubes are made after its description, people stand in for PETS2009.
"""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass

from common import Outcome, measure_scene
from options import add_common, add_first_pairs, add_frames, add_names, add_seeds
from tables import mean, percent, progress, px, table, worst, write_json

from epibar import synthetic
from epibar.evaluation import good_pair
from epibar.synthetic import Scene


@dataclass(frozen=True)
class Row:
    """A dataset of the paper: our scene, and what the paper says (§4.1 and table 1)."""

    make: Callable[..., Scene]
    true_candidates: float
    error: float
    good: str


ROWS = {
    "cubes": Row(lambda seed, frames: synthetic.cubes(seed, cameras=5, frames=frames), 0.7167, 0.31, "10/10"),
    "thin": Row(
        lambda seed, frames: synthetic.thin_cubes(seed, cameras=7, frames=frames), 0.678, 0.79, "21/21"
    ),
    "people": Row(lambda seed, frames: synthetic.people(seed, cameras=4, frames=frames), 0.3781, 1.69, "5/6"),
}

HEADER = [
    "scene",
    "pairs",
    "true candidates: paper",
    "ours",
    "good pairs: paper",
    "ours, over the volume",
    "ours, over the image",
    "mean error, px: paper",
    "ours, volume, good",
    "ours, image, good",
    "ours, volume, all",
    "ours, image, all",
    "worst, volume",
    "s per pair",
]


def summary(name: str, outcomes: list[Outcome]) -> dict[str, object]:
    """Return the figures of one dataset."""
    row, count = ROWS[name], len(outcomes)
    good_volume = [o for o in outcomes if o.good]
    good_image = [o for o in outcomes if good_pair(o.image_error)]
    return {
        "scene": name,
        "pairs": count,
        "paper_true_candidates": row.true_candidates,
        "true_candidates": mean(o.true_candidates for o in outcomes),
        "paper_good": row.good,
        "good_volume": len(good_volume),
        "good_image": len(good_image),
        "paper_error": row.error,
        "error_volume_good": mean(o.error for o in good_volume),
        "error_image_good": mean(o.image_error for o in good_image),
        "error_volume": mean(o.error for o in outcomes),
        "error_image": mean(o.image_error for o in outcomes),
        "worst_volume": worst(o.error for o in outcomes),
        "without_F": sum(o.F is None for o in outcomes),
        "seconds": mean(o.seconds for o in outcomes),
    }


def cells(s: dict) -> list[str]:
    """Return the figures as a row of the table."""
    return [
        s["scene"],
        str(s["pairs"]),
        percent(s["paper_true_candidates"], 2),
        percent(s["true_candidates"], 2),
        s["paper_good"],
        f"{s['good_volume']}/{s['pairs']}",
        f"{s['good_image']}/{s['pairs']}",
        px(s["paper_error"]),
        px(s["error_volume_good"]),
        px(s["error_image_good"]),
        px(s["error_volume"]),
        px(s["error_image"]),
        px(s["worst_volume"]),
        f"{s['seconds']:.1f}",
    ]


def main() -> None:
    parser = ArgumentParser(description=__doc__.splitlines()[0])
    add_common(parser, lines=200_000)
    add_names(parser, "--scenes", ROWS)
    add_seeds(parser, 1)
    add_frames(parser, 800)
    add_first_pairs(parser)
    args = parser.parse_args()

    outcomes: list[Outcome] = []
    summaries = []
    for name in args.scenes:
        of_scene: list[Outcome] = []
        for seed in args.seeds:
            progress(f"{name}, seed {seed} ...")
            of_scene += measure_scene(
                ROWS[name].make(seed, args.frames),
                name,
                seed,
                args.lines,
                ["lines"],
                args.pairs,
                (lambda outcome: progress(outcome.line())) if args.verbose else None,
            )
        outcomes += of_scene
        summaries.append(summary(name, of_scene))
        write_json(args.json, args, outcomes, summaries)
    print(f'method="lines", {args.lines} lines per camera, {args.frames} frames, seeds {args.seeds}\n')
    print(table(HEADER, map(cells, summaries)))


if __name__ == "__main__":
    main()
