"""The numbers behind the page, as plain data for its scripts; pictures are added later."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .. import _core
from ..arguments import Array, Bits
from ..calibration import MAX_EXPECTED_ERROR, Calibration
from ..clocks import common_frames
from ..geometry.correspondences import FrontierPoints
from ..recording import Recording
from ..show.line_barcodes import WINDOW, LineSet, line_sets
from ..show.moments import busiest_window, choose_moments, points_per_frame, with_pictures
from .inputs import ReportCamera, ReportPair
from .prose import advice, verdict_prose

__all__ = ["camera_entry", "pair_entries"]

HEAT_COLUMNS = 96
BINS = 40
FAR = 10.0
"""Medians: residuals beyond so many go into the last bar."""
RIVALS = 5


def camera_entry(camera: ReportCamera, frames: set[int]) -> dict[str, Any]:
    """Describe a camera and its silhouettes in the frames that are shown."""
    recording = camera.recording
    return {
        "name": camera.name,
        "size": recording.size,
        "frames": recording.frames,
        "heat": _heat_grid(recording),
        "motion_lines": _core.motion_lines(recording._core),
        "hulls": {
            str(frame): [np.asarray(hull).astype(int) for hull in recording.hulls(frame)]
            for frame in sorted(frames)
        },
        "images": {},
    }


def _heat_grid(recording: Recording) -> Array:
    """Share of the frames in which the pixels of a cell moved, per cent, evenly over the image."""
    width, height = recording.size
    columns = min(HEAT_COLUMNS, width)
    rows = max(1, min(height, round(columns * height / width)))
    y = np.arange(height) * rows // height
    x = np.arange(width) * columns // width
    total, count = np.zeros((2, rows, columns))
    np.add.at(total, (y[:, None], x[None]), recording.heat)
    np.add.at(count, (y[:, None], x[None]), 1)
    return np.round(100 * total / count / max(1, recording.frames), 2)


def pair_entries(
    cameras: Sequence[ReportCamera], pairs: Sequence[ReportPair]
) -> tuple[list[dict[str, Any]], dict[str, set[int]]]:
    """Describe every pair.

    Returns
    -------
    entries : list of dict
    wanted : dict of str to set of int
        Per camera the frames that the pairs show.
    """
    by_name = {camera.name: index for index, camera in enumerate(cameras)}
    wanted: dict[str, set[int]] = {camera.name: set() for camera in cameras}
    return [_pair_entry(pair, cameras, by_name, wanted) for pair in pairs], wanted


def _pair_entry(
    pair: ReportPair,
    cameras: Sequence[ReportCamera],
    by_name: Mapping[str, int],
    wanted: dict[str, set[int]],
) -> dict[str, Any]:
    calibration = pair.calibration
    a, b = (cameras[by_name[name]].recording for name in (pair.a, pair.b))
    common = common_frames(a, b, calibration)
    worth = points_per_frame(common, a, b, calibration)
    pictures_a, pictures_b = (cameras[by_name[name]].pictures or () for name in (pair.a, pair.b))
    shown = with_pictures(common, worth, pictures_a, pictures_b)
    moments = choose_moments(common[shown], worth[shown], wanted[pair.a], wanted[pair.b])
    wanted[pair.a].update(moments[:, 0].tolist())
    wanted[pair.b].update(moments[:, 1].tolist())
    window = common[busiest_window(worth, WINDOW)]
    return {
        "a": by_name[pair.a],
        "b": by_name[pair.b],
        "accepted": calibration.accepted,
        "verdict": verdict_prose(calibration),
        "kind": calibration.kind,
        "reason": calibration.reason,
        "advice": advice(calibration, a.matrix is not None and b.matrix is not None),
        "F": calibration.F,
        "expected_error": calibration.expected_error,
        "time_offset": calibration.time_offset,
        "frames_per_frame": calibration.timing.frames_per_frame,
        "method": calibration.method,
        "seconds": round(pair.seconds, 1),
        "moments": [
            {
                "a": frame_a,
                "b": frame_b,
                "seconds": round(float(a.times[frame_a]), 3),
                "points": _points_in(calibration.frontier_points, frame_a),
            }
            for frame_a, frame_b in moments.tolist()
        ],
        "strip_frames": window[:, 0],
        "common_frames": len(common),
        "line_sets": [_line_set_entry(shown) for shown in line_sets(a, b, calibration, window)],
        "shift_curve": dict(zip(("shift", "score"), calibration.shift_curve, strict=True)),
        "residuals": _histogram(calibration.frontier_points.residual),
        "error_maps": _error_maps(calibration),
        "trusted": _trusted(calibration),
        "rivals": [
            {key: rival.get(key) for key in ("distance", "evidence_share", "evidence_z", "source")}
            for rival in calibration.rivals[:RIVALS]
        ],
        "all_rivals": len(calibration.rivals),
        "evidence": calibration.evidence,
        "counts": calibration.counts,
    }


def _points_in(points: FrontierPoints, frame: int) -> Array:
    """Frontier points of one frame: (n, 5), x and y in A, in B, residual."""
    here = points.frame == frame
    return np.round(np.column_stack([points.a[here], points.b[here], points.residual[here]]), 3)


def _line_set_entry(shown: LineSet) -> dict[str, Any]:
    return {
        "kind": shown.kind,
        "lines_a": shown.lines_a,
        "lines_b": shown.lines_b,
        "bits_a": [_packed(bits) for bits in shown.bits_a],
        "bits_b": [_packed(bits) for bits in shown.bits_b],
        "correlation": np.round(shown.correlation, 3),
    }


def _packed(bits: Bits) -> str:
    """Pack a barcode as the recordings do, low bit first, in base64."""
    return base64.b64encode(np.packbits(bits, bitorder="little").tobytes()).decode("ascii")


def _histogram(residuals: Array) -> dict[str, Any] | None:
    if not len(residuals):
        return None
    median, furthest = float(np.median(residuals)), float(residuals.max())
    # Near an epipole a point may be hundreds of pixels off, and would leave one bar for all others.
    end = min(furthest, FAR * median) or 1.0
    counts, edges = np.histogram(np.minimum(residuals, end), BINS, (0.0, end))
    return {"counts": counts, "edges": np.round(edges, 4), "median": median, "furthest": round(furthest, 4)}


def _trusted(calibration: Calibration) -> dict[str, Any] | None:
    """Say in what share of each image, as far as the other shows its lines, F can be relied on."""
    maps = _error_maps(calibration)
    if maps is None or not calibration.accepted:
        return None
    regions = zip(calibration.trusted(), maps, strict=True)
    shares = [float(region[np.isfinite(grid)].mean()) for region, grid in regions]
    return {"limit": MAX_EXPECTED_ERROR, "shares": np.round(shares, 4)}


def _error_maps(calibration: Calibration) -> list[Any] | None:
    maps = calibration.error_maps
    if maps is None or not all(np.isfinite(grid).any() for grid in maps):
        return None
    return [np.round(grid, 3) for grid in maps]
