"""What calibration.json says of a run, its cameras and its pairs."""

from __future__ import annotations

import platform
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ..arguments import Array
from ..calibration import Calibration
from ..errors import EpibarError
from ..files.calibration_json import FORMAT, SCHEMA
from ..foreground.options import ForegroundMethod
from ..geometry.pose import relative_pose
from ..recording import Recording

__all__ = ["camera_entry", "pair_entry", "pose_entry", "run_entry"]


def run_entry(
    *,
    seed: int,
    method: str,
    lines: int,
    foreground: ForegroundMethod | None,
    upright: bool,
    max_expected_error: float,
    intrinsics: str | None,
    undistorted: bool | None,
) -> dict[str, Any]:
    """Start a calibration.json: the settings that the result depends on, and empty lists to fill.

    ``undistorted`` says whether lenses were taken out of the recordings; None where of some.
    """
    matrices = "each camera" if undistorted else "each camera that has one, of others as in the video"
    return {
        "$schema": SCHEMA,
        "format": FORMAT,
        "convention": "x_b^T F x_a = 0; pixels, pixel centres at integers; "
        + ("as in the video" if undistorted is False else f"undistorted with the matrix of {matrices}"),
        "seed": seed,
        "method": method,
        "lines": lines,
        "foreground": foreground,
        "upright": upright,
        "max_expected_error": max_expected_error,
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
