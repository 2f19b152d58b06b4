"""Walkers of a run as a file of their own."""

from __future__ import annotations

from pathlib import Path

from ..network.walkers import WalkerTracks

__all__ = ["write_tracks"]


def write_tracks(tracks: WalkerTracks, path: Path) -> list[Path]:
    """Write arrays (``.npz``, no pickle) or a table (``.csv``); see :meth:`epibar.network.WalkerTracks.save`.

    Of m places and n cameras an archive holds ``names`` (n,), ``unit``, ``time`` (m,) in seconds of the
    network's first camera, ``track`` (m,), ``foot`` and ``top`` (m, 3), ``height`` (m,), ``cameras`` (m, n)
    and ``residual`` (m,) in pixels.

    Returns
    -------
    list of Path
        The file.

    Raises
    ------
    EpibarError
        The suffix is another, or the file cannot be written.
    """
    tracks.save(path)
    return [path]
