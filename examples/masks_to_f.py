"""From masks of your own to a fundamental matrix, without a video in between.

Any segmenter will do that says for every frame which pixels move: a background model, a neural network's
person masks. Outlines, not boxes. Here a made-up scene stands in for it, so the answer is known.

Run with ``.venv/bin/python examples/masks_to_f.py``.
"""

from __future__ import annotations

import numpy as np

import epibar
from epibar import synthetic


def main() -> None:
    scene = synthetic.people(seed=3, walkers=4, frames=400, size=(480, 360))
    # (T, H, W) bool or uint8 for each camera, non-zero where something moves.
    masks_a, masks_b = scene.masks(0), scene.masks(2)

    rec_a = epibar.Recording.from_masks(masks_a, fps=scene.fps, lines=10_000)
    rec_b = epibar.Recording.from_masks(masks_b, fps=scene.fps, lines=10_000)
    cal = epibar.calibrate(rec_a, rec_b)

    print("accepted:", cal.accepted)
    print("reason:  ", cal.reason)
    with np.printoptions(precision=3):
        print("F =", cal.F, sep="\n")
    if cal.F is not None:
        points_a, points_b = scene.volume_correspondences(0, 2)
        error = epibar.symmetric_epipolar_distance(cal.F, points_a, points_b).mean()
        print(f"error over the volume where people walked: {error:.3f} px")


if __name__ == "__main__":
    main()
