"""Verdicts as prose, and what to do next."""

from __future__ import annotations

from collections.abc import Sequence

from .. import _core
from ..calibration import Calibration
from .inputs import ReportCamera

__all__ = ["advice", "pairs_pixels", "verdict_prose"]

SOME_EVIDENCE = _core.SOME_Z
"""Standard deviations above chance: by chance one pair in 44 has more."""

TITLES = {
    "accepted": "Accepted",
    "too_little_motion": "Too little motion",
    "no_common_scene": "No common scene",
    "undetermined": "Geometry undetermined",
    "ambiguous": "Ambiguous",
    "knocked": "A camera moved while it filmed",
    "moved": "A camera has moved since",
    "inaccurate": "Not accurate enough",
}

ABOUT_LENSES = "Lens distortion bends lines: give `--intrinsics` for anything but a narrow lens."

ADVICE = {
    "too_little_motion": [
        "Film longer, or with more people, so that things move in many places of both views.",
        "Look at the heat maps below: is what moves there what really moved? If not, give a clip of the "
        "empty scene (`--background`), or your own masks (`--masks`).",
    ],
    "no_common_scene": [
        "If the cameras were started further apart, look further for the offset: `--search-seconds`; were "
        "they triggered together, say so: `--time-offset 0`.",
        "Check that both cameras see the same people at the same time; views without overlap have no answer.",
        "Look at the heat maps: trees, screens and reflections drown what matters. Mask them with "
        "`--ignore`.",
        "Film longer: some hundred frames in which people walk, in many places of both views, are the least.",
    ],
    "undetermined": [
        "Film other motion: crossing paths, near and far, raised arms, people of different heights.",
        "If the cameras stand at one place, move one: without a baseline there is no epipolar geometry.",
    ],
    "ambiguous": [
        "Film other motion, in more of the room and in more directions: the rivals below explain this one as "
        "well.",
        "If everybody marches in step, or turns on a carousel, film people who walk as they like.",
        "If all cameras are the right way up, do not use `--any-way-up`.",
    ],
    "knocked": [
        "Look at the videos: when was a camera touched? Calibrate the time before and the time after by "
        "themselves (`--frames`).",
        "If no camera moved, the views stop showing the same things at some moment: film what both see.",
    ],
    "moved": [
        "Use the network's cameras, which were solved for again; to test the pair by itself, record it anew.",
    ],
    "inaccurate": [
        "Film longer, or give better masks: ragged outlines are the usual cause.",
        ABOUT_LENSES,
        "If a coarser answer is good enough, raise `--max-expected-error`; not with boxes or ellipses "
        "as masks, whose true error is larger than expected.",
    ],
}

FILM_LONGER = (
    "Some evidence is there, but too little to rely on: film longer, or with more people. "
    "It grows with the length."
)


def verdict_prose(calibration: Calibration) -> str:
    """Name the verdict in a few words."""
    kind = calibration.kind
    return TITLES.get(kind, kind.replace("_", " ").capitalize())


def pairs_pixels(cameras: Sequence[ReportCamera]) -> str:
    """Say in which pixels pairs were calibrated by themselves, in a report that has a network too."""
    straight = [camera.name for camera in cameras if camera.recording.matrix is not None]
    if not straight:
        return "As they were filmed, without what the network knows of the lenses."
    if len(straight) == len(cameras):
        return "In undistorted pixels, those of the camera matrices that were given."
    return (
        f"{', '.join(straight)} in undistorted pixels, those of the camera matrices that were given; the "
        "others as they were filmed, without what the network knows of their lenses."
    )


def advice(calibration: Calibration, lenses_known: bool = False) -> list[str]:
    """Say what to do about a refused pair, whose lenses were taken out or not; code is between backticks."""
    if calibration.accepted:
        return []
    known = ADVICE.get(calibration.kind, ["Read docs/trust.md on this verdict."])
    z = calibration.evidence.get("z")
    if calibration.kind == "no_common_scene" and z is not None and z > SOME_EVIDENCE:
        return [FILM_LONGER, *known[:-1]]
    return [text for text in known if not (lenses_known and text is ABOUT_LENSES)]
