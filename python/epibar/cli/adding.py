"""Cameras that ``epibar check`` is given and the network does not have: added with ``--update``."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..lens.intrinsics import Intrinsics
    from ..network.checking import NetworkCheck
    from ..network.extending import Extension
    from ..network.knowledge import KnownCamera
    from ..network.offsets import TimeOffset
    from ..network.result import Network
    from ..recording import Recording
    from .console import Console

__all__ = ["Additions", "known_lenses"]


class Additions:
    """What becomes of the cameras that are not in the network.

    Parameters
    ----------
    network : Network
        As it is stored.
    names : iterable of str
        Of all videos.
    lenses : mapping of str to Intrinsics
        Of new cameras, as far as they are known.
    asked : bool
        Whether they are to be added.
    """

    def __init__(
        self, network: Network, names: Iterable[str], lenses: Mapping[str, Intrinsics], asked: bool
    ) -> None:
        from ..network.extending import refuse_spellings

        self.names = [name for name in names if name not in network.cameras]
        self._lenses, self._asked = lenses, asked
        there = ", ".join(network.cameras)
        refuse_spellings(network, self.names)
        reason = f"the network has no camera of that name, it has {there}; --update adds it"
        self.not_added = {} if asked else dict.fromkeys(self.names, reason)
        self._found: Extension | None = None

    @property
    def added(self) -> list[str]:
        """Names of the cameras that are in the network now."""
        return [] if self._found is None else list(self._found.added)

    def failed(self, why: Mapping[str, str]) -> None:
        """Some could not be recorded."""
        self.not_added |= {name: f"not recorded: {why[name]}" for name in self.names if name in why}

    def extended(
        self,
        network: Network,
        check: NetworkCheck,
        recordings: Mapping[str, Recording],
        clocks: TimeOffset,
        args: Namespace,
        console: Console,
    ) -> Network:
        """Return the network with those that can be relied on."""
        from ..errors import EpibarError
        from ..network.extending import extend, with_added

        films = dict(recordings)
        for name in self.names:
            lens = self._lenses.get(name)
            if name in films and lens is not None and lens.size != films[name].size:
                sizes = ["x".join(map(str, one.size)) for one in (lens, films.pop(name))]
                self.not_added[name] = "its lens is of {} frames, and these are {}".format(*sizes)
        new = [name for name in self.names if name in films]
        if not (self._asked and new):
            return network
        # A recording that was made with its lens knows it already.
        lenses = {
            name: lens for name, lens in self._lenses.items() if name in new and films[name].matrix is None
        }
        try:
            self._found = extend(
                network,
                films,
                args.seed,
                clocks,
                known={name: _known(lens) for name, lens in lenses.items()},
                search_seconds=args.search_seconds,
                upright=not args.any_way_up,
                progress=lambda stage, share: console.step(stage, share),
                check=check,
            )
        except EpibarError as error:
            # What was found of the other cameras stands, and is written.
            self.not_added |= dict.fromkeys(new, str(error))
            return network
        self.not_added |= self._found.refused
        return with_added(network, self._found) if self._found.added else network

    def unwritten(self, why: str) -> None:
        """The network that has them could not be written."""
        self.not_added |= dict.fromkeys(self.added, why)
        self._found = None

    def tell(self, console: Console) -> None:
        """Say which are in the network now, and which were not added, and why."""
        if self._found is not None:
            for name, camera in self._found.added.items():
                console.result(f"added: {name}: {camera.reason}")
            if self._found.added and self._found.not_held:
                absent = ", ".join(self._found.not_held)
                console.note(f"{absent} had no part in that, for it is not known to stand as stored")
        for name, why in self.not_added.items():
            console.result(f"{name} was not added: {why}" if self._asked else f"{name}: {why}")

    def as_dict(self) -> dict[str, Any]:
        """Return it as ``epibar check --json`` prints it."""
        found = {} if self._found is None else self._found.added
        added = {name: asdict(camera) for name, camera in found.items()}
        return {**({"added": added} if self._asked else {}), "not_added": self.not_added}


def known_lenses(given: str | None, names: Iterable[str]) -> dict[str, Intrinsics]:
    """Lenses of new cameras in the file that is given; of one that is not in it nothing is known.

    They are not taken out of what is recorded: so the network has the lens of a camera that was added, and
    nothing else that the folder was made with needs to.

    Raises
    ------
    EpibarError
        The file cannot be read, or a lens is one that a network cannot have.
    """
    from ..errors import EpibarError
    from ..lens.cameras_toml import load_cameras

    new = list(names)
    cameras = load_cameras(given) if given is not None and new else []
    by_name = {camera.name.casefold(): camera for camera in cameras}
    found = {name: by_name[name.casefold()] for name in new if name.casefold() in by_name}
    for name, lens in found.items():
        if lens.fisheye:
            raise EpibarError(
                f"{given}: {name} has a fisheye lens, which no camera that is added can have; leave it out "
                "of the file, and its lens is solved for"
            )
        _known(lens).to_core(name)
    return found


def _known(lens: Intrinsics) -> KnownCamera:
    from ..network.knowledge import KnownCamera

    return KnownCamera(lens.matrix, lens.distortions)
