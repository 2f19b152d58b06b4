"""Walkers as tracks over all cameras of a network."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from ..arguments import Array, Bits, Index, core_errors
from ..camera_export.two_views import TwoViews
from ..camera_export.ways import Way
from ..errors import EpibarError
from ..files.archive import write_archive
from ..files.csv_table import csv_text, write_csv_table
from .checking import stored_camera
from .parts import NetworkCamera, NetworkParts
from .recordings import Recordings, named_recordings
from .sightings import WalkerSightings
from .stages import Progress

__all__ = ["COLUMNS", "SEEN_BY", "WalkerTracks", "height_on_floor", "walker_tracks", "write_tracks"]

COLUMNS = (
    *("time", "track", "x", "y", "z", "top_x", "top_y", "top_z", "height"),
    *("cameras", "residual", "unit"),
)
"""Of the table; a column for each camera follows."""

SEEN_BY = "seen by "
"""What the column of a camera starts with."""

GAP = 1.0
"""Seconds without a place after which a track is drawn as another one."""


@dataclass(frozen=True, eq=False, repr=False)
class WalkerTracks:
    """Walkers over all cameras, m places of them in the order of tracks and of time.

    Where it is not clear who is who, or only one camera sees both ends, there is no place: a track has gaps,
    and a walker who was lost has another track afterwards.

    Attributes
    ----------
    names : tuple of str
        The n cameras that were used.
    unit : str
        Of lengths, the network's: "metre" or "baseline".
    time : ndarray, shape (m,)
        Seconds of the network's first camera, since its first frame.
    track : ndarray of int, shape (m,)
        Which walker, from 0.
    foot : ndarray, shape (m, 3)
        The bottom, z up and 0 on the floor: of somebody who walks, the foot or feet that the cameras see
        lowest.
    top : ndarray, shape (m, 3)
        The top, mostly of a head.
    cameras : ndarray of bool, shape (m, n)
        Which cameras saw both.
    residual : ndarray, shape (m,)
        Pixels: root mean square of what top and bottom are off in these cameras.
    height : ndarray, shape (m,)
        How far the top is above the bottom.
    sightings : WalkerSightings or None
        Where in the images each two cameras saw it. None of tracks that were read from a table.
    """

    names: tuple[str, ...]
    unit: str
    time: Array
    track: Index
    foot: Array
    top: Array
    cameras: Bits
    residual: Array
    sightings: WalkerSightings | None = None

    @property
    def height(self) -> Array:
        """How far the top is above the bottom, (m,)."""
        height: Array = self.top[:, 2] - self.foot[:, 2]
        return height

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        walkers = len(np.unique(self.track))
        return f"<WalkerTracks {walkers} tracks, {len(self)} places, {len(self.names)} cameras, {self.unit}>"

    def scaled(self, factor: float, unit: str) -> WalkerTracks:
        """Return the same tracks in another unit, of which the present one has so many."""
        return replace(self, unit=unit, foot=factor * self.foot, top=factor * self.top)

    def ways(self) -> list[Way]:
        """Return each walker as one line or, where a second and more is not known, as several."""
        found: list[Way] = []
        for track in np.unique(self.track):
            rows = np.flatnonzero(self.track == track)
            rows = rows[np.argsort(self.time[rows], kind="stable")]
            gaps = np.flatnonzero(np.diff(self.time[rows]) > GAP) + 1
            parts = np.split(rows, gaps)
            names = [
                f"walker {track}" + (f" part {k + 1}" if len(parts) > 1 else "") for k in range(len(parts))
            ]
            found += [
                Way(name, self.time[part], self.foot[part], self.top[part])
                for name, part in zip(names, parts, strict=True)
            ]
        return found

    def two_views(self) -> list[TwoViews]:
        """Return the tops and bottoms that each two cameras saw, in the order of time."""
        seen = self.sightings
        if seen is None:
            return []
        found = []
        for a, b in np.unique(seen.cameras, axis=0).tolist():
            rows = np.flatnonzero((seen.cameras == (a, b)).all(axis=1))
            rows = rows[np.argsort(self.time[seen.place[rows]], kind="stable")]
            ends = np.stack([seen.top[rows], seen.foot[rows]], axis=1).reshape(-1, 2, 2)
            found.append(TwoViews(self.names[a], self.names[b], ends[:, 0], ends[:, 1]))
        return found

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a table (``.csv``) or the arrays (``.npz``, no pickle).

        In the table a name that a spreadsheet would take for a formula has an apostrophe before it. Of m
        places and n cameras an archive holds ``names`` (n,), ``unit``, ``time`` (m,) in seconds of the
        network's first camera, ``track`` (m,), ``foot`` and ``top`` (m, 3), ``height`` (m,), ``cameras``
        (m, n) and ``residual`` (m,) in pixels.

        Raises
        ------
        EpibarError
            The suffix is another, or the file cannot be written.
        """
        suffix = Path(path).suffix.lower()
        if suffix == ".csv":
            seen_by = [csv_text(SEEN_BY + name) for name in self.names]
            write_csv_table(path, [*COLUMNS, *seen_by], self._rows())
        elif suffix == ".npz":
            write_archive(path, self._arrays())
        else:
            raise EpibarError(f"{os.fspath(path)}: tracks are written as .csv or .npz")

    def _rows(self) -> list[list[Any]]:
        lengths = np.column_stack([self.foot, self.top, self.height])
        tall = float(np.median(self.height)) if len(self) else 1.0
        # To a ten-thousandth of how tall people are at least, in whatever unit.
        digits = max(4, 4 - math.floor(math.log10(tall))) if tall > 0 else 4
        return [
            [
                f"{self.time[k]:.4f}",
                int(self.track[k]),
                *(f"{round(float(value), digits) + 0.0:.{digits}f}" for value in lengths[k]),
                int(self.cameras[k].sum()),
                f"{self.residual[k]:.3f}",
                self.unit,
                *self.cameras[k].astype(int).tolist(),
            ]
            for k in range(len(self))
        ]

    def _arrays(self) -> dict[str, Any]:
        return {
            "names": np.array(self.names, dtype=np.str_),
            "unit": np.array(self.unit),
            "time": self.time,
            "track": self.track,
            "foot": self.foot,
            "top": self.top,
            "height": self.height,
            "cameras": self.cameras,
            "residual": self.residual,
        }


def height_on_floor(network: NetworkParts) -> float | None:
    """Median height of those who stand on the floor; None where none was found, to follow anybody on."""
    ground = network.ground
    return ground.height or None if ground.source == "floor" else None


def walker_tracks(
    network: NetworkParts, recordings: Recordings, progress: Progress | None = None
) -> WalkerTracks:
    """Follow walkers over all cameras; see :meth:`epibar.Network.tracks`."""
    films = named_recordings(recordings)
    height = height_on_floor(network)
    if height is None:
        raise EpibarError(
            "tracks are of those who stand on a floor, and none was found: nothing tells whose tops and "
            "bottoms belong together"
        )
    network.refuse_unknown(films)
    accepted = [name for name, camera in network.cameras.items() if camera.accepted]
    names = [name for name in accepted if name in films]
    if len(names) < 2:
        raise EpibarError(
            f"tracks need recordings of two accepted cameras; of {', '.join(accepted) or 'none'} "
            f"there are {len(names)}"
        )
    cameras = [_with_clock(network, network.cameras[name], films) for name in names]
    report = None if progress is None else lambda _, share: progress("tracks", share)
    with core_errors():
        found = _core.walker_tracks([films[name]._core for name in names], cameras, height, report)
    sightings = WalkerSightings(**found.pop("sightings"))
    return WalkerTracks(tuple(names), network.unit, **found, sightings=sightings)


def _with_clock(network: NetworkParts, camera: NetworkCamera, films: Mapping[str, Any]) -> dict[str, Any]:
    clock = network.clocks[camera.name]
    if clock.offset is None:
        raise EpibarError(f"{camera.name}: the network has no clock of it")
    stored = stored_camera(camera, films[camera.name])
    return {"camera": stored["camera"], "clock": (clock.offset, clock.drift or 0.0)}


def write_tracks(tracks: WalkerTracks, path: Path) -> list[Path]:
    """Write what :meth:`WalkerTracks.save` writes, as a format of ``epibar export``.

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
