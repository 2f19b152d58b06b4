"""Which epipolar lines a picture of a pair shows, and which frame."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Order, Size
from ..calibration import Calibration
from ..clocks import nearest_frame, positions_in_b
from ..geometry.epipolar import epipoles
from ..geometry.lines import clip_lines
from ..geometry.vectors import homogeneous
from ..recording import Recording
from .moments import with_pictures

__all__ = ["MatchedLine", "frames_to_show", "matched_lines"]

APART = 0.04
"""Lines nearer to each other than this, in half turns and image sizes, look like one."""


@dataclass(frozen=True, eq=False)
class MatchedLine:
    """An epipolar plane as both cameras see it.

    Attributes
    ----------
    segments : two of ndarray, shape (2, 2)
        Ends of its line in A and in B, pixels.
    points : two of ndarray, shape (2,), or None
        The frontier point it goes through in A and in B, where the frame that is shown has it.
    """

    segments: tuple[Array, Array]
    points: tuple[Array, Array] | None


def frames_to_show(
    recordings: tuple[Recording, Recording],
    calibration: Calibration,
    pictures: tuple[Collection[int], Collection[int]] = ((), ()),
) -> tuple[int, int]:
    """Frame of A with the most frontier points, or else the most motion, and B's frame of that moment.

    Where there are ``pictures`` of some frames, a moment of which both cameras have one comes first, then one
    of which one has.
    """
    a, b = recordings
    points = calibration.frontier_points.frame
    counts = np.bincount(points, minlength=a.frames) if len(points) else a.moving_pixels
    position = positions_in_b(a, b, calibration)
    worth = np.where(np.isfinite(position), counts[: a.frames].astype(np.int64), -1)
    frames_b = nearest_frame(np.nan_to_num(position, nan=-1.0))
    shown = with_pictures(np.column_stack([np.arange(a.frames), frames_b]), worth, *pictures, least=1)
    frame = int(np.where(shown, worth, -1).argmax())
    # Where they have no moment in common, the nearest.
    of_b = position[frame] if np.isfinite(position[frame]) else calibration.frame_of_b(frame)
    return frame, int(nearest_frame(of_b).clip(0, b.frames - 1))


def matched_lines(
    calibration: Calibration, size_a: Size, size_b: Size, frame: int, count: int
) -> list[MatchedLine]:
    """Choose epipolar lines that lie far from each other, those of the frame's frontier points first.

    Parameters
    ----------
    calibration : Calibration
    size_a, size_b : (int, int)
        Width and height, pixels.
    frame : int
        Frame of A that is shown.
    count : int
        At most this many.
    """
    if calibration.F is None:
        return []
    points = calibration.frontier_points
    in_frame = points.frame == frame
    if len(points):
        lines_b = homogeneous(points.a) @ calibration.F.T
        lines_a = homogeneous(points.b) @ calibration.F
    else:
        grid = np.linspace(0.15, 0.85, 2 * count)[:, None] * (np.array(size_a) - 1.0)
        lines_b = homogeneous(grid) @ calibration.F.T
        lines_a = np.cross(epipoles(calibration.F)[0], homogeneous(grid))
        in_frame = np.zeros(len(grid), bool)
    segments_a, hit_a = clip_lines(lines_a, size_a)
    segments_b, hit_b = clip_lines(lines_b, size_b)
    shape = np.hstack([_unit_lines(lines_a, size_a), _unit_lines(lines_b, size_b)])
    chosen = _far_apart(shape, np.flatnonzero(hit_a & hit_b & in_frame), np.flatnonzero(hit_a & hit_b), count)
    return [
        MatchedLine(
            (segments_a[index], segments_b[index]),
            (points.a[index], points.b[index]) if in_frame[index] else None,
        )
        for index in chosen
    ]


def _far_apart(shape: Array, preferred: Order, others: Order, count: int) -> list[int]:
    """Choose lines far from each other, farthest first; ``others`` only when ``preferred`` runs out."""
    chosen: list[int] = []
    for pool in (preferred, others):
        while len(pool) and len(chosen) < count:
            if not chosen:
                chosen.append(int(pool[0]))
                continue
            distance = np.abs(shape[pool][:, None] - shape[chosen][None]).max(axis=2).min(axis=1)
            best = int(distance.argmax())
            if distance[best] < APART:
                break
            chosen.append(int(pool[best]))
    return chosen


def _unit_lines(lines: Array, size: Size) -> Array:
    """Direction modulo half a turn and distance from the image's middle, both of order one."""
    middle = np.array([(size[0] - 1) / 2, (size[1] - 1) / 2, 1.0])
    norm = np.maximum(np.hypot(lines[:, 0], lines[:, 1]), 1e-300)
    angle = 2 * np.arctan2(lines[:, 1], lines[:, 0])
    sign = np.where(np.abs(lines[:, 1]) > np.abs(lines[:, 0]), np.sign(lines[:, 1]), np.sign(lines[:, 0]))
    return np.column_stack([np.cos(angle), np.sin(angle), sign * (lines @ middle) / norm / max(size)])
