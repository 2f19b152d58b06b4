"""Epipolar geometry of stationary cameras from what moves in front of them.

>>> import epibar
>>> rec_a = epibar.record("cam1.mp4")  # doctest: +SKIP
>>> rec_b = epibar.record("cam2.mp4")  # doctest: +SKIP
>>> cal = epibar.calibrate(rec_a, rec_b)  # doctest: +SKIP
>>> cal.accepted, cal.reason, cal.F  # doctest: +SKIP

Conventions: ``x_b^T F x_a = 0`` with F of Frobenius norm 1; points are (x, y) in pixels with pixel centres at
integers; masks are (T, H, W), non-zero = moving; bit i of a motion barcode is frame i, packed in words of 64
bits, low bit first.

Names are imported when they are first used, so that ``import epibar`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .calibration import Calibration, Candidates, FrontierPoints, calibrate
    from .errors import EpibarError
    from .evaluation import symmetric_epipolar_distance
    from .foreground import ForegroundOptions
    from .intrinsics import Intrinsics, load_cameras
    from .matching import barcodes, match_barcodes
    from .recorder import record
    from .recording import Recording

__all__ = [
    "Calibration",
    "Candidates",
    "EpibarError",
    "ForegroundOptions",
    "FrontierPoints",
    "Intrinsics",
    "Recording",
    "__version__",
    "barcodes",
    "calibrate",
    "load_cameras",
    "match_barcodes",
    "record",
    "symmetric_epipolar_distance",
]

_HOME = {
    "Calibration": "calibration",
    "Candidates": "calibration",
    "EpibarError": "errors",
    "ForegroundOptions": "foreground",
    "FrontierPoints": "calibration",
    "Intrinsics": "intrinsics",
    "Recording": "recording",
    "barcodes": "matching",
    "calibrate": "calibration",
    "load_cameras": "intrinsics",
    "match_barcodes": "matching",
    "record": "recorder",
    "symmetric_epipolar_distance": "evaluation",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        value: object = version("epibar")
    elif name in _HOME:
        value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
