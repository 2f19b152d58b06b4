"""Draw ``docs/lines_and_tangents.png``: low cameras, which line pairs get wrong and tangents get right.

Run ``.venv/bin/python docs/make_pictures.py`` from the root of the repository, after ``make build``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

import epibar
from epibar import synthetic
from epibar.evaluation import compare
from epibar.synthetic import Scene

Array = NDArray[np.float64]

TARGET = Path(__file__).parent / "lines_and_tangents.png"
SEED = 2
PAIR = (0, 1)
FRAMES = 800
LINES = 20_000
PARTS = 7
"""Parts of a walker in `synthetic.people`: all heads come first, then all trunks, hips and limbs."""
MARKED = (3, 0, 3)
"""Which part of the left, the middle and the right walker carries lines: a limb, the head, a limb."""

LOOKS = {
    "true": {"color": "#000000", "linewidth": 3.2, "linestyle": "-", "alpha": 0.35},
    "lines": {"color": "#d55e00", "linewidth": 1.3, "linestyle": "-"},
    "frontier": {"color": "#0072b2", "linewidth": 1.3, "linestyle": (0, (5, 3))},
}


def spots(scene: Scene) -> Array:
    """Project the parts of the walkers: (frames, parts, walkers, 2 cameras, 2), NaN outside an image."""
    centres = scene.solids.centres.reshape(-1, 3)
    found = []
    for camera in (scene.cameras[k] for k in PAIR):
        pixels = camera.project(centres)[0]
        inside = np.all((pixels > 10) & (pixels < np.array(camera.size) - 10), axis=1)
        found.append(np.where(inside[:, None], pixels, np.nan).reshape(scene.frames, PARTS, -1, 2))
    return np.stack(found, axis=3)


def telling_frame(places: Array) -> tuple[int, Array]:
    """Choose a frame whose marked walkers stand well apart, and return the spots: (n, 2 cameras, 2)."""
    best: tuple[float, int, Array] = (-1.0, 0, np.empty((0, 2, 2)))
    for frame in range(0, len(places), 5):
        seen = np.flatnonzero(np.isfinite(places[frame]).all(axis=(0, 2, 3)))
        if len(seen) < len(MARKED):
            continue
        # From left to right in A.
        order = seen[np.argsort(places[frame, 0, seen, 0, 0])]
        walkers = order[np.linspace(0, len(order) - 1, len(MARKED)).round().astype(int)]
        chosen = places[frame, MARKED, walkers]
        gap = min(float(np.diff(np.sort(chosen[:, view, 0])).min()) for view in (0, 1))
        if gap > best[0]:
            best = (gap, frame, chosen)
    return best[1], best[2]


def draw_line(axes: Axes, line: Array, size: tuple[int, int], look: dict[str, object]) -> None:
    """Draw a homogeneous line across an image."""
    a, b, c = line
    if abs(b) >= abs(a):
        x = np.array([-1.0, size[0]])
        axes.plot(x, -(a * x + c) / b, **look)
    else:
        y = np.array([-1.0, size[1]])
        axes.plot(-(b * y + c) / a, y, **look)


def main() -> None:
    """Calibrate the pair by both methods and draw it."""
    scene = synthetic.people(seed=SEED, camera_height=synthetic.LOW_CAMERAS, frames=FRAMES)
    masks = [scene.masks(k) for k in PAIR]
    recordings = [
        epibar.Recording.from_masks(m, fps=scene.fps, lines=LINES, seed=k)
        for k, m in zip(PAIR, masks, strict=True)
    ]
    sizes = [scene.cameras[k].size for k in PAIR]
    truth, volume = scene.fundamental(*PAIR), scene.volume_correspondences(*PAIR)
    matrices, names = {"true": truth}, {"true": "true epipolar lines"}
    for method in ("lines", "frontier"):
        cal = epibar.calibrate(*recordings, method=method, seed=SEED)
        if cal.F is None:
            raise SystemExit(f"{method}: {cal.reason}")
        error = compare(cal.F, truth, *sizes, volume).volume_error
        matrices[method] = cal.F
        verdict = cal.kind.replace("_", " ")
        names[method] = f'method="{method}": {error:.2g} px from the truth, verdict: {verdict}'

    frame, chosen = telling_frame(spots(scene))
    mpl.rcParams["font.size"] = 9
    figure = Figure(figsize=(11, 4.9), layout="constrained")
    both = figure.subplots(1, 2)
    for view, axes in enumerate(both):
        size = sizes[view]
        image = np.where(masks[view][frame] > 0, 0.68, 1.0)
        axes.imshow(image, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
        for method, F in matrices.items():
            for places in chosen:
                # The line of a spot in this image, from where the other camera sees it.
                other = np.append(places[1 - view], 1.0)
                draw_line(axes, F @ other if view == 1 else F.T @ other, size, LOOKS[method])
        for number, (x, y) in enumerate(chosen[:, view], 1):
            axes.plot(x, y, "o", color="black", markersize=5, markerfacecolor="#f0e442", zorder=5)
            axes.annotate(str(number), (x, y), (6, 6), textcoords="offset points", weight="bold", zorder=5)
        axes.set(xlim=(-0.5, size[0] - 0.5), ylim=(size[1] - 0.5, -0.5), xticks=[], yticks=[])
        axes.set_title(f"camera {'AB'[view]}, with the epipolar lines of the spots in camera {'BA'[view]}")
    handles = [Line2D([], [], label=names[method], **LOOKS[method]) for method in matrices]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    figure.savefig(TARGET, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
