"""calibration.json and the frontier points as CSV.

The JSON holds no numpy type, no NaN and no infinity: a number that is not known is null.
"""

from __future__ import annotations

import json
import platform
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Array
from ..calibration import Calibration
from ..errors import EpibarError
from ..files.atomic import write_atomically
from ..files.json_values import plain
from ..geometry.correspondences import FrontierPoints
from ..geometry.pose import relative_pose
from ..recording import Recording

__all__ = [
    "camera_entry",
    "json_text",
    "pair_entry",
    "pose_entry",
    "read_frontier_points",
    "read_json",
    "run_entry",
    "write_frontier_points",
    "write_json",
]

FORMAT = 1
COLUMNS = "frame_a,x_a,y_a,x_b,y_b,residual"


def run_entry(
    *, seed: int, method: str, lines: int, foreground: str | None, upright: bool, intrinsics: str | None
) -> dict[str, Any]:
    """Start a calibration.json: the settings that the result depends on, and empty lists to fill."""
    return {
        "format": FORMAT,
        "convention": "x_b^T F x_a = 0; pixels, pixel centres at integers; "
        + ("undistorted with the matrix of each camera" if intrinsics else "as in the video"),
        "seed": seed,
        "method": method,
        "lines": lines,
        "foreground": foreground,
        "upright": upright,
        "intrinsics": intrinsics,
        "versions": {
            "python": platform.python_version(),
            **{name: _version(name) for name in ("epibar", "numpy", "opencv-python-headless")},
        },
        "cameras": [],
        "pairs": [],
        "errors": [],
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def camera_entry(name: str, source: str, index: int, recording: Recording) -> dict[str, Any]:
    """Describe one camera for calibration.json."""
    return {
        "name": name,
        "index": index,
        "file": source,
        "width": recording.width,
        "height": recording.height,
        "frames": recording.frames,
        "first_frame": recording.first_frame,
        "lines": len(recording.segments),
        "informative_lines": recording.informative,
        "matrix": recording.matrix,
        "warnings": recording.warnings,
    }


def pair_entry(a: str, b: str, calibration: Calibration) -> dict[str, Any]:
    """Describe one pair for calibration.json."""
    return {
        "a": a,
        "b": b,
        "accepted": calibration.accepted,
        "kind": calibration.kind,
        "reason": calibration.reason,
        "F": calibration.F,
        "expected_error": calibration.expected_error,
        "time_offset": calibration.time_offset,
        "timing": asdict(calibration.timing),
        "method": calibration.method,
        "seed": calibration.seed,
        "counts": calibration.counts,
        "evidence": calibration.evidence,
        "source": calibration.source,
        "floor": calibration.floor,
        "rivals": calibration.rivals,
    }


def json_text(result: dict[str, Any]) -> str:
    """Set the result as JSON."""
    return json.dumps(plain(result), indent=2, allow_nan=False, ensure_ascii=False)


def write_json(path: Path, result: dict[str, Any]) -> None:
    """Write the result, whole or not at all."""
    text = json_text(result)
    write_atomically(path, lambda stream: stream.write(text.encode() + b"\n"))


def read_json(path: Path) -> dict[str, Any]:
    """Read a calibration.json.

    Raises
    ------
    EpibarError
        Missing, not JSON, or not what this program writes.
    """
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise EpibarError(f"{path}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:
        raise EpibarError(f"{path}: not JSON ({error})") from error
    if not isinstance(result, dict) or not isinstance(result.get("pairs"), list) or "cameras" not in result:
        raise EpibarError(f"{path}: not a calibration written by 'epibar calibrate'")
    if result.get("format") != FORMAT:
        raise EpibarError(f"{path}: format {result.get('format')!r}, but this epibar reads format {FORMAT}")
    return result


def write_frontier_points(path: Path, calibration: Calibration) -> Path:
    """Write the frontier points of a pair as CSV, one per line."""
    points = calibration.frontier_points
    table = np.column_stack([points.frame, points.a, points.b, points.residual])
    write_atomically(
        path,
        lambda stream: np.savetxt(
            stream,
            table,
            fmt=["%d"] + 5 * ["%.4f"],
            delimiter=",",
            header=COLUMNS,
            comments="",
            encoding="utf-8",
        ),
    )
    return path


def read_frontier_points(path: Path) -> FrontierPoints:
    """Read the frontier points of a pair.

    Raises
    ------
    EpibarError
        Missing, or not what :func:`write_frontier_points` writes.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        if not lines or lines[0] != COLUMNS:
            raise ValueError(f"the first line is not {COLUMNS}")
        table = np.array([[float(number) for number in line.split(",")] for line in lines[1:]]).reshape(-1, 6)
    except (OSError, ValueError) as error:
        raise EpibarError(f"{path}: the frontier points cannot be read ({error})") from error
    return FrontierPoints(table[:, 0].astype(np.int64), table[:, 1:3], table[:, 3:5], table[:, 5])


def pose_entry(calibration: Calibration, K_a: Array | None, K_b: Array | None) -> dict[str, Any] | None:
    """Describe the pose of a pair for calibration.json.

    Returns
    -------
    dict or None
        E, R, t and the check; or the ``reason`` why an accepted pair has no pose. None where the pair was not
        accepted or a camera matrix is not known.
    """
    if not calibration.accepted or K_a is None or K_b is None:
        return None
    try:
        pose = relative_pose(calibration, K_a, K_b)
    except EpibarError as error:
        return {"reason": str(error)}
    return {
        "convention": "X_b = R X_a + t, t of length 1; E = [t]x R ~ K_b^T F K_a",
        "E": pose.E,
        "R": pose.R,
        "t": pose.t,
        "points": pose.points,
        "in_front": pose.in_front,
        "singular_ratio": pose.singular_ratio,
    }
