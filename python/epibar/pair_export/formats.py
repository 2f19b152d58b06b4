"""The programs that pairs of cameras are written for, one module of this package each.

To add one: a module with a function that takes a :class:`~epibar.outcome.Run` and a path, writes, and returns
the files it wrote; and a line in :data:`PAIR_FORMATS`. Cameras in one world have a table of their own,
:mod:`epibar.camera_export.formats`. The command line, its help and ``epibar formats`` follow
:data:`epibar.export.FORMATS`.
Standard library only: the command line reads it before anything heavy is imported.
"""

from __future__ import annotations

from ..camera_export.formats import Format

__all__ = ["PAIR_FORMATS"]

AXES = "pixels, pixel centres at integers; X_b = R X_a + t, where matrices are known"

PAIR_FORMATS = {
    one.name: one
    for one in (
        Format(
            "opencv",
            "OpenCV",
            "a YAML file of FileStorage: F and frontier points",
            "none: t has length 1",
            AXES,
            "frames of the points",
            "opencv:write_pairs_opencv",
            package=__package__,
        ),
        Format(
            "npz",
            "NumPy",
            "an .npz file, without pickle",
            "none: t has length 1",
            AXES,
            "nothing more",
            "npz:write_pairs_npz",
            package=__package__,
        ),
        Format(
            "colmap",
            "COLMAP",
            "a database with the frontier points as verified matches",
            "none: t has length 1",
            "pixels, centre of the first pixel at (0.5, 0.5)",
            "frames of the points; verdicts but for accepted or not",
            "colmap:write_pairs_colmap",
            extra="colmap",
            package=__package__,
        ),
        Format(
            "csv",
            "any calibration, spreadsheets",
            "a .csv file of the frontier points",
            "none",
            "pixels, pixel centres at integers",
            "F and poses",
            "csv:write_pairs_csv",
            package=__package__,
        ),
    )
}
