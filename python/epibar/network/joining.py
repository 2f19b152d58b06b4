"""Pairs that were calibrated become one network."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from .. import _core
from ..arguments import core_errors
from ..calibration import Calibration
from ..errors import EpibarError
from .core_result import network_of
from .knowledge import KnownCamera, knowledge_of
from .offsets import ClockOffsets, as_offsets
from .pair_search import pair_to_core
from .recordings import Recordings, named_recordings
from .result import Network

__all__ = ["join_pairs"]


def join_pairs(
    recordings: Recordings,
    calibrations: Mapping[tuple[str, str], Calibration],
    offsets: ClockOffsets,
    *,
    known: Mapping[str, KnownCamera] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Network:
    """Make one network of pairs that are calibrated already.

    Parameters
    ----------
    recordings : mapping of str to Recording, or sequence of Recording
        Of all cameras.
    calibrations : mapping of (str, str) to Calibration
        By the names of two cameras in the order of the recordings; not all pairs need be there, and refused
        ones are of use.
    offsets : ClockOffsets
        Of the clocks of all cameras, from :func:`find_offsets` or given.
    known : mapping of str to KnownCamera, optional
        What is known of cameras whose lens was not taken out.
    progress : callable, optional
        Called with the name of the stage and the share of it that is done.

    Returns
    -------
    Network
        Also where there is none: then no camera is accepted, and each says why.

    Raises
    ------
    EpibarError
        An argument is of the wrong kind or out of its range.
    """
    cameras = named_recordings(recordings)
    names = list(cameras)
    as_offsets(offsets, len(names))
    knowledge = knowledge_of(cameras, known)
    pairs = []
    for key, calibration in calibrations.items():
        if not (isinstance(key, tuple) and len(key) == 2 and all(name in cameras for name in key)):
            raise EpibarError(
                f"calibrations have key {key!r}: expected two of the cameras {', '.join(names)}"
            )
        a, b = (names.index(name) for name in key)
        if a >= b:
            raise EpibarError(f"calibrations have key {key!r}: the two in the order of the recordings")
        if calibration.F is not None:
            pairs.append(pair_to_core(a, b, calibration))
    with core_errors():
        found = _core.join_network(
            [one._core for one in cameras.values()], names, knowledge, pairs, offsets.to_core(), progress
        )
    return network_of(found, cameras)
