"""What came back from a task, which may have run on a machine that is broken, or lies.

A recording is made of its arrays again on the way, with every check of a file. Here it is held against what
was asked for, so that no result of another camera or pair is taken.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..calibration import Calibration
from ..errors import EpibarError
from ..files.calibration_npz import to_arrays
from ..files.json_values import plain
from ..network.offsets import ClockOffsets
from ..network.result import Network
from ..network.saved import as_dict, network_from
from ..recording import Recording
from ..sources.picture_taking import MOST
from .inputs import CameraInput, CameraPair, Job, PairOptions, RecordOptions
from .stages import CLOCKS

__all__ = [
    "are_clocks",
    "checked",
    "checked_calibration",
    "checked_clocks",
    "checked_network",
    "checked_recording",
]

MOST_PICTURES = 2 * MOST
MARGIN = 2
"""Pixels that a point may lie outside of its image."""


def checked(
    value: Any, of: CameraInput | CameraPair | str, job: Job, recordings: Mapping[CameraInput, Recording]
) -> Any:
    """Return what a task returned, if it can be what was asked for.

    Raises
    ------
    EpibarError
        It cannot.
    """
    if isinstance(of, CameraInput):
        return checked_recording(value, of, job.record)
    if isinstance(of, tuple):
        return checked_calibration(value, recordings[of[0]], recordings[of[1]], job.pair)
    if of == CLOCKS:
        return checked_clocks(value, len(recordings))
    in_order = {one.name: recordings[one] for one in job.cameras if one in recordings}
    return checked_network(value, in_order)


def _taken_apart(value: Any, kind: type, what: str) -> tuple[Any, float]:
    if not isinstance(value, tuple) or len(value) != 2 or not isinstance(value[0], kind):
        raise EpibarError(f"what ran the task returned no {what}; its result is not used")
    seconds = value[1]
    if not isinstance(seconds, float) or not 0 <= seconds < math.inf:
        raise EpibarError(f"what ran the task says that it took {seconds!r} seconds; its result is not used")
    return value[0], seconds


def checked_recording(value: Any, camera: CameraInput, options: RecordOptions) -> tuple[Recording, float]:
    """Return a recording and the seconds it took, if it is one of that camera as was asked for.

    Raises
    ------
    EpibarError
        It is not.
    """
    recording, seconds = _taken_apart(value, Recording, "recording")
    wrong = recording.name != camera.name
    if not camera.is_saved(options):
        wrong |= recording.seed != options.seed or len(recording.segments) != options.lines
        wrong |= recording.first_frame != options.frames.first
    taken = recording.pictures or ()
    wrong |= not all(frame < recording.frames for frame in taken) or len(taken) > MOST_PICTURES
    if wrong:
        raise EpibarError(
            f"{camera.name}: what ran the task returned another recording, {recording!r} of seed "
            f"{recording.seed}; its result is not used"
        )
    return recording, seconds


def checked_calibration(
    value: Any, a: Recording, b: Recording, options: PairOptions
) -> tuple[Calibration, float]:
    """Return a calibration and the seconds it took, if it can be one of that pair as was asked for.

    Raises
    ------
    EpibarError
        It cannot.
    """
    calibration, seconds = _taken_apart(value, Calibration, "calibration")
    try:
        Calibration.from_arrays(to_arrays(calibration), f"{a.name} - {b.name}: what ran the task returned")
    except (TypeError, AttributeError) as error:
        raise EpibarError(f"{a.name} - {b.name}: what ran the task returned is damaged ({error})") from error
    points = calibration.frontier_points
    inside = all(
        np.all((places > -MARGIN) & (places < np.array(recording.size) + MARGIN))
        for places, recording in ((points.a, a), (points.b, b))
    )
    frames = bool(np.all(points.frame < a.frames))
    asked = calibration.method == options.method and calibration.seed == options.seed
    if not (inside and frames and asked):
        raise EpibarError(
            f"{a.name} - {b.name}: what ran the task returned the calibration of another pair, or with other "
            "options; its result is not used"
        )
    return calibration, seconds


def checked_clocks(value: Any, cameras: int) -> ClockOffsets:
    """Return the offsets of clocks, if they can be what was found for so many cameras.

    Raises
    ------
    EpibarError
        They cannot.
    """
    if not isinstance(value, ClockOffsets) or not are_clocks(value, cameras):
        raise EpibarError(f"what ran the task returned no {cameras} clocks; its result is not used")
    return value


def are_clocks(value: ClockOffsets, cameras: int) -> bool:
    """Whether offsets can be what was found for so many cameras."""
    seconds = value.seconds
    numbers = isinstance(seconds, tuple) and all(isinstance(one, float) for one in seconds)
    fits = numbers and len(seconds) == cameras and not any(map(math.isinf, seconds))
    return fits and isinstance(value.together, bool) and value.given is False


def checked_network(value: Any, recordings: Mapping[str, Recording]) -> Network:
    """Return a network, made of its numbers again with every check of a file, if it is one of those cameras.

    Raises
    ------
    EpibarError
        It is not.
    """
    if not isinstance(value, Network):
        raise EpibarError("what ran the task returned no network; its result is not used")
    try:
        network = network_from(Network, plain(as_dict(value)), "what ran the task returned")
    except (TypeError, AttributeError, KeyError, ValueError, RecursionError) as error:
        raise EpibarError(f"the network that was returned is not used: {error}") from error
    made = [(name, camera.size) for name, camera in network.cameras.items()]
    if made != [(name, recording.size) for name, recording in recordings.items()]:
        raise EpibarError("what ran the task returned the network of other cameras; its result is not used")
    return network
