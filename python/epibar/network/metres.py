"""Metres: what one unit of a network measures, by every length that is known, weighted by how well it is.

A length L metres that is l units long says that a unit is L / l metres. The logarithms of what all say are
averaged with the inverses of their variances as weights; errors that several have in common are counted as
such.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from .. import _core
from ..arguments import is_number
from ..errors import EpibarError
from .parts import METRE, Ground, KnownLength, NetworkCamera, NetworkParts, Scale
from .shared_errors import FIGURES, error_of_mean, parts_of

__all__ = ["NOT_IN_METRES", "check_lengths", "rescaled"]

NOT_IN_METRES = "; not in metres: "
"""Before why a network that was to be in metres is not, at the end of its ``reason``."""

SHARPEST = 1e-9
"""The least standard error that is taken, as a share of the length."""

SHORTEST, LONGEST = 1e-4, 1e7
"""Metres that are taken for a length; what is shorter or longer is a slip of the hand or of a unit."""

TALLEST = 3.0
"""Metres that nobody who walks is taller than."""

MEASURED = 0.01
"""Standard error of a measured length: this share of it, or so many metres where that is more."""

STATURE = 0.03
"""Relative standard error of the height of those who walk: a median of few, with shoes and a bent back. How
well the network measures them is in it, and added to a stated one (:data:`FIGURES`)."""

NINE_IN_TEN = _core.NINE_IN_TEN
"""Nine in ten normal errors are below so many standard deviations."""

CONTRADICTION = 3.0
"""Standard deviations of the difference by which two lengths may disagree."""


def rescaled(
    network: NetworkParts, distance: Any, person_height: Any, camera_height: Any, keep: bool
) -> tuple[dict[str, NetworkCamera], Ground, Scale]:
    """Return cameras and ground in metres, and what these rest on; see :meth:`epibar.Network.scaled`."""
    lengths = [_distance(network, one) for one in _several(distance)]
    lengths += [_camera_height(network, one) for one in _several(camera_height)]
    if person_height is not None:
        lengths.append(_person_height(network, person_height))
    if not lengths:
        raise EpibarError("scaled: give a distance, a person_height or a camera_height")
    for one in lengths:
        if not math.isfinite(one.error):
            raise EpibarError(f"{one.what} says nothing: the network does not say how well it is known there")
    _refuse_twice([(one.of, one.what) for one in lengths])
    before = _given_before(network, lengths) if keep else []
    known = [*before, *lengths]
    for first, second in combinations(known, 2):
        of_difference = max(error_of_mean(network, [first, second], np.array([1.0, -1.0])), SHARPEST)
        off = abs(math.log(first.ratio / second.ratio)) / of_difference
        if off > CONTRADICTION:
            raise EpibarError(
                f"{first.what} and {second.what} contradict each other: they differ by "
                f"{100 * abs(first.ratio / second.ratio - 1):.1f} %, {off:.1f} standard deviations; check "
                "both"
                + (", or forget what was given before (--forget; keep=False)" if first in before else "")
            )
    weights = np.array([one.error**-2 for one in known])
    factor = math.exp(float(np.average([math.log(one.ratio) for one in known], weights=weights)))
    error = error_of_mean(network, known, weights / weights.sum())
    known = [replace(one, ratio=one.ratio / factor) for one in known]
    scale = Scale(NINE_IN_TEN * error, tuple(one.what for one in known), tuple(known))
    ground = network.ground
    if ground.height is not None:
        level_error = None if ground.level_error is None else factor * ground.level_error
        ground = replace(ground, height=factor * ground.height, level_error=level_error)
    cameras = {name: _scaled_camera(camera, factor) for name, camera in network.cameras.items()}
    return cameras, ground, scale


def _given_before(network: NetworkParts, lengths: list[KnownLength]) -> list[KnownLength]:
    """Lengths that the metres of a network rest on, but for those that are given anew."""
    if network.unit != METRE or network.scale is None:
        return []
    known = network.scale.lengths
    if not known:
        said = " and ".join(network.scale.sources) or "what was given before"
        known = (KnownLength(said, (), 1.0, max(network.scale.error / NINE_IN_TEN, SHARPEST)),)
    anew = [one.of for one in lengths]
    return [one for one in known if one.of not in anew]


def _scaled_camera(camera: NetworkCamera, factor: float) -> NetworkCamera:
    if camera.translation is None or camera.expected is None:
        return camera
    expected = {**camera.expected, "position": factor * camera.expected["position"]}
    covariance = None if camera.position_covariance is None else factor**2 * camera.position_covariance
    return replace(
        camera,
        translation=factor * camera.translation,
        expected=expected,
        position_covariance=covariance,
    )


def _several(given: Any) -> list[Any]:
    """Take one, or a list of such."""
    if given is None:
        return []
    if isinstance(given, (tuple, list)):
        return [given] if given and isinstance(given[0], str) else list(given)
    return [given]


def check_lengths(
    names: list[str], distance: Any = (), person_height: Any = None, camera_height: Any = ()
) -> None:
    """Refuse lengths that no network of these cameras could use, before there is one.

    Raises
    ------
    EpibarError
        A camera is unknown, or a number is not one.
    """
    of = []
    for what, count, given in (("distance", 2, distance), ("camera_height", 1, camera_height)):
        for one in _several(given):
            cameras, metres, _ = _parsed(one, count, what, names)
            of.append(((what, *sorted(cameras)), f"{what} {' '.join(cameras)} {metres:g}"))
    _refuse_twice(of)
    if person_height is not None:
        _stature(person_height)


def _refuse_twice(lengths: Sequence[tuple[tuple[str, ...], str]]) -> None:
    """Refuse two lengths of the same; of each what it is of, and in words."""
    for (first, said), (second, other) in combinations(lengths, 2):
        if first == second:
            raise EpibarError(f"{said} and {other} are of the same: give one of them")


def _parsed(given: Any, count: int, what: str, names: list[str]) -> tuple[list[str], float, float]:
    """Names, metres and their standard error."""
    form = "('cam1', 'cam2', metres)" if count == 2 else "('cam1', metres)"
    if not isinstance(given, (tuple, list)) or len(given) not in (count + 1, count + 2):
        raise EpibarError(f"{what} = {given!r}: expected {form}")
    cameras = [str(name) for name in given[:count]]
    for name in cameras:
        if name not in names:
            raise EpibarError(
                f"{what} = {given!r}: there is no camera {name!r}; there are {', '.join(names)}"
            )
    if len(set(cameras)) < count:
        raise EpibarError(f"{what} = {given!r}: the two cameras are one")
    value = given[count] if len(given) == count + 1 else tuple(given[count:])
    return cameras, *_metres(what, value, MEASURED, MEASURED)


def _metres(what: str, given: Any, share: float, least: float) -> tuple[float, float]:
    """Metres, and their standard error: given, or a share of them but at least so many metres."""
    pair = isinstance(given, (tuple, list)) and len(given) == 2
    metres, error = given if pair else (given, None)
    if not (is_number(metres) and metres > 0):
        raise EpibarError(f"{what} = {given!r}: expected a positive number of metres")
    if not SHORTEST <= metres <= LONGEST:
        raise EpibarError(f"{what} = {given!r}: expected {SHORTEST:g} to {LONGEST:g} metres")
    if error is None:
        error = max(share * float(metres), least)
        if error >= metres:
            raise EpibarError(
                f"{what} = {given!r}: as nothing is said of its standard error {error:g} m is taken, as much "
                "as the length itself; give its own"
            )
        return float(metres), error
    if not (is_number(error) and SHARPEST * metres <= error < metres):
        raise EpibarError(
            f"{what} = {given!r}: its standard error must be a positive number of metres, and less than the "
            "length itself but no less than a billionth of it"
        )
    return float(metres), float(error)


def _accepted(network: NetworkParts, name: str, what: str) -> NetworkCamera:
    camera = network.cameras[name]
    if not camera.accepted:
        raise EpibarError(f"{what}: {name} is not accepted, so nothing is measured from it: {camera.reason}")
    return camera


def _distance(network: NetworkParts, given: Any) -> KnownLength:
    (first, second), metres, error = _parsed(given, 2, "distance", list(network.cameras))
    what = f"the distance of {metres:g} m between {first} and {second}"
    one, other = (_accepted(network, name, what) for name in (first, second))
    assert one.position is not None
    assert other.position is not None
    units = float(np.linalg.norm(one.position - other.position))
    if units == 0:
        raise EpibarError(f"{what} says nothing: in this network both stand in one place")
    of = ("distance", *sorted((first, second)))
    return KnownLength(what, of, metres / units, _error(network, of, error / metres))


def _error(network: NetworkParts, of: tuple[str, ...], measured: float) -> float:
    """Relative standard error of a length of cameras; infinite where the network does not say."""
    parts = parts_of(network, of)
    return math.hypot(measured, *parts.values()) if parts else math.inf


def _camera_height(network: NetworkParts, given: Any) -> KnownLength:
    (name,), metres, error = _parsed(given, 1, "camera_height", list(network.cameras))
    what = f"the height of {metres:g} m of {name}"
    camera = _accepted(network, name, what)
    _check_floor(network, what)
    position = camera.position
    assert position is not None
    units = float(position[2])
    if units <= 0:
        raise EpibarError(f"{what}: {name} stands below the floor that was found")
    ground = network.ground
    if ground.vertical_error is None or ground.level_error is None:
        raise EpibarError(
            f"{what} says nothing: the network does not say how well its floor is known. Give the distance "
            "between two cameras instead"
        )
    of = ("camera_height", name)
    return KnownLength(what, of, metres / units, _error(network, of, error / metres))


def _person_height(network: NetworkParts, given: Any) -> KnownLength:
    metres, error = _stature(given)
    what = f"the height of {metres:g} m of people"
    _check_floor(network, what)
    others = network.ground.not_people
    if others is not None:
        raise EpibarError(
            f"{what} says nothing: {others}. Give the distance between two cameras, or the height of one, "
            "instead"
        )
    assert network.ground.height is not None
    if not any(camera.accepted for camera in network.cameras.values()):
        raise EpibarError(f"{what}: no camera is accepted: {network.reason}")
    stated = isinstance(given, (tuple, list))
    relative = math.hypot(error / metres, FIGURES) if stated else error / metres
    return KnownLength(what, ("person_height",), metres / network.ground.height, relative)


def _stature(given: Any) -> tuple[float, float]:
    """Metres and their standard error; nobody is as tall as what was meant for centimetres."""
    metres, error = _metres("person_height", given, STATURE, 0.0)
    if metres > TALLEST:
        raise EpibarError(
            f"person_height is {metres:g} m, and nobody is above {TALLEST:g}; it is in metres: 1.75, not 175"
        )
    return metres, error


def _check_floor(network: NetworkParts, what: str) -> None:
    if network.ground.source != "floor" or not network.ground.height:
        raise EpibarError(
            f"{what} says nothing: no floor was found on which people stand upright. Give the distance "
            "between two cameras instead"
        )
