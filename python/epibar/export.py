"""Results for other programs: pairs for OpenCV, NumPy and COLMAP or as CSV, and the cameras for many more.

>>> from epibar import export
>>> run = export.Run.load("calibrated").selected()
>>> written = export.write_colmap(run, "database.db")

``selected()`` keeps the accepted pairs, ``selected(every=True)`` all of them. The same from the command
line is ``epibar export``. :data:`FORMATS` lists the formats; how to add one is said in
:mod:`epibar.pair_export.formats` for pairs, in :mod:`epibar.camera_export.formats` for cameras. Cameras of a
network are written by :meth:`epibar.Network.export`; :func:`write_placed` places those of a run without.

Names are imported when they are first used: the command line asks for the formats alone.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from .camera_export.formats import CAMERA_FORMATS, Format
from .pair_export.formats import PAIR_FORMATS

if TYPE_CHECKING:
    from .outcome.run import Pair, Run, RunCamera
    from .outcome.run import RunCamera as Camera
    from .pair_export.colmap import write_pairs_colmap as write_colmap
    from .pair_export.csv import write_pairs_csv as write_csv
    from .pair_export.npz import write_pairs_npz as write_npz
    from .pair_export.opencv import write_pairs_opencv as write_opencv
    from .pair_export.placed import write_placed
    from .pair_export.placed import write_placed_caliscope as write_caliscope
    from .pair_export.placed import write_placed_toml as write_toml
    from .pair_export.placing import place_cameras

__all__ = [
    "CAMERA_FORMATS",
    "FORMATS",
    "PAIR_FORMATS",
    "TRACK_FORMATS",
    "Camera",
    "Format",
    "Pair",
    "Run",
    "RunCamera",
    "place_cameras",
    "write_caliscope",
    "write_colmap",
    "write_csv",
    "write_npz",
    "write_opencv",
    "write_placed",
    "write_toml",
]

TRACK_FORMATS = {
    one.name: one
    for one in (
        Format(
            "tracks",
            "NumPy, spreadsheets",
            "walkers: an .npz file, without pickle, or a .csv file",
            "network",
            "world z up, 0 on the floor",
            "digits that tracks.csv does not have",
            "walkers:write_tracks",
            package="epibar.network",
        ),
    )
}
"""The formats of walkers: each takes :class:`~epibar.network.WalkerTracks` in place of a run."""

FORMATS = {"cameras": CAMERA_FORMATS, "pairs": PAIR_FORMATS, "tracks": TRACK_FORMATS}
"""Every format by what it holds."""

_HOME = {
    "Camera": "outcome:RunCamera",
    "Pair": "outcome:Pair",
    "Run": "outcome:Run",
    "RunCamera": "outcome:RunCamera",
    "place_cameras": "pair_export.placing:place_cameras",
    "write_caliscope": "pair_export.placed:write_placed_caliscope",
    "write_colmap": "pair_export.colmap:write_pairs_colmap",
    "write_csv": "pair_export.csv:write_pairs_csv",
    "write_npz": "pair_export.npz:write_pairs_npz",
    "write_opencv": "pair_export.opencv:write_pairs_opencv",
    "write_placed": "pair_export.placed:write_placed",
    "write_toml": "pair_export.placed:write_placed_toml",
}
"""Module and name there; what the room of pairs has beside one of cameras says there that it is of pairs."""


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, there = _HOME[name].partition(":")
    value: object = getattr(import_module(f".{module}", __package__), there)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
