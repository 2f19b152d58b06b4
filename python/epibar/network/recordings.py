"""Recordings of several cameras, by the names of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..arguments import camera_names
from ..errors import EpibarError, address_without_secrets, is_address
from ..recording import Recording, as_recording

__all__ = ["Recordings", "films_of", "named_recordings"]

Recordings = Mapping[str, Recording] | Sequence[Recording]


def films_of(recordings: Any) -> list[Recording]:
    """Return recordings in their order, whatever their cameras are called.

    Raises
    ------
    EpibarError
        No recordings, or an address for a name.
    """
    if isinstance(recordings, Mapping):
        for name, one in recordings.items():
            _refuse_address(str(name))
            as_recording(f"recordings[{name!r}]", one)
        return list(recordings.values())
    if isinstance(recordings, Sequence) and not isinstance(recordings, str):
        return [as_recording(f"recordings[{index}]", one) for index, one in enumerate(recordings)]
    raise EpibarError(
        f"recordings is a {type(recordings).__name__}, expected recordings by the names of their cameras"
    )


def named_recordings(recordings: Any) -> dict[str, Recording]:
    """Return recordings by the names of their cameras.

    Raises
    ------
    EpibarError
        Fewer than two, no recordings, or two of one name.
    """
    films = films_of(recordings)
    if isinstance(recordings, Mapping):
        found = dict(zip(map(str, recordings), films, strict=True))
        if len(found) < len(films) or "" in found:
            raise EpibarError(f"cameras are called {', '.join(map(repr, recordings))}: names must differ")
    else:
        found = dict(zip(camera_names(one.name for one in films), films, strict=True))
        for name in found:
            _refuse_address(name)
    if len(found) < 2:
        raise EpibarError(f"recordings: {len(found)} given, but a network has at least two cameras")
    return found


def _refuse_address(name: str) -> None:
    """Refuse an address for a name, and show nothing of it that is secret."""
    if is_address(name):
        shown = address_without_secrets(name)
        raise EpibarError(f"{shown}: an address, which may hold a password, is no name of a camera")
