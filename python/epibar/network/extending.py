"""One more camera for a network, put where it stands by what it and others of it filmed together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from .. import _core
from ..arguments import MAX_SEED, as_positive, as_whole_number, core_errors
from ..errors import EpibarError
from ..geometry.vectors import angle_between
from ..recording import Recording
from .checking import UNMOVED, NetworkCheck, check_network, stored_camera
from .core_parts import camera_of, clock_of, pair_of
from .knowledge import KnownCamera, knowledge_of, known_by_name
from .metres import NOT_IN_METRES
from .offsets import ClockOffsets, TimeOffset, find_offsets, given_offsets
from .pair_choice import pairs_to_add
from .pair_search import pair_to_core, search_pairs
from .parts import NetworkCamera, NetworkClock, NetworkPair, NetworkPairs, NetworkParts
from .placed_pairs import placed_pair
from .recordings import Recordings, named_recordings
from .stages import Progress, as_stage

__all__ = ["Extension", "extend", "refuse_spellings", "with_added"]

N = TypeVar("N", bound=NetworkParts)

LEAST_HELD = 2
"""Cameras of the network that must stand as stored: two directions are needed for a place."""

TOO_FEW = "too_few"
"""Status of a camera that nothing can be said of, as too few others stand."""

SAME_CAMERA = "same_camera"
"""Status of one that stands where another of the network is stored, of which there is no film."""


@dataclass(frozen=True, eq=False)
class Extension:
    """Cameras that were to be added to a network.

    Attributes
    ----------
    check : NetworkCheck
        Of the cameras of the network that were filmed anew.
    cameras : dict of str to NetworkCamera
        The new ones; what is not accepted says why, and is not added.
    clocks : dict of str to NetworkClock
        Of those that are accepted.
    pairs : list of NetworkPair
        Of these with the cameras that were held, and with one another.
    held : list of str
        Cameras of the network that stand as stored, by which the new ones were placed.
    """

    check: NetworkCheck
    cameras: dict[str, NetworkCamera]
    clocks: dict[str, NetworkClock] = field(default_factory=dict)
    pairs: list[NetworkPair] = field(default_factory=list)
    held: list[str] = field(default_factory=list)

    @property
    def added(self) -> dict[str, NetworkCamera]:
        """Those that can be relied on."""
        return {name: camera for name, camera in self.cameras.items() if camera.accepted}

    @property
    def refused(self) -> dict[str, str]:
        """The others, and why."""
        return {name: camera.reason for name, camera in self.cameras.items() if not camera.accepted}

    @property
    def not_held(self) -> list[str]:
        """Cameras that were filmed anew by which none was placed: they may not stand as stored."""
        return [name for name in self.check.cameras if name not in self.held]


def extend(
    network: NetworkParts,
    recordings: Recordings,
    seed: int = 0,
    time_offset: TimeOffset = "auto",
    *,
    known: Mapping[str, KnownCamera] | None = None,
    search_seconds: float,
    upright: bool = True,
    progress: Progress | None = None,
    check: NetworkCheck | None = None,
) -> Extension:
    """Find where new cameras stand; see :meth:`epibar.Network.extended`.

    ``check`` is one of the same recordings, where it was made already.
    """
    films = named_recordings(recordings)
    seed = as_whole_number("seed", seed, 0, MAX_SEED)
    reach = as_positive("search_seconds", search_seconds, "seconds")
    old = {name: one for name, one in films.items() if name in network.cameras}
    new = {name: one for name, one in films.items() if name not in network.cameras}
    _refuse(network, old, new)
    knowledge = _known(new, old, known)
    given = given_offsets(list(films), time_offset)
    seconds = None if given is None else dict(zip(films, given.seconds, strict=True))
    if check is None:
        clocks: TimeOffset = "auto" if seconds is None else {name: seconds[name] for name in old}
        check = check_network(network, old, clocks, reach, progress)
    held = [name for name in network.cameras if name in check.cameras and _stands(check, name)]
    if len(held) < LEAST_HELD:
        return Extension(check, {name: _alone(name, one, check) for name, one in new.items()})
    cameras = {**{name: films[name] for name in held}, **new}
    if seconds is None:
        offsets = _clocks(cameras, len(held), reach, as_stage("clocks", progress))
    else:
        offsets = ClockOffsets(tuple(seconds[n] - seconds[held[0]] for n in cameras), given=True)
    # A camera of which no clock is known has no part.
    at = dict(zip(cameras, offsets.seconds, strict=True))
    held = [name for name in held if math.isfinite(at[name])]
    if len(held) < LEAST_HELD:
        return Extension(check, {name: _alone(name, one, check) for name, one in new.items()})
    cameras = {name: films[name] for name in (*held, *new)}
    offsets = replace(offsets, seconds=tuple(at[name] for name in cameras))
    chosen = pairs_to_add(list(cameras.values()), len(held), offsets)
    searched = search_pairs(cameras, chosen, offsets, seed=seed, upright=upright, progress=progress)
    names = list(cameras)
    pairs = [
        pair_to_core(a, b, searched[names[a], names[b]])
        for a, b in chosen
        if searched[names[a], names[b]].F is not None
    ]
    with core_errors():
        found = _core.add_cameras(
            [one._core for one in cameras.values()],
            names,
            [stored_camera(network.cameras[name], films[name]) for name in held],
            knowledge,
            pairs,
            offsets.to_core(),
            as_stage("network", progress),
        )
    return _extension(network, check, found, new, held)


def _refuse(network: NetworkParts, old: Mapping[str, Recording], new: Mapping[str, Recording]) -> None:
    """Refuse what cannot be added to, before any work."""
    if not new:
        raise EpibarError(
            f"{', '.join(old)}: all of these are in the network, so there is none to add; check() tells "
            "whether they moved"
        )
    refuse_spellings(network, new)
    usable = [name for name in old if network.cameras[name].accepted]
    if len(usable) < LEAST_HELD:
        raise EpibarError(
            f"to add {', '.join(new)} new recordings of at least two accepted cameras of the network are "
            "needed, by the names that they have there, filmed at the same time; there are "
            f"{len(usable)}. It has {', '.join(network.cameras)}"
        )


def refuse_spellings(network: NetworkParts, new: Iterable[str]) -> None:
    """Refuse new cameras whose names differ from those of others by upper and lower case only.

    Raises
    ------
    EpibarError
        A name does.
    """
    spelt = {name.casefold(): name for name in network.cameras}
    for name in new:
        other = spelt.setdefault(name.casefold(), name)
        if other != name:
            raise EpibarError(
                f"{name} and {other} differ by upper and lower case only: one camera has one name; give it "
                "the name that it has in the network, or another one if it is another camera"
            )


def _known(
    new: Mapping[str, Recording], old: Mapping[str, Recording], known: Mapping[str, KnownCamera] | None
) -> list[dict[str, Any]]:
    """What is known of each new camera; of those of the network it is the network that knows."""
    for name in known_by_name(known):
        if name in old:
            raise EpibarError(f"known has {name!r}, but the network has its lens: leave it out of known")
    return knowledge_of(new, known)


def _stands(check: NetworkCheck, name: str) -> bool:
    return check.cameras[name].status == UNMOVED


def _alone(name: str, recording: Recording, check: NetworkCheck) -> NetworkCamera:
    """Return a camera that too few others can place."""
    reason = (
        f"left out: at least two cameras of the network must stand as stored to place it, and {check.reason}"
    )
    return NetworkCamera(name, recording.size, False, TOO_FEW, reason)


def _clocks(
    cameras: Mapping[str, Recording], held: int, reach: float, progress: Progress | None
) -> ClockOffsets:
    """Find the clocks of all: each new camera's beside those that are held, so that none spoils another's."""
    films = list(cameras.values())
    of_held = find_offsets(films[:held], reach, progress)
    of_new = [find_offsets([*films[:held], film], reach, progress) for film in films[held:]]
    together = of_held.together and all(one.together for one in of_new)
    return ClockOffsets((*of_held.seconds, *(one.seconds[-1] for one in of_new)), together)


def _extension(
    network: NetworkParts,
    check: NetworkCheck,
    found: Mapping[str, Any],
    new: Mapping[str, Recording],
    held: Sequence[str],
) -> Extension:
    """What the compiled module says of the new cameras."""
    cameras = {
        one["name"]: camera_of(one, new[one["name"]].size, new[one["name"]]) for one in found["cameras"]
    }
    not_filmed = [one for name, one in network.cameras.items() if one.accepted and name not in check.cameras]
    cameras = {name: _unless_stored(camera, not_filmed) for name, camera in cameras.items()}
    accepted = [name for name, camera in cameras.items() if camera.accepted]
    clocks = {
        one["name"]: _in_network_time(clock_of(one), network.clocks.get(held[0], NetworkClock()))
        for one in found["cameras"]
        if one["name"] in accepted
    }
    names = [*held, *cameras]
    pairs = [pair for one in found["pairs"] if (pair := pair_of(one, names)).b in accepted]
    pairs = [pair for pair in pairs if pair.a in accepted or pair.a in held]
    return Extension(check, cameras, clocks, pairs, list(held))


def _unless_stored(camera: NetworkCamera, not_filmed: Iterable[NetworkCamera]) -> NetworkCamera:
    """Return a new camera, refused where it may be one of the network by another name."""
    for other in not_filmed if camera.accepted else ():
        if not _may_be_one(camera, other):
            continue
        reason = (
            f"left out: it stands where {other.name} is stored, of which there is no film: if it is that "
            f"camera, name the film {other.name}; if another took its place, calibrate anew"
        )
        return NetworkCamera(camera.name, camera.size, False, SAME_CAMERA, reason)
    return camera


def _may_be_one(one: NetworkCamera, other: NetworkCamera) -> bool:
    """Whether two cameras stand at one place and look one way, within what is stated of both."""
    if one.position is None or other.position is None or one.expected is None or other.expected is None:
        return False
    assert one.rotation is not None
    assert other.rotation is not None
    turn = angle_between(one.rotation, other.rotation)
    apart = np.linalg.norm(one.position - other.position)
    within = turn <= one.expected["rotation"] + other.expected["rotation"]
    return bool(within and apart <= one.expected["position"] + other.expected["position"])


def _in_network_time(clock: NetworkClock, reference: NetworkClock) -> NetworkClock:
    """A clock against that of a camera of the network, against that of the network's first."""
    if clock.offset is None or reference.offset is None:
        return NetworkClock()
    rate = 1 + 1e-6 * (clock.drift or 0.0)
    drift = 1e6 * ((1 + 1e-6 * (reference.drift or 0.0)) * rate - 1)
    errors = (clock.offset_error, reference.offset_error)
    error = None if None in errors else math.hypot(*(one for one in errors if one is not None))
    return NetworkClock(clock.offset + reference.offset * rate, drift, error)


def with_added(network: N, extension: Extension) -> N:
    """Return a network with the cameras of an extension of it that are accepted; its reason names all."""
    new = extension.added
    cameras = {**network.cameras, **new}
    there = {(pair.a, pair.b): pair for pair in (*network.pairs.values(), *extension.pairs)}
    names = list(cameras)
    pairs = []
    for k, a in enumerate(names):
        for b in names[k + 1 :]:
            key = (a, b) if (a, b) in there or (b, a) not in there else (b, a)
            pairs.append(there[key] if key in there else placed_pair(cameras[a], cameras[b]))
    reason, before, why = network.reason.partition(NOT_IN_METRES)
    said = [reason]
    said += [f"added later: {', '.join(new)}"] if new else []
    said += [f"{name} was not added: {why}" for name, why in extension.refused.items()]
    return replace(
        network,
        cameras=cameras,
        clocks={**network.clocks, **extension.clocks},
        pairs=NetworkPairs(pairs),
        reason=f"{'; '.join(said)}{before}{why}",
    )
