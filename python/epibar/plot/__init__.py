"""Figures for papers and notebooks, drawn with matplotlib (``pip install 'epibar[plot]'``).

>>> from epibar import plot
>>> plot.epipolar_lines(cal, rec_a, rec_b)[0].figure.savefig("lines.png")  # doctest: +SKIP

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
