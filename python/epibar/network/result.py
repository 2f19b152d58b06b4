"""A network of cameras: a value, whose steps return another one."""

from __future__ import annotations

import logging
import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..arguments import check_choice
from ..calibration import SEARCH_SECONDS
from ..camera_export.formats import CAMERA_FORMATS
from ..camera_export.world import BY_CAMERAS, ON_FLOOR, World
from ..errors import EpibarError
from ..files.json_file import read_json_object, write_json
from ..geometry.correspondences import FrontierPoints
from ..lens.intrinsics import Intrinsics
from .checking import NetworkCheck, check_network
from .extending import extend, with_added
from .knowledge import KnownCamera, lenses_by_name
from .metres import NOT_IN_METRES, rescaled
from .offsets import TimeOffset
from .parts import BASELINE, METRE, NetworkParts
from .prose import pixels_note
from .recordings import Recordings
from .saved import as_dict, as_file, network_from
from .stages import Progress
from .start_times import StartTime, start_times
from .two_views import two_views
from .updating import moved_parts
from .walkers import WalkerTracks, walker_tracks

__all__ = ["Network"]

logger = logging.getLogger("epibar")


@dataclass(frozen=True, eq=False, repr=False)
class Network(NetworkParts):
    """Many cameras, calibrated together.

    Attributes
    ----------
    cameras : dict of str to NetworkCamera
        In the order given. A network may be partial: look at ``accepted`` of each.
    pairs : mapping of (str, str) to NetworkPair
        Of all cameras; ``pairs["b", "a"]`` is ``pairs["a", "b"]`` with F transposed.
    clocks : dict of str to NetworkClock
    accepted : bool
        Whether every camera is accepted.
    reason : str
        What was found, or what is wrong, in plain English.
    unit : str
        "metre", or "baseline": the distance between the first two cameras that stand.
    ground : Ground
    radius : float or None
        Pixels of a 640×480 image within which tangents met in the end.
    scale : Scale or None
        What metres rest on; None for the unit "baseline".
    """

    def __repr__(self) -> str:
        accepted = sum(camera.accepted for camera in self.cameras.values())
        return (
            f"<Network {accepted} of {len(self.cameras)} cameras accepted, unit {self.unit}: {self.reason}>"
        )

    @property
    def left_out(self) -> list[str]:
        """Names of the cameras that are not accepted, which no export holds."""
        return [name for name, camera in self.cameras.items() if not camera.accepted]

    def scaled(
        self, *, distance: Any = (), person_height: Any = None, camera_height: Any = (), keep: bool = False
    ) -> Network:
        """Return the same network in metres.

        All that is given is combined by its accuracy, and replaces or keeps what an earlier scale rested on.

        Parameters
        ----------
        distance : tuple (str, str, float) or list of such
            Metres between two cameras. Good to 1 %, or 1 cm where that is more; a fourth value is another
            standard error, metres: ``("cam1", "cam2", 4.20, 0.01)``.
        person_height : float or tuple (float, float), optional
            Metres that those who walk measure in the median, as they walk; good to 3 %, or to the second
            value, metres.
        camera_height : tuple (str, float) or list of such
            Metres of a camera above the floor; as good as a distance, or to the third value, metres.
        keep : bool
            Combine it with what an earlier scale rested on, too, and refuse what contradicts that. The same
            length given again replaces the one before.

        Returns
        -------
        Network
            With unit "metre".

        Raises
        ------
        EpibarError
            Nothing is given; a camera is unknown or not accepted; there is no floor that people stand on; or
            two of the lengths contradict each other.
        """
        cameras, ground, scale = rescaled(self, distance, person_height, camera_height, keep)
        reason = self.reason.partition(NOT_IN_METRES)[0]
        return replace(self, cameras=cameras, ground=ground, unit=METRE, scale=scale, reason=reason)

    def check(
        self,
        recordings: Recordings,
        time_offset: TimeOffset = "auto",
        progress: Progress | None = None,
        *,
        search_seconds: float = SEARCH_SECONDS,
    ) -> NetworkCheck:
        """Tell whether a camera has moved since, from new recordings of all cameras or of some.

        Cameras that are not accepted, or of which there is no new recording, are not looked at.

        Parameters
        ----------
        recordings : mapping of str to Recording, or sequence of Recording
            By the names of the cameras, over the same time; a minute or so. Recorded as when the network was
            made: raw ones are taken to be through the stored matrix and distortions, which are 0 where lenses
            were taken out then; one whose lens was taken out must have the stored matrix.
        time_offset : "auto", float, or mapping of str to float
            Of the clocks of the new recordings, as :func:`epibar.calibrate_network` takes it. Those of the
            network say nothing of them.
        progress : callable, optional
            Called with the name of the stage, "clocks" or "check", and the share of it that is done.
        search_seconds : float
            How far either way an offset is looked for.

        Returns
        -------
        NetworkCheck
            Look at ``ok``, ``moved`` and ``unsure``.

        Raises
        ------
        EpibarError
            A recording is of no camera of the network, or of another size or camera matrix; or fewer than two
            cameras can be looked at.
        """
        return check_network(self, recordings, time_offset, search_seconds, progress)

    def updated(self, check: NetworkCheck) -> Network:
        """Return the network with the cameras that moved where they stand now; all else stays as it is.

        Cameras whose new place is not confirmed stay as well: look at ``place`` of each of the check's. What
        is expected of a camera that was solved for again is its own error against the cameras that did not
        move, and what these are expected to be wrong by, added as independent. Clocks, ground and scale are
        still those of the recordings that the network was made of.

        Parameters
        ----------
        check : NetworkCheck
            Of this network, by :meth:`check`.

        Raises
        ------
        EpibarError
            The check is of another network.
        """
        cameras, pairs = moved_parts(self, check)
        return replace(self, cameras=cameras, pairs=pairs)

    def extended(
        self,
        recordings: Recordings,
        seed: int = 0,
        time_offset: TimeOffset = "auto",
        known: Mapping[str, KnownCamera] | None = None,
        progress: Progress | None = None,
        *,
        search_seconds: float = SEARCH_SECONDS,
        upright: bool = True,
    ) -> Network:
        """Return the network with one more camera, or several, by footage that all of them filmed together.

        Cameras of the network are held as they are stored; those that moved since, or cannot be judged, as
        :meth:`check` tells, have no part in it. Of a new one the focal length, lens, rotation, position and
        clock are solved for, in the world of the network: its floor, its vertical and its unit. Two cameras
        of the network must confirm it on moments kept aside. One that cannot be relied on is not added:
        ``reason`` says why, and so does the log. What is expected of a new camera are its own errors, and the
        root mean square of what the cameras that confirm it are expected to be wrong by, added as
        independent. Its clock is that of the new footage, against the stored clock of the first camera that
        was held: of use where all were started as when the network was made.

        Parameters
        ----------
        recordings : mapping of str to Recording, or sequence of Recording
            By the names of the cameras, over the same time; a minute or two. Names that the network has are
            its cameras, of which at least two are needed, recorded as for :meth:`check`; the others are new.
        seed : int
            Of every random draw of the search; how flat motion is judged does not depend on it.
        time_offset : "auto", float, or mapping of str to float
            Of the clocks of these recordings, as :func:`epibar.calibrate_network` takes it.
        known : mapping of str to KnownCamera, optional
            What is known of new cameras whose lens was not taken out.
        progress : callable, optional
            Called with the name of the stage, "clocks", "check", "pairs" or "network", and the share of it
            that is done.
        search_seconds : float
            How far either way an offset is looked for.
        upright : bool
            All cameras are the right way up, see :func:`epibar.calibrate`.

        Returns
        -------
        Network

        Raises
        ------
        EpibarError
            No camera is new; fewer than two accepted ones of the network have a recording; or one of these is
            of another size or camera matrix.

        Examples
        --------
        >>> import epibar
        >>> net = epibar.Network.load("network.json")  # of cam1 and cam2
        >>> films = {name: epibar.Recording.load(f"{name}.npz") for name in ["cam1", "cam2", "cam3"]}
        >>> more = net.extended(films)
        >>> if "cam3" in more.cameras:
        ...     camera = more.cameras["cam3"]
        ...     K, R, t = camera.matrix, camera.rotation, camera.translation
        >>> why_not = more.reason
        """
        found = extend(
            self,
            recordings,
            seed,
            time_offset,
            known=known,
            search_seconds=search_seconds,
            upright=upright,
            progress=progress,
        )
        for name, why in found.refused.items():
            logger.warning("%s was not added: %s", name, why)
        return with_added(self, found)

    def tracks(self, recordings: Recordings, progress: Progress | None = None) -> WalkerTracks:
        """Follow walkers over all cameras: where their tops and bottoms are in space, from second to second.

        Parameters
        ----------
        recordings : mapping of str to Recording, or sequence of Recording
            What the network was made of, or others by the same clocks; of two accepted cameras or more.
        progress : callable, optional
            Called with "tracks" and the share that is done.

        Returns
        -------
        WalkerTracks

        Raises
        ------
        EpibarError
            No floor was found that walkers stand on; fewer than two accepted cameras have a recording; or one
            is of no camera of the network, or of another size or camera matrix.
        """
        return walker_tracks(self, recordings, progress)

    def start_times(self, recordings: Recordings | Mapping[str, float]) -> dict[str, StartTime]:
        """Tell from which frame of each video on, and up to which, all accepted cameras film together.

        Parameters
        ----------
        recordings : mapping of str to Recording or float, or sequence of Recording
            What the network was made of; or the frames per second of each camera, from which no common end
            follows.

        Returns
        -------
        dict of str to StartTime
            Of the accepted cameras.

        Raises
        ------
        EpibarError
            Fewer than two accepted cameras are given, one is not of the network, or no moment is common.
        """
        return start_times(self, recordings)

    def export(
        self,
        path: str | os.PathLike[str],
        format: str = "anipose",  # noqa: A002
        lenses: Mapping[str, Intrinsics] | None = None,
        tracks: WalkerTracks | None = None,
        frontier_points: Mapping[tuple[str, str], FrontierPoints] | None = None,
    ) -> list[Path]:
        """Write the accepted cameras for another program; :attr:`left_out` are the others, which it names.

        Parameters
        ----------
        path : str or path
            A file; for "colmap" and "easymocap" a folder.
        format : str
            "anipose", "caliscope", "freemocap", "pose2sim", "easymocap", "opencv", "colmap", "nerfstudio",
            "gltf", "rerun" or "npz". What one loses is logged, and stands in the file.
        lenses : mapping of str to Intrinsics, optional
            Lenses that were taken out of recordings, to be written with the cameras of their names.
        tracks : WalkerTracks, optional
            Of this network's :meth:`tracks`, to be written with the cameras; "gltf" and "rerun" have a place
            for walkers, "colmap" for their tops and bottoms, as points that two cameras see.
        frontier_points : mapping of (str, str) to FrontierPoints, optional
            Of pairs that were calibrated by themselves, in pixels of the recordings, for "colmap". Those of
            pairs that are not accepted here, or whose cameras share walkers of ``tracks``, are left out.

        Returns
        -------
        list of Path
            What was written.

        Raises
        ------
        EpibarError
            No camera is accepted, the format is unknown or has no place for a lens, for walkers or for
            points, a lens is of no camera or another size, tracks are in another unit or lack what is to be
            written, or a file cannot be written.
        """
        check_choice("format", format, CAMERA_FORMATS)
        if tracks is not None:
            self._refuse_misplaced(tracks, format)
        if frontier_points is not None and not CAMERA_FORMATS[format].points:
            raise EpibarError(f"format = {format!r} has no place for frontier points")
        accepted = [camera for camera in self.cameras.values() if camera.accepted]
        if not accepted:
            raise EpibarError(f"no camera is accepted, so there is nothing to export: {self.reason}")
        for name in self.left_out:
            logger.warning("%s: left out: %s: %s", os.fspath(path), name, self.cameras[name].why_left_out)
        lenses = lenses_by_name(lenses, {name: camera.size for name, camera in self.cameras.items()})
        cameras = [camera.intrinsics(lenses.get(camera.name)) for camera in accepted]
        chosen = CAMERA_FORMATS[format]
        if chosen.unit != "network" and self.unit != METRE:
            logger.warning(
                "%s: %s counts in %ss, and the scale of this network is not known: bring it to metres first",
                os.fspath(path),
                chosen.program,
                chosen.unit,
            )
        world = replace(self._world(lenses), ways=tuple(tracks.ways()) if tracks is not None else ())
        if chosen.points:
            world = replace(world, two_views=two_views(self, lenses, tracks, frontier_points))
        return chosen.write(cameras, Path(path), world)

    def _refuse_misplaced(self, tracks: WalkerTracks, format: str) -> None:  # noqa: A002
        """Refuse tracks that the format has no place for, or that are in another unit."""
        if not CAMERA_FORMATS[format].tracks:
            having = ", ".join(name for name, one in CAMERA_FORMATS.items() if one.tracks)
            raise EpibarError(f"format = {format!r} has no place for walkers; these have: {having}")
        if not isinstance(tracks, WalkerTracks):
            raise EpibarError(f"tracks is a {type(tracks).__name__}, expected what Network.tracks returned")
        if tracks.unit != self.unit:
            raise EpibarError(
                f"tracks are in {tracks.unit}s and the network in {self.unit}s: "
                "make them anew with Network.tracks, or bring them over with WalkerTracks.scaled"
            )

    def _world(self, lenses: Collection[str]) -> World:
        """What a camera file says of itself, beside its cameras."""
        unit = self.unit
        if self.unit == BASELINE:
            first, second = [name for name, camera in self.cameras.items() if camera.rotation is not None][:2]
            unit = f"the distance between {first} and {second} when calibrated, not metres"
        up, zero = ON_FLOOR if self.ground.source == "floor" else BY_CAMERAS
        notes = [self.reason, *(self.scale.sources if self.scale else ()), *pixels_note(self, lenses)]
        notes += [f"left out: {name}: {self.cameras[name].why_left_out}" for name in self.left_out]
        return World(unit, zero, up, tuple(notes))

    def as_dict(self) -> dict[str, Any]:
        """Return it as it stands in ``network.json`` and under ``network`` in ``calibration.json``."""
        return as_dict(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to a JSON file, whole or not at all.

        Raises
        ------
        EpibarError
            The file cannot be written.
        """
        write_json(path, as_file(self))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Network:
        """Read what :meth:`save` wrote.

        Raises
        ------
        EpibarError
            The file is missing, damaged, something else, or of another format.
        """
        return network_from(cls, read_json_object(path, "a network saved by epibar"), os.fspath(path))
