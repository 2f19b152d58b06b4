"""What a job does once for all cameras: their clocks, and one network of all pairs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

from ..calibration import Calibration
from ..clocks import frame_interval
from ..network.calibrating import in_metres
from ..network.joining import join_pairs
from ..network.offsets import ClockOffsets, find_offsets
from ..network.pair_choice import pairs_to_search
from ..network.pair_search import offsets_of_pair
from ..network.result import Network
from ..recording import Recording
from .inputs import CameraInput, CameraPair, Job, PairOptions

__all__ = [
    "JoinRequest",
    "chosen_pairs",
    "final_clocks",
    "find_clocks",
    "given_clocks",
    "join_cameras",
    "pair_options",
    "why_no_network",
]

OF_THE_PAIR = ClockOffsets((0.0, 0.0))
"""Stands for clocks of two cameras, whose only pair finds the offset by itself."""


@dataclass(frozen=True, eq=False)
class JoinRequest:
    """All that a network is made of, but for the recordings.

    Attributes
    ----------
    names : list of str
        Of the cameras, in the order of their recordings.
    calibrations : dict of (str, str) to Calibration
    offsets : ClockOffsets
    lengths : dict
        What is known in metres, as :func:`epibar.network.calibrating.in_metres` takes it.
    """

    names: list[str]
    calibrations: dict[tuple[str, str], Calibration]
    offsets: ClockOffsets
    lengths: dict[str, Any]


def find_clocks(search_seconds: float, *given: Any) -> ClockOffsets:
    """Find the offsets of all clocks; ``given`` are the recordings, and it may be a function to report to."""
    recordings, progress = _sorted(given)
    return find_offsets(recordings, search_seconds, progress)


def join_cameras(request: JoinRequest, *given: Any) -> Network:
    """Join all pairs to one network; ``given`` as for :func:`find_clocks`."""
    recordings, progress = _sorted(given)
    network = join_pairs(
        dict(zip(request.names, recordings, strict=True)),
        request.calibrations,
        request.offsets,
        progress=progress,
    )
    return in_metres(network, **request.lengths)


def _sorted(given: Sequence[Any]) -> tuple[list[Recording], Callable[[str, float], None] | None]:
    """Recordings, and the function to report to behind them, if there is one."""
    recordings = [one for one in given if isinstance(one, Recording)]
    return recordings, given[-1] if len(given) > len(recordings) else None


def given_clocks(job: Job, recordings: Sequence[Recording]) -> ClockOffsets | None:
    """Clocks whose offset the job was given, or that the only pair finds; None where they are to be found."""
    offset = job.pair.time_offset
    if isinstance(offset, str):
        return OF_THE_PAIR if len(recordings) == 2 else None
    seconds = [float(offset) * frame_interval(one) for one in recordings[1:]]
    return ClockOffsets((0.0, *seconds), given=True)


def final_clocks(
    offsets: ClockOffsets, recordings: Sequence[Recording], calibration: Calibration
) -> ClockOffsets:
    """Clocks that a network starts from; ``calibration`` is that of the first pair."""
    return offsets_of_pair(recordings[1], calibration) if offsets is OF_THE_PAIR else offsets


def chosen_pairs(
    job: Job, recordings: Mapping[CameraInput, Recording], offsets: ClockOffsets
) -> tuple[list[CameraPair], str | None]:
    """Pairs that are searched, and what to say where those are not all: the likeliest to see the same."""
    cameras = list(recordings)
    pairs = list(combinations(cameras, 2))
    if not job.chooses_pairs:
        return pairs, None
    likely = pairs_to_search(list(recordings.values()), offsets)
    note = (
        f"{len(likely)} of {len(pairs)} pairs are searched, those that are likeliest to see the same; the "
        "network has all"
    )
    return [(cameras[a], cameras[b]) for a, b in likely], note


def pair_options(
    options: PairOptions, offsets: ClockOffsets | None, recordings: Sequence[Recording], a: int, b: int
) -> PairOptions:
    """Options of one pair: of clocks that were found, its offset. Where nothing tells it is taken to be 0.

    The only pair of two cameras finds its offset by itself.
    """
    if options.time_offset != "auto" or offsets is None or len(recordings) == 2:
        return options
    frames = offsets.between(recordings, a, b)
    if frames is None:
        return replace(options, time_offset=0.0)
    return replace(options, time_offset=frames, sharpen_offset=offsets.sharpen)


def why_no_network(job: Job, recordings: Mapping[CameraInput, Recording]) -> str | None:
    """Why no network can be made of what was recorded; None where one can be."""
    if job.pair.method != "frontier":
        return f"method {job.pair.method!r} finds no frontier points, which a network is made of"
    if len(recordings) < 2:
        return "fewer than two cameras could be recorded"
    unknown = [camera.name for camera, one in recordings.items() if one.matrix is None]
    if len(recordings) == 2 and unknown:
        return (
            "two cameras make a network only where both camera matrices are known: give intrinsics, or add a "
            "third camera"
        )
    return None
