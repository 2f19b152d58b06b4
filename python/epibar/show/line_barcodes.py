"""Pairs of lines with their barcodes: the picture that explains the method.

Barcodes come from the silhouettes, not from the recording's random lines: an epipolar line is none of these,
and most candidates were drawn later, where lines inform. A line meets a component exactly where it meets its
hull.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Bits, Index, Order
from ..calibration import Calibration
from ..geometry.epipolar import epipoles
from ..geometry.lines import clip_lines
from ..geometry.vectors import homogeneous
from ..recording import Recording

__all__ = ["WINDOW", "LineSet", "hull_barcodes", "line_sets"]

WINDOW = 600
"""Frames of a barcode that are shown: more would be narrower than a pixel."""

LINES = 7
POOL = 300
HALF_WIDTH = 0.35
"""Pixels: a hull this near a line is met by the line's pixels, as in `matching/densify.rs`."""
INFORMATIVE = (0.05, 0.95)
"""Share of frames with motion on the line."""


@dataclass(frozen=True, eq=False)
class LineSet:
    """Pairs of lines of one kind.

    Attributes
    ----------
    kind : str
        "epipolar": of the matrix; "inliers", "candidates": as the search matched them.
    lines_a, lines_b : ndarray, shape (n, 3)
    bits_a, bits_b : ndarray, shape (n, t), bool
        Barcodes over the frames that are shown.
    correlation : ndarray, shape (n,)
        Of these barcodes; NaN where one is constant.
    """

    kind: str
    lines_a: Array
    lines_b: Array
    bits_a: Bits
    bits_b: Bits
    correlation: Array


def hull_barcodes(recording: Recording, lines: Array, frames: Index) -> Bits:
    """Barcodes of any lines (n, 3) with a² + b² = 1, over some frames (t,): (n, t)."""
    bits = np.zeros((len(lines), len(frames)), np.bool_)
    for column, frame in enumerate(frames):
        hulls = recording.hulls(int(frame))
        if not hulls:
            continue
        starts = np.cumsum([0, *(len(hull) for hull in hulls[:-1])])
        distance = lines[:, :2] @ np.concatenate(hulls).T + lines[:, 2:]
        low = np.minimum.reduceat(distance, starts, axis=1)
        high = np.maximum.reduceat(distance, starts, axis=1)
        bits[:, column] = ((low <= HALF_WIDTH) & (high >= -HALF_WIDTH)).any(axis=1)
    return bits


def line_sets(a: Recording, b: Recording, calibration: Calibration, common: Index) -> list[LineSet]:
    """Choose the line pairs to show.

    Parameters
    ----------
    a, b : Recording
    calibration : Calibration
        Of the pair.
    common : ndarray, shape (t, 2)
        Frames of A and B over which the barcodes are shown.

    Returns
    -------
    list of LineSet
        Those that have any lines, the most telling first.
    """
    pools = []
    if calibration.F is not None:
        pools.append(("epipolar", *_epipolar_lines(calibration, a.size)))
    found = calibration.candidates
    chosen = np.flatnonzero(found.inliers)
    kind = "inliers" if len(chosen) else "candidates"
    if not len(chosen) and calibration.F is None:
        chosen = np.arange(len(found))
    pools.append((kind, found.lines_a[chosen[:POOL]], found.lines_b[chosen[:POOL]]))
    sets = (_telling(kind, lines_a, lines_b, a, b, common) for kind, lines_a, lines_b in pools)
    return [shown for shown in sets if len(shown.lines_a)]


def _epipolar_lines(calibration: Calibration, size: tuple[int, int]) -> tuple[Array, Array]:
    """Lines of A through its frontier points, and the same planes' lines in B."""
    assert calibration.F is not None
    points = calibration.frontier_points.a
    if not len(points):
        points = np.linspace(0.05, 0.95, 60)[:, None] * (np.array(size) - 1.0)
    points = points[np.unique(np.linspace(0, len(points) - 1, POOL).astype(int))]
    points = homogeneous(points)
    return np.cross(epipoles(calibration.F)[0], points), points @ calibration.F.T


def _telling(kind: str, lines_a: Array, lines_b: Array, a: Recording, b: Recording, common: Index) -> LineSet:
    """Keep lines that cross both images and whose places and barcodes in A differ most from each other.

    B's barcodes have no say, so how well they agree with A's is evidence and not selection.
    """
    usable = clip_lines(lines_a, a.size)[1] & clip_lines(lines_b, b.size)[1]
    lines_a, lines_b = _unit(lines_a[usable]), _unit(lines_b[usable])
    bits_a = hull_barcodes(a, lines_a, common[:, 0])
    chosen = _different(bits_a, clip_lines(lines_a, a.size)[0] / np.hypot(*a.size))
    chosen = chosen[_in_order(clip_lines(lines_a[chosen], a.size)[0].mean(axis=1))]
    lines_a, lines_b, bits_a = lines_a[chosen], lines_b[chosen], bits_a[chosen]
    bits_b = hull_barcodes(b, lines_b, common[:, 1])
    return LineSet(kind, lines_a, lines_b, bits_a, bits_b, _correlation(bits_a, bits_b))


def _unit(lines: Array) -> Array:
    return lines / np.hypot(lines[:, 0], lines[:, 1])[:, None]


def _in_order(middles: Array) -> Order:
    """Order lines across the image, from the top, along the axis on which their middles spread most."""
    if len(middles) < 2:
        return np.arange(len(middles))
    centred = middles - middles.mean(axis=0)
    axis = np.linalg.svd(centred)[2][0]
    return np.argsort(centred @ (axis if axis[1] >= 0 else -axis), kind="stable")


def _different(bits: Bits, segments: Array) -> Order:
    """Choose informative lines, each the farthest from those before it, in place and barcode alike."""
    share = bits.mean(axis=1) if bits.shape[1] else np.zeros(len(bits))
    pool = np.flatnonzero((share > INFORMATIVE[0]) & (share < INFORMATIVE[1]))
    chosen = list(pool[np.argsort(np.abs(share[pool] - 0.5), kind="stable")[:1]])
    apart = np.full(len(pool), np.inf)
    while chosen and len(chosen) < LINES:
        last = chosen[-1]
        unlike = (bits[pool] != bits[last]).mean(axis=1)
        straight = np.linalg.norm(segments[pool] - segments[last], axis=2).max(axis=1)
        turned = np.linalg.norm(segments[pool][:, ::-1] - segments[last], axis=2).max(axis=1)
        apart = np.minimum(apart, unlike * np.minimum(straight, turned))
        if not apart.max() > 0:
            break
        chosen.append(pool[int(apart.argmax())])
    return np.array(chosen, np.intp)


def _correlation(bits_a: Bits, bits_b: Bits) -> Array:
    x = bits_a - bits_a.mean(axis=1, keepdims=True) if bits_a.size else bits_a.astype(float)
    y = bits_b - bits_b.mean(axis=1, keepdims=True) if bits_b.size else bits_b.astype(float)
    norm = np.sqrt((x * x).sum(axis=1) * (y * y).sum(axis=1))
    result: Array = np.divide((x * y).sum(axis=1), norm, out=np.full(len(x), np.nan), where=norm > 0)
    return result
