"""A camera of a pair is panned or tilted while it films: is it noticed, and how far off is what is accepted?

The masks of camera B are moved on by some pixels from some frame on, which is what a small turn does to them.
With 0 pixels nothing has moved, and each refusal as ``knocked`` is a false one.
"""

from __future__ import annotations

from argparse import ArgumentParser
from typing import Any

import numpy as np
from options import add_common, add_frames, add_seeds, numbers
from tables import percent, progress, px, table, write_json

import epibar
from epibar import synthetic
from epibar.evaluation import GOOD_PAIR_PX

SIZE = (400, 300)
WAYS = {"pan": (1.0, 0.0), "tilt": (0.0, 1.0)}
WHEN = {"half": 0.5, "three quarters": 0.75}


def run(seed: int, frames: int, lines: int, moves: list[int]) -> list[dict[str, Any]]:
    """Calibrate a scene with every move of its second camera."""
    scene = synthetic.people(seed, cameras=2, walkers=6, frames=frames, size=SIZE, asymmetric=True)
    still = epibar.Recording.from_masks(scene.masks(0), lines=lines, seed=0, name="still")
    masks = scene.masks(1)
    points_a, points_b = scene.volume_correspondences(0, 1)
    found = []
    for way, direction in WAYS.items():
        for when, share in WHEN.items():
            for pixels in moves:
                moved = masks.copy()
                first, by = int(share * frames), np.round(np.multiply(pixels, direction)).astype(int)
                moved[first:] = np.roll(moved[first:], by, axis=(2, 1))
                b = epibar.Recording.from_masks(moved, lines=lines, seed=1, name="moved")
                cal = epibar.calibrate(still, b, seed=seed)
                if cal.F is None:
                    errors = [np.nan, np.nan]
                else:
                    errors = [
                        float(epibar.symmetric_epipolar_distance(cal.F, points_a, points_b + at).mean())
                        for at in (np.zeros(2), by)
                    ]
                found.append(
                    {
                        "seed": seed,
                        "way": way,
                        "when": when,
                        "pixels": pixels,
                        "kind": cal.kind,
                        "accepted": cal.accepted,
                        "holds": cal.evidence.get("holds", np.nan),
                        "before": errors[0],
                        "after": errors[1],
                    }
                )
                progress(str(found[-1]))
    return found


def cells(pixels: int, group: list[dict[str, Any]]) -> list[str]:
    """All pairs with moves of one size in a row of the table."""
    accepted = [g for g in group if g["accepted"]]
    wrong = [g for g in accepted if max(g["before"], g["after"]) > GOOD_PAIR_PX]
    holds = [g["holds"] for g in group if np.isfinite(g["holds"])]
    kinds = [kind for kind in sorted({g["kind"] for g in group}) if kind not in ("accepted", "knocked")]
    return [
        str(pixels),
        str(len(group)),
        percent(sum(g["kind"] == "knocked" for g in group) / len(group)),
        ", ".join(f"{kind} {sum(g['kind'] == kind for g in group)}" for kind in kinds) or "-",
        str(len(accepted)),
        px(max((max(g["before"], g["after"]) for g in accepted), default=np.nan)),
        str(len(wrong)),
        f"{min(holds):.2f} to {max(holds):.2f}" if holds else "-",
    ]


HEAD = (
    *("moved by, px", "pairs", "refused as moved", "refused otherwise", "accepted"),
    *("worst part of these, px", "accepted and wrong", "holds"),
)


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    add_common(parser, lines=6000)
    add_seeds(parser, 10)
    add_frames(parser, 400)
    parser.add_argument("--pixels", type=numbers, default=[0, 4, 8, 15, 40], help="default: 0,4,8,15,40")
    args = parser.parse_args()
    outcomes: list[dict[str, Any]] = []
    for seed in args.seeds:
        outcomes += run(seed, args.frames, args.lines, args.pixels)
        write_json(args.json, args, outcomes, {})
    groups = ((n, [o for o in outcomes if o["pixels"] == n]) for n in args.pixels)
    print(table(HEAD, (cells(n, group) for n, group in groups)))


if __name__ == "__main__":
    main()
