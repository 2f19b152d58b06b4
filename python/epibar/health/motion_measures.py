"""How much moved in a recording, and where: the numbers behind :func:`epibar.inspect`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .. import _core
from ..arguments import AnyArray, Array, Index
from ..geometry.lines import area_between_lines, lines_through
from ..recording import Recording

__all__ = ["lines_left", "share_by_ninth", "spread_of", "straightness_of"]

INFORMATIVE_SHARE = 0.05
INFORMATIVE_CHANGES, FRAMES_PER_CHANGE = 8, 25
"""What the compiled matcher asks of a line: motion in 5 % of the frames, none in 5 %, eight changes, or one
in 25 frames where the recording is short."""
PATH_OVERLAP = 3.0
"""Image widths: an area between two lines below this means that one runs along the other (paper, 3.2)."""
MOST_MOTION = 0.95
ROWS_AT_ONCE = 2000
LEAST_SILHOUETTES = 50
SHORTEST_PATH = 0.2
"""Of the image diagonal; on a shorter way nothing can be said."""
PATH_TRIMMED = 0.9
HEADS_SLACK = 3.0
"""People differ in height, so heads on one path stray more than feet do."""


def lines_left(recording: Recording, arrays: Mapping[str, AnyArray]) -> tuple[dict[str, int], int]:
    """Count the lines left after each filter, and the straight paths."""
    frames = recording.frames
    least = max(1, int(np.ceil(INFORMATIVE_SHARE * frames)))
    changes_asked = min(INFORMATIVE_CHANGES, max(frames // FRAMES_PER_CHANGE, 1))
    packed = arrays["barcodes"]
    ones, changes = np.empty(len(packed), np.int64), np.empty(len(packed), np.int64)
    for start in range(0, len(packed), ROWS_AT_ONCE):
        rows = np.ascontiguousarray(packed[start : start + ROWS_AT_ONCE]).astype("<u8").view(np.uint8)
        bits = np.unpackbits(rows, axis=1, count=frames, bitorder="little")
        ones[start : start + len(bits)] = bits.sum(axis=1, dtype=np.int64)
        changes[start : start + len(bits)] = np.count_nonzero(bits[:, 1:] != bits[:, :-1], axis=1)
    crossed = ones >= least
    free = crossed & (frames - ones >= least)
    informative = free & (changes >= changes_asked)
    paths = _core.motion_lines(recording._core)
    off = informative.copy()
    for path in paths:
        lines = lines_through(arrays["segments"][off])
        apart = area_between_lines(lines, np.broadcast_to(path, lines.shape), recording.size)
        off[off] = np.asarray(apart) >= PATH_OVERLAP * recording.width
    counts = {"crossed": crossed, "free": free, "informative": informative, "off_paths": off}
    return {
        "drawn": len(packed),
        **{name: int(np.count_nonzero(kept)) for name, kept in counts.items()},
    }, len(paths)


def spread_of(heat: Array) -> float:
    """Least share of the pixels that hold most of the motion."""
    hottest = np.cumsum(np.sort(heat, axis=None)[::-1])
    if hottest[-1] == 0:
        return 0.0
    return float((np.searchsorted(hottest, MOST_MOTION * hottest[-1]) + 1) / heat.size)


def share_by_ninth(heat: Array) -> Array:
    """Share of all motion in each ninth of the image."""
    ninths = [
        [part.sum() for part in np.array_split(rows, 3, axis=1)] for rows in np.array_split(heat, 3, axis=0)
    ]
    sums = np.array(ninths)
    shares: Array = sums / max(sums.sum(), 1.0)
    return shares


def straightness_of(arrays: Mapping[str, AnyArray], size: tuple[int, int]) -> float:
    """How far the lowest and highest points of the silhouettes stray from a straight line each, the larger.

    Feet on one path are on one line in the image, and so are heads. Heads alone are not enough: under a low
    camera they are on the horizon wherever people walk.
    """
    whole = ~np.asarray(arrays["hull_border"], dtype=bool)
    starts = arrays["hull_start"].astype(np.int64)
    if np.count_nonzero(whole) < LEAST_SILHOUETTES:
        return float("nan")
    points = arrays["hull_points"].astype(np.float64)
    diagonal = float(np.hypot(*size))
    strays = []
    for sign, slack in ((1.0, 1.0), (-1.0, HEADS_SLACK)):
        ends = _extremes(points, starts, sign)[whole]
        width, length = _band(ends)
        if length < SHORTEST_PATH * diagonal:
            return float("nan")
        strays.append(width / diagonal / slack)
    return max(strays)


def _extremes(points: Array, starts: Index, sign: float) -> Array:
    """Lowest (sign 1) or highest (sign −1) vertex of each hull, (n, 2)."""
    hull = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    order = np.lexsort((-sign * points[:, 1], hull))
    return points[order[starts[:-1]]]


def _band(points: Array) -> tuple[float, float]:
    """Half width and length of the straight band that holds most of the points, (n, 2)."""
    kept = points
    for _ in range(6):
        centre = kept.mean(axis=0)
        axes = np.linalg.svd(kept - centre, full_matrices=False)[2]
        across = np.abs((points - centre) @ axes[1])
        width = float(np.quantile(across, PATH_TRIMMED))
        kept = points[across <= width]
    along = (points - centre) @ axes[0]
    return width, float(np.quantile(along, 0.95) - np.quantile(along, 0.05))
