"""Scores of hypotheses, beside vectorised numpy and the whole loops of OpenCV and PoseLib."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from data import SIZE, Pair
from numpy.typing import NDArray
from numpy_scores import LineScore, TangentScore
from table import Stage
from timing import in_turn

from epibar import _core

HYPOTHESES = 10_000
CANDIDATES = 1000
FRAMES = 100
SOME = 200
"""Hypotheses of the slow peers; their seconds are scaled to all."""

Array = NDArray[np.float64]


def score_stages(pair: Pair) -> list[Stage]:
    """Line scores and tangent scores."""
    matrices = hypotheses(pair, HYPOTHESES)
    points = _point_loops()
    return [_lines(pair, matrices, points), _tangents(pair, matrices, points)]


def hypotheses(pair: Pair, count: int) -> Array:
    """Matrices of rank 2 around the true one: epipoles and homography moved at random; (count, 3, 3)."""
    rng = np.random.default_rng(5)
    truth = pair.scene.fundamental(0, 1)
    u, _, _ = np.linalg.svd(truth)
    scale = np.diag([1 / SIZE[0], 1 / SIZE[0], 1.0])
    e = scale @ u[:, 2]
    e = e / np.linalg.norm(e) + 0.2 * rng.normal(size=(count, 3)) * (np.arange(count) > 0)[:, None]
    cross = np.zeros((count, 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -e[:, 2], e[:, 1], -e[:, 0]
    cross -= cross.transpose(0, 2, 1)
    normal = np.linalg.inv(scale) @ truth @ np.linalg.inv(scale)
    homography = -cross[0] @ normal / (e[0] @ e[0])
    moved = (
        homography
        + 0.1
        * np.linalg.norm(homography)
        * rng.normal(size=(count, 3, 3))
        * (np.arange(count) > 0)[:, None, None]
    )
    found = scale @ (cross @ moved) @ scale
    return found / np.linalg.norm(found, axis=(1, 2), keepdims=True)


def _lines(pair: Pair, matrices: Array, points: tuple[dict[str, float], list[str]]) -> Stage:
    """Against 1,000 pairs of lines, some of them epipolar."""
    rng = np.random.default_rng(6)
    in_a = np.column_stack([rng.uniform(0, s, CANDIDATES) for s in SIZE] + [np.ones(CANDIDATES)])
    lines_b = in_a @ matrices[0].T
    vt = np.linalg.svd(matrices[0])[2]
    lines_a = np.cross(vt[2], in_a)
    wrong = rng.random(CANDIDATES) < 0.5
    in_b = np.column_stack([rng.uniform(0, s, CANDIDATES) for s in SIZE] + [np.ones(CANDIDATES)])
    through = np.cross(in_b, in_b[::-1])
    # A true line that misses image B is replaced as well.
    side = lines_b @ np.array([[0, 0, 1], [SIZE[0] - 1, 0, 1], [0, SIZE[1] - 1, 1], [*SIZE, 1.0]]).T
    wrong |= np.all(side > 0, axis=1) | np.all(side < 0, axis=1)
    lines_b[wrong] = through[wrong]
    lines_a, lines_b = (x / np.linalg.norm(x[:, :2], axis=1, keepdims=True) for x in (lines_a, lines_b))
    lines_b[:, 2] += rng.normal(0, 0.5, CANDIDATES)
    sizes = [SIZE, SIZE]
    plain = LineScore(lines_a, lines_b, sizes)
    ours = _core.score_lines(lines_a, lines_b, sizes, matrices[:SOME])
    differing = np.abs(plain(matrices[:SOME]) - ours)
    if differing.max() > 1 or ours[0] < 0.2 * CANDIDATES:
        raise AssertionError(f"the numpy line scores differ by up to {differing.max()}")
    ways: dict[str, Callable[[], Any]] = {
        "epibar": lambda: _core.score_lines(lines_a, lines_b, sizes, matrices),
        "vectorised numpy": lambda: plain(matrices[:SOME]),
    }
    seconds = in_turn(ways)
    seconds["vectorised numpy"] *= HYPOTHESES / SOME
    return _stage(f"line scores, {CANDIDATES:,} candidates", seconds, points)


def _tangents(pair: Pair, matrices: Array, points: tuple[dict[str, float], list[str]]) -> Stage:
    """On 100 frames of both recordings."""
    a, b = pair.recordings
    radius = 3.0
    plain = TangentScore(a, b, radius, FRAMES)

    def score(some: Array) -> Any:
        return _core.score_tangents(a._core, b._core, some, radius, 0.0, True, FRAMES)

    found = score(matrices[:1])[1][0]
    if found != plain(matrices[0]) or found < 100:
        raise AssertionError(f"numpy finds {plain(matrices[0])} tangents that meet, not {found}")
    ways: dict[str, Callable[[], Any]] = {
        "epibar": lambda: score(matrices),
        "vectorised numpy, matches without their chance": lambda: [plain(f) for f in matrices[:SOME]],
    }
    seconds = in_turn(ways, rounds=3)
    seconds["vectorised numpy, matches without their chance"] *= HYPOTHESES / SOME
    stage = _stage(f"tangent scores, {FRAMES} frames", seconds, points)
    stage.notes["tangents of A in these frames"] = str(len(plain.views[0].tangents(np.array([0, 0, 1.0]))[0]))
    return stage


def _stage(name: str, seconds: dict[str, float], points: tuple[dict[str, float], list[str]]) -> Stage:
    ours = seconds.pop("epibar")
    return Stage(
        name=name,
        unit="hypotheses",
        units=HYPOTHESES,
        seconds=ours,
        peers={**seconds, **points[0]},
        notes={"hypotheses scored per second": f"{HYPOTHESES / ours:,.0f}"},
        missing=points[1],
    )


def _point_loops() -> tuple[dict[str, float], list[str]]:
    """Seconds of OpenCV and PoseLib for as many iterations over as many point matches that do not agree.

    Theirs sample, solve (up to three matrices for seven points) and score, and stop scoring a matrix
    early; ours only score. What is missing is told.
    """
    rng = np.random.default_rng(7)
    a, b = (np.column_stack([rng.uniform(0, s, CANDIDATES) for s in SIZE]) for _ in range(2))
    ways: dict[str, Callable[[], Any]] = {
        f"OpenCV USAC, {CANDIDATES:,} point matches, as many iterations": lambda: cv2.findFundamentalMat(
            a, b, cv2.USAC_DEFAULT, 1.0, 0.999999, HYPOTHESES
        ),
    }
    missing = []
    try:
        import poselib

        options = {"max_iterations": HYPOTHESES, "min_iterations": HYPOTHESES, "max_epipolar_error": 1.0}
        name = f"PoseLib, {CANDIDATES:,} point matches, as many iterations"
        ways[name] = lambda: poselib.estimate_fundamental(a, b, options, {})
    except ImportError:
        missing.append("poselib")
    return in_turn(ways, rounds=3), missing
