"""The network of a run, where it is that run's."""

from __future__ import annotations

from pathlib import Path

from ..errors import EpibarError
from ..files.calibration_json import read_json
from ..network.result import Network

__all__ = ["network_of_run"]


def network_of_run(file: Path, result: Path) -> Network:
    """Load ``network.json`` of a run.

    Parameters
    ----------
    file, result : Path
        ``network.json``, and the ``calibration.json`` beside it; that may be gone.

    Raises
    ------
    EpibarError
        The result is of a later run that was not finished or found no network.
    """
    if result.exists():
        content = read_json(result)
        if content.get("network", True) is None:
            why = content.get("network_reason")
            raise EpibarError(
                f"{file} is of an earlier run than {result}, which has no network"
                + (f": {why}" if isinstance(why, str) else "")
                + "; 'epibar calibrate' with the same videos and options writes both anew"
            )
    return Network.load(file)
