"""Results for other programs: pairs for OpenCV, NumPy and COLMAP or as CSV, and the cameras for many more.

>>> from epibar import export
>>> run = export.Run.load("calibrated").selected()
>>> written = export.write_colmap(run, "database.db")

``selected()`` keeps the accepted pairs, ``selected(every=True)`` all of them. The same from the command
line is ``epibar export``. :mod:`epibar.export.formats` lists the formats, and says how to add one. Cameras of
a network are written by :meth:`epibar.Network.export`; :func:`write_placed` places those of a run without.

Names are imported when they are first used: the command line asks for the formats alone.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from .formats import CAMERA_FORMATS, FORMATS, PAIR_FORMATS, Format

if TYPE_CHECKING:
    from ..outcome.run import Camera, Pair, Run
    from .colmap import write_colmap
    from .csv import write_csv
    from .npz import write_npz
    from .opencv import write_opencv
    from .placed import write_caliscope, write_placed, write_toml
    from .placing import place_cameras

__all__ = [
    "CAMERA_FORMATS",
    "FORMATS",
    "PAIR_FORMATS",
    "Camera",
    "Format",
    "Pair",
    "Run",
    "place_cameras",
    "write_caliscope",
    "write_colmap",
    "write_csv",
    "write_npz",
    "write_opencv",
    "write_placed",
    "write_toml",
]

_HOME = {
    "Camera": "..outcome",
    "Pair": "..outcome",
    "Run": "..outcome",
    "place_cameras": ".placing",
    "write_caliscope": ".placed",
    "write_colmap": ".colmap",
    "write_csv": ".csv",
    "write_npz": ".npz",
    "write_opencv": ".opencv",
    "write_placed": ".placed",
    "write_toml": ".placed",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(_HOME[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
