"""What a report is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..calibration import Calibration
from ..network.parts import NetworkParts
from ..recording import Recording
from ..sources.pictures import Pictures
from .walker_lines import Track

__all__ = ["NetworkReport", "ReportCamera", "ReportPair"]


@dataclass(frozen=True)
class ReportCamera:
    """One camera of a report.

    Attributes
    ----------
    name : str
        As the pairs call it.
    source : str or None
        What it was recorded from, to be named.
    masks : bool
        The source is ready-made masks.
    recording : Recording
    pictures : Pictures or None
        Of some of its frames; of the others the report shows silhouettes over the heat map.
    """

    name: str
    source: str | None
    masks: bool
    recording: Recording
    pictures: Pictures | None


@dataclass(frozen=True)
class ReportPair:
    """One calibrated pair of a report.

    Attributes
    ----------
    a, b : str
        Names of its cameras.
    calibration : Calibration
    seconds : float
        How long it took.
    """

    a: str
    b: str
    calibration: Calibration
    seconds: float


@dataclass(frozen=True, eq=False)
class NetworkReport:
    """The network of a report, or why there is none.

    Attributes
    ----------
    network : Network or None
    reason : str or None
        Why there is no network, if somebody may have expected one.
    tracks : sequence of (n, 3) array
        Ways of walkers in the network's unit.
    """

    network: NetworkParts | None = None
    reason: str | None = None
    tracks: Sequence[Track] = ()
