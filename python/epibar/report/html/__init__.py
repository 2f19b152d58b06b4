"""``report.html``: one file that shows what was found, offline, in any browser.

>>> from epibar.report.html import ReportCamera, ReportPair, write_report
>>> cameras = [ReportCamera("cam1", "cam1.mp4", False, rec_a, None), ...]  # doctest: +SKIP
>>> write_report("report.html", cameras, [ReportPair("cam1", "cam2", cal, 12.0)])  # doctest: +SKIP

The page loads nothing: pictures, numbers, style, scripts and the plotting library (plotly.js, from the Python
package ``plotly``) are in the file, and its content security policy forbids the browser to fetch anything
else. What the page can say without scripts (cameras, the matrix of pairs, verdicts) it says without.
"""

from __future__ import annotations

from .inputs import ReportCamera, ReportPair
from .page import write_report

__all__ = ["ReportCamera", "ReportPair", "write_report"]
