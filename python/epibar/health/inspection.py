"""What one recording is good for, before any pairing."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from ..foreground.flooding import FLOOD_SHARE
from ..recording import Recording, as_recording
from .camera_findings import camera_findings
from .diagnosis import Diagnosis
from .finding import Finding
from .motion_findings import motion_findings
from .motion_measures import lines_left, share_by_ninth, spread_of, straightness_of

__all__ = ["cause_of_refusal", "inspect"]

# Each recording of a job is in many pairs.
_worst: WeakKeyDictionary[Recording, Finding | None] = WeakKeyDictionary()


def inspect(recording: Recording) -> Diagnosis:
    """Tell what a recording is good for, before it is paired with another.

    Parameters
    ----------
    recording : Recording
        From :func:`epibar.record`, a file or masks. Without images, as for masks, nothing can be said about
        the camera and the light.

    Returns
    -------
    Diagnosis
        ``print`` it, or read ``findings``.

    Raises
    ------
    EpibarError
        The argument is no recording.

    Examples
    --------
    >>> import epibar
    >>> seen = epibar.inspect(epibar.Recording.load("cam1.npz"))
    >>> print(seen)  # doctest: +ELLIPSIS
    cam1: ...
    >>> what_is_wrong = [finding.text for finding in seen.findings if finding.serious]
    """
    as_recording("recording", recording)
    width, height = recording.size
    moving = recording.moving_pixels.astype(np.int64)
    heat = recording.heat.astype(np.float64)
    arrays = recording._core.to_arrays()
    lines, paths = lines_left(recording, arrays)
    blanked = recording.health.get("blanked", 0.0)
    flooded = blanked + np.count_nonzero(moving > FLOOD_SHARE * width * height)
    diagnosis = Diagnosis(
        name=recording.name,
        size=recording.size,
        frames=recording.frames,
        seconds=float(recording.times[-1] - recording.times[0]),
        moving_frames=float(np.mean(moving > 0)),
        flooded_frames=float(flooded / recording.frames),
        moving_area=float(np.median(moving[moving > 0]) / (width * height)) if moving.any() else 0.0,
        spread=spread_of(heat),
        where=share_by_ninth(heat),
        lines=lines,
        paths=paths,
        straightness=straightness_of(arrays, (width, height)),
        silhouettes=len(arrays["hull_area"]),
        cut=float(arrays["hull_border"].mean()) if len(arrays["hull_border"]) else 0.0,
        health=recording.health,
    )
    found = [*camera_findings(recording.health), *motion_findings(diagnosis)]
    found.sort(key=lambda finding: not finding.serious)
    return replace(diagnosis, findings=tuple(found))


def cause_of_refusal(kind: str, rec_a: Recording, rec_b: Recording) -> str | None:
    """Say what in either camera may be why a pair was refused.

    Parameters
    ----------
    kind : str
        The verdict's.
    rec_a, rec_b : Recording
        Of the two cameras.

    Returns
    -------
    str or None
        One sentence that names the camera; None where the pair was accepted or both cameras are sound.
    """
    if kind == "accepted":
        return None
    causes = []
    for recording, side in ((rec_a, "camera A"), (rec_b, "camera B")):
        if recording not in _worst:
            serious = (finding for finding in inspect(recording).findings if finding.serious)
            _worst[recording] = next(serious, None)
        worst = _worst[recording]
        if worst is not None:
            causes.append(f"in {recording.name or side} {worst.text}")
    return f"A possible cause: {'. And '.join(causes)}." if causes else None
