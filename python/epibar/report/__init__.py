"""What a person looks at after a run: ``report.html``, and a picture of each pair.

>>> from epibar.report import ReportCamera, ReportPair, write_report
>>> import epibar
>>> names = ["cam1", "cam2"]
>>> recordings = [epibar.Recording.load(f"{name}.npz") for name in names]
>>> cameras = [ReportCamera(one.name, None, False, one, None) for one in recordings]
>>> pair = ReportPair("cam1", "cam2", epibar.Calibration.load("cam1_cam2.npz"), seconds=12.0)
>>> written = write_report("report.html", cameras, [pair])

The page loads nothing: pictures, numbers, style, scripts and the plotting library (plotly.js, from the Python
package ``plotly``) are in the file, and its content security policy forbids the browser to fetch anything
else. What the page can say without scripts (the network's table, cameras, the matrix of pairs,
verdicts) it says without.
"""

from .inputs import NetworkReport, ReportCamera, ReportPair
from .page import write_report
from .pair_picture import draw_pair, write_pair_picture
from .walker_lines import read_tracks

__all__ = [
    "NetworkReport",
    "ReportCamera",
    "ReportPair",
    "draw_pair",
    "read_tracks",
    "write_pair_picture",
    "write_report",
]
