"""Cameras that moved, put where they stand now: another network, in which all else stays as it was."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import EpibarError
from .checking import CameraCheck, NetworkCheck, NewPlace
from .parts import NetworkCamera, NetworkPair, NetworkPairs, NetworkParts
from .placed_pairs import placed_pair
from .shared_errors import IN_SPACE

__all__ = ["moved_parts", "update_notes"]


def moved_parts(network: NetworkParts, check: NetworkCheck) -> tuple[dict[str, NetworkCamera], NetworkPairs]:
    """Return the cameras and pairs of a network after a check; see :meth:`epibar.Network.updated`."""
    if not isinstance(check, NetworkCheck):
        raise EpibarError(f"check is a {type(check).__name__}, expected what Network.check returned")
    places = {name: one.place for name, one in check.cameras.items() if one.place is not None}
    for name in places:
        if name not in network.cameras or not network.cameras[name].accepted:
            raise EpibarError(f"{name}: the check is of another network, which has such a camera")
    if check.unit != network.unit:
        raise EpibarError(
            f"the check is in the unit {check.unit}, the network in {network.unit}; check again"
        )
    for name, position in check.positions.items():
        now = network.cameras[name].position if name in network.cameras else None
        if now is None or not np.allclose(now, position, rtol=1e-9, atol=1e-9):
            raise EpibarError(
                f"{name} does not stand where it did when the network was checked: it was updated or got "
                "other metres since; check again"
            )
    standing = [
        camera
        for name, camera in network.cameras.items()
        if camera.accepted and name not in (*check.moved, *check.suspects)
    ]
    cameras = dict(network.cameras)
    for name, place in places.items():
        cameras[name] = _moved(cameras[name], check.cameras[name], place, standing)
    pairs = [_pair(pair, cameras, places) for pair in network.pairs.values()]
    return cameras, NetworkPairs(pairs)


def _moved(
    camera: NetworkCamera, check: CameraCheck, place: NewPlace, standing: Sequence[NetworkCamera]
) -> NetworkCamera:
    """Return a camera where it stands now; its errors are those against the others, and what these have."""
    before = camera.expected or {}
    solved = {"focal": place.zoomed, "rotation": place.reposed, "position": place.reposed}
    expected = {
        key: math.hypot(place.expected[key], _typical(key, standing)) if new else before.get(key, math.inf)
        for key, new in solved.items()
    }
    covariance = camera.position_covariance
    if place.reposed:
        typical = (_typical("position", standing) / IN_SPACE) ** 2
        covariance = place.position_covariance
        if covariance is not None:
            covariance = covariance + typical * np.eye(3) if math.isfinite(typical) else None
    said = f"solved for again after it moved: {check.reason}"
    evidence = {} if check.deviate is None else {"tangents": check.deviate}
    return replace(
        camera,
        reason=said,
        matrix=place.matrix,
        rotation=place.rotation,
        translation=place.translation,
        expected=expected,
        position_covariance=covariance,
        evidence=evidence,
    )


def _typical(key: str, cameras: Sequence[NetworkCamera]) -> float:
    """Root mean square of what the cameras that did not move are expected to be wrong by."""
    known = [camera.expected[key] for camera in cameras if camera.expected is not None]
    return float(np.sqrt(np.mean(np.square(known)))) if known else math.inf


def _pair(pair: NetworkPair, cameras: dict[str, NetworkCamera], places: dict[str, NewPlace]) -> NetworkPair:
    """Return a pair with the geometry of its cameras as they stand now, and what confirms that."""
    if pair.F is None or not {pair.a, pair.b} & places.keys():
        return pair
    one, other = (pair.a, pair.b) if pair.a in places else (pair.b, pair.a)
    return placed_pair(cameras[pair.a], cameras[pair.b], places[one].pairs.get(other, {}))


def update_notes(check: NetworkCheck) -> list[str]:
    """Say what was put where it stands now, and what was not, and why."""
    done = [name for name, one in check.cameras.items() if one.place is not None]
    notes = [f"updated: {', '.join(done)}; all else stays as it was"] if done else ["nothing was updated"]
    notes += [
        f"{name} was not updated: its new place is not certain, see above"
        for name in check.moved
        if check.cameras[name].place is None
    ]
    if check.suspects:
        notes.append(f"{', '.join(check.suspects)}: none was updated, for which of them moved is not known")
    notes += [f"{name} was not updated: it cannot be judged" for name in check.unsure]
    return notes
