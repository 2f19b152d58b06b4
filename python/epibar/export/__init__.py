"""Results for other tools: OpenCV, NumPy, COLMAP, CSV, and the camera files of aniposelib and Caliscope.

>>> from epibar import export
>>> run = export.Run.load("calibrated").selected()  # doctest: +SKIP
>>> export.write_colmap(run, "database.db")  # doctest: +SKIP

``selected()`` keeps the accepted pairs, ``selected(every=True)`` all of them. The same from the command
line is ``epibar export``.
"""

from .colmap import write_colmap
from .network import place_cameras
from .run import Camera, Pair, Run
from .tables import write_csv, write_npz, write_opencv
from .toml import write_toml

__all__ = [
    "Camera",
    "Pair",
    "Run",
    "place_cameras",
    "write_colmap",
    "write_csv",
    "write_npz",
    "write_opencv",
    "write_toml",
]
