"""Figures for papers and notebooks, drawn with matplotlib (``pip install 'epibar[plot]'``).

>>> import epibar
>>> rec_a, rec_b = epibar.Recording.load("cam1.npz"), epibar.Recording.load("cam2.npz")
>>> cal = epibar.Calibration.load("cam1_cam2.npz")
>>> view_a, view_b = epibar.plot.epipolar_lines(cal, rec_a, rec_b)
>>> view_a.figure.savefig("lines.png")

Each function takes Axes to draw on, or makes a figure, and returns its Axes; those that show both views take
and return two.
"""

from .charts import barcode_strips, pair_matrix, residual_histogram, time_shift_curve
from .views import epipolar_lines, expected_error_map, frontier_points, heat_map

__all__ = [
    "barcode_strips",
    "epipolar_lines",
    "expected_error_map",
    "frontier_points",
    "heat_map",
    "pair_matrix",
    "residual_histogram",
    "time_shift_curve",
]
