"""Epipolar geometry of stationary cameras from what moves in front of them.

>>> import epibar
>>> rec_a = epibar.record("cam1.mp4")
>>> rec_b = epibar.record("cam2.mp4")
>>> cal = epibar.calibrate(rec_a, rec_b)
>>> if cal.accepted:
...     F, error = cal.F, cal.expected_error

Conventions: ``x_b^T F x_a = 0`` with F of Frobenius norm 1; points are (x, y) in pixels with pixel centres at
integers; masks are (T, H, W), non-zero = moving; bit i of a motion barcode is frame i, packed in words of 64
bits, low bit first.

Names are imported when they are first used, so that ``import epibar`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import export, live, plot
    from .calibration import Calibration, calibrate
    from .errors import EpibarError
    from .evaluation import Evaluation, evaluate
    from .foreground.options import ForegroundOptions
    from .from_video import record
    from .geometry.correspondences import Candidates, FrontierPoints
    from .geometry.epipolar import symmetric_epipolar_distance
    from .geometry.pose import RelativePose, relative_pose
    from .health.diagnosis import Diagnosis
    from .health.inspection import inspect
    from .jobs import AllPairs, calibrate_all
    from .lens.cameras_toml import load_cameras
    from .lens.intrinsics import Intrinsics
    from .motion_barcodes import barcodes, match_barcodes
    from .network import KnownCamera, Network, calibrate_network
    from .recording import Recording

__all__ = [
    "AllPairs",
    "Calibration",
    "Candidates",
    "Diagnosis",
    "EpibarError",
    "Evaluation",
    "ForegroundOptions",
    "FrontierPoints",
    "Intrinsics",
    "KnownCamera",
    "Network",
    "Recording",
    "RelativePose",
    "__version__",
    "barcodes",
    "calibrate",
    "calibrate_all",
    "calibrate_network",
    "evaluate",
    "export",
    "inspect",
    "live",
    "load_cameras",
    "match_barcodes",
    "plot",
    "record",
    "relative_pose",
    "symmetric_epipolar_distance",
]

_HOME = {
    "AllPairs": "jobs",
    "Calibration": "calibration",
    "Candidates": "geometry",
    "Diagnosis": "health",
    "EpibarError": "errors",
    "Evaluation": "evaluation",
    "ForegroundOptions": "foreground.options",
    "FrontierPoints": "geometry",
    "Intrinsics": "lens",
    "KnownCamera": "network",
    "Network": "network",
    "Recording": "recording",
    "RelativePose": "geometry",
    "barcodes": "motion_barcodes",
    "calibrate": "calibration",
    "calibrate_all": "jobs",
    "calibrate_network": "network",
    "evaluate": "evaluation",
    "inspect": "health",
    "load_cameras": "lens",
    "match_barcodes": "motion_barcodes",
    "record": "from_video",
    "relative_pose": "geometry",
    "symmetric_epipolar_distance": "geometry",
}

_MODULES = ("export", "live", "plot")
"""Of functions that are called by the module's name, such as ``epibar.plot.heat_map``."""


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        value: object = version("epibar")
    elif name in _MODULES:
        value = import_module(f".{name}", __name__)
    elif name in _HOME:
        value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
