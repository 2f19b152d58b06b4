"""How good are silhouettes, and at what cost? Background models on made-up video with known masks."""

from __future__ import annotations

import time
from argparse import ArgumentParser
from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray
from options import numbers
from tables import mean, percent, table

from epibar import synthetic
from epibar.foreground import METHODS, Foreground, ForegroundOptions

Image = NDArray[np.uint8]

PRIMED_EVERY = 2
"""Frames of which one teaches the empty scene."""
SHADE = 0.65
"""Brightness that a cast shadow leaves."""
LEAST_OBJECT = 0.0005
"""Share of the image; what is smaller is removed on purpose."""

FOOTAGE: dict[str, tuple[float, float, bool]] = {
    "clean": (1.0, 0.0, False),
    "noisy": (8.0, 0.006, False),
    "shadows": (2.5, 0.006, True),
    "flickering": (2.5, 0.04, False),
}
"""Noise in grey levels, flicker as a share, and whether bodies cast shadows."""


@dataclass
class Score:
    """What was counted over the frames of one method."""

    outline: list[float] = field(default_factory=list)
    missed: int = 0
    false: int = 0
    objects: int = 0
    cpu: float = 0.0


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", default="1280x720,1920x1080", help="default: %(default)s")
    parser.add_argument("--seeds", type=numbers, default=[1], help="1-3; default: 1")
    parser.add_argument("--frames", type=int, default=80, help="over 32 seconds; default: %(default)s")
    parser.add_argument("--footage", default=",".join(FOOTAGE), help="default: %(default)s")
    parser.add_argument(
        "--methods", default="mog2,mixture", help=f"of {', '.join(METHODS)}; default: %(default)s"
    )
    args = parser.parse_args()
    rows = []
    for size in args.sizes.split(","):
        width, height = map(int, size.split("x"))
        for footage in args.footage.split(","):
            scores = {method: Score() for method in args.methods.split(",")}
            for seed in args.seeds:
                fps = args.frames / 32
                scene = synthetic.people(seed, cameras=1, frames=args.frames, size=(width, height), fps=fps)
                measure(scene, seed, footage, scores)
            for method, score in scores.items():
                rows.append(
                    (
                        f"{size} {footage}",
                        method,
                        percent(mean(score.outline)),
                        f"{score.missed} of {score.objects}",
                        score.false,
                        f"{1000 * score.cpu / max(1, len(score.outline)):.1f}",
                    )
                )
    print(table(("footage", "method", "outline within 1 px", "missed", "false", "CPU ms a frame"), rows))


def measure(scene: synthetic.Scene, seed: int, footage: str, scores: dict[str, Score]) -> None:
    """Run every method over one camera's frames."""
    film = list(filmed(scene, seed, footage))
    for method, score in scores.items():
        foreground = Foreground(ForegroundOptions(method=method))
        foreground.prime(frame for frame, _ in film[::PRIMED_EVERY])
        for frame, truth in film:
            started = time.process_time()
            mask = foreground.apply(frame)
            score.cpu += time.process_time() - started
            count(score, mask, truth)


def filmed(scene: synthetic.Scene, seed: int, footage: str) -> Iterator[tuple[Image, Image]]:
    """Yield frames and true masks."""
    noise, flicker, shadows = FOOTAGE[footage]
    frames = synthetic.render_frames(scene, 0, seed, empty_frames=0, noise=noise, flicker=flicker)
    for frame, truth in zip(frames, scene.iter_masks(0), strict=True):
        yield shaded(frame, truth) if shadows else frame, truth


def shaded(frame: Image, truth: Image) -> Image:
    """Let every body cast a soft shadow to its right, on what is no body."""
    height, width = truth.shape
    shift = np.array([[1, 0, width / 40], [0, 0.5, 0.5 * height * 0.55]])
    cast = cv2.warpAffine(truth.astype(np.float32), shift, (width, height))
    cast = cv2.GaussianBlur(cast, (0, 0), width / 400) * (truth == 0)
    return np.rint(frame * (1 - (1 - SHADE) * cast)[..., None]).astype(np.uint8)


def count(score: Score, mask: Image, truth: Image) -> None:
    """Compare one mask with the truth."""
    square = np.ones((3, 3), np.uint8)
    outline, true_outline = (cv2.morphologyEx(m, cv2.MORPH_GRADIENT, square) for m in (mask, truth))
    if true_outline.any():
        both = ((outline, true_outline), (true_outline, outline))
        shares = [(a[cv2.dilate(b, square) > 0]).sum() / max(1, int(a.sum())) for a, b in both]
        score.outline.append(min(shares))
    for found, other, kind in ((truth, mask, "missed"), (mask, truth, "false")):
        labels, stats = cv2.connectedComponentsWithStats(found, connectivity=8)[1:3]
        for label in range(1, len(stats)):
            if stats[label, cv2.CC_STAT_AREA] < LEAST_OBJECT * mask.size:
                continue
            score.objects += kind == "missed"
            if not other[labels == label].any():
                setattr(score, kind, getattr(score, kind) + 1)


if __name__ == "__main__":
    main()
