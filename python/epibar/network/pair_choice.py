"""Which pairs of many cameras are worth a search."""

from __future__ import annotations

from collections.abc import Sequence

from .. import _core
from ..arguments import core_errors
from ..recording import Recording
from .offsets import ClockOffsets, as_offsets
from .recordings import Recordings, films_of

__all__ = ["ALL_PAIRS", "pairs_to_add", "pairs_to_search"]

ALL_PAIRS = _core.ALL_PAIRS
"""Of so many cameras every pair is searched; of more those that are likeliest to see the same."""


def pairs_to_search(recordings: Recordings, offsets: ClockOffsets) -> list[tuple[int, int]]:
    """Choose pairs that are worth a search: all of few cameras, of many those likeliest to see the same.

    Parameters
    ----------
    recordings : mapping of str to Recording, or sequence of Recording
    offsets : ClockOffsets
        Of their clocks; pairs of which nothing tells the offset are left out.

    Returns
    -------
    list of (int, int)
        Places a < b among the recordings.

    Raises
    ------
    EpibarError
        An argument is of the wrong kind, or there are more or fewer clocks than recordings.
    """
    films = films_of(recordings)
    clocks = as_offsets(offsets, len(films)).to_core()
    with core_errors():
        return _core.pairs_to_search([one._core for one in films], clocks)


def pairs_to_add(
    recordings: Sequence[Recording], stored: int, offsets: ClockOffsets
) -> list[tuple[int, int]]:
    """Places a < b of the pairs of a stored and a new camera worth a search; the stored ones come first."""
    with core_errors():
        return _core.pairs_to_add([one._core for one in recordings], stored, offsets.to_core())
