"""A network as plain JSON, and back: every shape is looked at, no number is infinite, nothing is run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from ..arguments import Array, as_camera_matrix, as_numbers, as_rotation
from ..errors import EpibarError
from ..files.checks import LONGEST_SIDE, check_format, list_of, number_of, text_of, truth_of
from ..files.network_json import FORMAT, SCHEMA
from ..lens.intrinsics import Intrinsics
from .parts import (
    BASELINE,
    METRE,
    Ground,
    KnownLength,
    NetworkCamera,
    NetworkClock,
    NetworkPair,
    NetworkPairs,
    NetworkParts,
    Scale,
)

__all__ = ["as_dict", "as_file", "network_from"]

N = TypeVar("N", bound=NetworkParts)

CONVENTION = (
    "X_c = rotation X + translation, z up; pixels, pixel centres at integers; x_b^T F x_a = 0 in undistorted "
    "pixels; t seconds of the first camera are t + offset + 1e-6 drift t here"
)

LEAST_ERROR = 1e-10
"""No length is known better, as a share of it."""

SHOWN = 300
"""Characters of what is wrong that an error shows."""

LARGEST = 1e12
"""No number of a network is larger: not of lengths in its unit, lenses, clocks or errors."""

ORTHOGONAL = 1e-6
"""By how much R^T R may differ from the identity."""


def as_dict(network: NetworkParts) -> dict[str, Any]:
    """Return what is written of a network; a number that is not known is None."""
    return {
        "epibar_network": FORMAT,
        "convention": CONVENTION,
        "accepted": network.accepted,
        "reason": network.reason,
        "unit": network.unit,
        "radius": network.radius,
        "scale": None
        if network.scale is None
        else {
            "error": network.scale.error,
            "sources": list(network.scale.sources),
            "lengths": [
                {"what": one.what, "of": list(one.of), "ratio": one.ratio, "error": one.error}
                for one in network.scale.lengths
            ],
        },
        "ground": {
            "source": network.ground.source,
            "height": network.ground.height,
            "vertical_error": network.ground.vertical_error,
            "figures": network.ground.figures,
            "diversity": network.ground.diversity,
            "breadth": network.ground.breadth,
            "level_error": network.ground.level_error,
        },
        "cameras": [_camera_dict(camera, network.clocks[name]) for name, camera in network.cameras.items()],
        "pairs": [
            {
                "a": pair.a,
                "b": pair.b,
                "accepted": pair.accepted,
                "status": pair.status,
                "F": pair.F,
                "evidence": pair.evidence,
            }
            for pair in network.pairs.values()
        ],
    }


def as_file(network: NetworkParts) -> dict[str, Any]:
    """Return what stands in network.json: :func:`as_dict`, and where that is described."""
    return {"$schema": SCHEMA, **as_dict(network)}


def _camera_dict(camera: NetworkCamera, clock: NetworkClock) -> dict[str, Any]:
    return {
        "name": camera.name,
        "width": camera.size[0],
        "height": camera.size[1],
        "accepted": camera.accepted,
        "status": camera.status,
        "reason": camera.reason,
        "matrix": camera.matrix,
        "distortions": camera.distortions,
        "rotation": camera.rotation,
        "translation": camera.translation,
        "expected": camera.expected,
        "position_covariance": camera.position_covariance,
        "clock": {"offset": clock.offset, "drift": clock.drift, "offset_error": clock.offset_error},
        "evidence": camera.evidence,
        "undistorted": camera.undistorted,
        "lens": None
        if camera.lens is None
        else {
            "matrix": camera.lens.matrix,
            "distortions": camera.lens.distortions,
            "fisheye": camera.lens.fisheye,
        },
    }


def network_from(kind: type[N], content: Mapping[str, Any], where: str) -> N:
    """Make a network of what :func:`as_dict` returned.

    Parameters
    ----------
    kind : type
        Takes the parts.
    content : mapping
    where : str
        What to call it in errors.

    Raises
    ------
    EpibarError
        It is something else, damaged, or of another format.
    """
    if "epibar_network" not in content:
        raise EpibarError(f"{where}: not a network saved by epibar")
    check_format(where, content["epibar_network"], FORMAT)
    try:
        return _network(kind, content)
    except KeyError as error:
        raise EpibarError(f"{where}: damaged ({str(error)[:SHOWN]} is missing)") from error
    except (EpibarError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise EpibarError(f"{where}: damaged ({str(error)[:SHOWN]})") from error


def _network(kind: type[N], content: Mapping[str, Any]) -> N:
    cameras = [_camera(one) for one in list_of(content, "cameras")]
    names = [camera.name for camera in cameras]
    if len(names) < 2 or len(set(names)) < len(names):
        raise EpibarError(f"cameras are called {', '.join(names)}")
    clocks = {
        str(one["name"]): NetworkClock(
            *(_number(one["clock"], key) for key in ("offset", "drift", "offset_error"))
        )
        for one in content["cameras"]
    }
    pairs = [_pair(one, names) for one in list_of(content, "pairs")]
    if truth_of(content, "accepted") != all(camera.accepted for camera in cameras):
        raise EpibarError("whether the whole is accepted does not fit its cameras")
    unit = text_of(content, "unit")
    if unit not in (BASELINE, METRE):
        raise EpibarError(f"unit is {unit!r}")
    ground, scale = content["ground"], content["scale"]
    figures = _number(ground, "figures")
    return kind(
        cameras=dict(zip(names, cameras, strict=True)),
        pairs=NetworkPairs(pairs),
        clocks=clocks,
        accepted=truth_of(content, "accepted"),
        reason=text_of(content, "reason"),
        unit=unit,
        ground=Ground(
            text_of(ground, "source"),
            _size(ground, "height"),
            _size(ground, "vertical_error"),
            None if figures is None else int(figures),
            _number(ground, "diversity"),
            *(_size(ground, key) if key in ground else None for key in ("breadth", "level_error")),
        ),
        radius=_size(content, "radius"),
        scale=None if scale is None else _scale(scale),
    )


def _scale(scale: Mapping[str, Any]) -> Scale:
    error = _size(scale, "error")
    if error is None:
        raise EpibarError("scale has no error")
    lengths = list_of(scale, "lengths") if "lengths" in scale else []
    return Scale(error, tuple(map(str, list_of(scale, "sources"))), tuple(map(_known_length, lengths)))


def _known_length(one: Mapping[str, Any]) -> KnownLength:
    ratio, error = _size(one, "ratio"), _size(one, "error")
    if not ratio or not error or error < LEAST_ERROR:
        raise EpibarError("a length of the scale says nothing")
    return KnownLength(text_of(one, "what"), tuple(map(str, list_of(one, "of"))), ratio, error)


def _camera(one: Mapping[str, Any]) -> NetworkCamera:
    name = text_of(one, "name")
    parts = {key: one[key] for key in ("matrix", "distortions", "rotation", "translation", "expected")}
    missing = [key for key, value in parts.items() if value is None]
    accepted = truth_of(one, "accepted")
    lens = one.get("lens")
    if missing and (accepted or len(missing) < len(parts)):
        raise EpibarError(f"{name} has no {', '.join(missing)}")
    size = as_numbers(f"{name}: size", (one["width"], one["height"]), (2,))
    if (size < 1).any() or (size > LONGEST_SIDE).any() or (size != np.round(size)).any():
        raise EpibarError(f"{name}: size is {size.tolist()}")
    return NetworkCamera(
        name=name,
        size=(int(size[0]), int(size[1])),
        accepted=accepted,
        status=text_of(one, "status"),
        reason=text_of(one, "reason"),
        matrix=None if missing else as_camera_matrix(parts["matrix"], f"{name}: matrix"),
        distortions=None if missing else _vector(f"{name}: distortions", parts["distortions"], 5),
        rotation=None if missing else as_rotation(f"{name}: rotation", parts["rotation"], ORTHOGONAL),
        translation=None if missing else _vector(f"{name}: translation", parts["translation"], 3),
        expected=None if missing else _expected(parts["expected"]),
        position_covariance=None if missing else _covariance(name, one.get("position_covariance")),
        evidence=_evidence(one),
        undistorted="undistorted" in one and truth_of(one, "undistorted"),
        lens=None if lens is None else _lens(name, (int(size[0]), int(size[1])), lens),
    )


def _lens(name: str, size: tuple[int, int], lens: Mapping[str, Any]) -> Intrinsics:
    return Intrinsics(name, size, lens["matrix"], lens["distortions"], truth_of(lens, "fisheye"))


def _expected(value: Mapping[str, Any]) -> dict[str, float]:
    found = {key: _size(value, key) for key in ("focal", "rotation", "position")}
    return {key: math.inf if number is None else number for key, number in found.items()}


def _covariance(name: str, value: Any) -> Array | None:
    if value is None:
        return None
    covariance = as_numbers(f"{name}: position_covariance", value, (3, 3))
    largest = np.abs(covariance).max()
    alike = np.abs(covariance - covariance.T).max() <= ORTHOGONAL * largest
    if (
        not alike
        or largest > min(covariance.diagonal().max(), LARGEST**2)
        or (covariance.diagonal() < 0).any()
    ):
        raise EpibarError(f"{name}: position_covariance is {covariance.tolist()}, which is none")
    return covariance


def _pair(one: Mapping[str, Any], names: Sequence[str]) -> NetworkPair:
    a, b = text_of(one, "a"), text_of(one, "b")
    if a not in names or b not in names or a == b:
        raise EpibarError(f"there is a pair {a} - {b}, but no such cameras")
    F = None if one["F"] is None else as_numbers(f"{a} - {b}: F", one["F"], (3, 3))
    return NetworkPair(a, b, truth_of(one, "accepted"), text_of(one, "status"), F, _evidence(one))


def _evidence(one: Mapping[str, Any]) -> dict[str, float]:
    if not isinstance(one["evidence"], Mapping):
        raise EpibarError(f"evidence is {one['evidence']!r}, expected numbers by name")
    found = {str(key): number_of(one["evidence"], key) for key in one["evidence"]}
    return {key: value for key, value in found.items() if value is not None}


def _number(content: Mapping[str, Any], key: str) -> float | None:
    return number_of(content, key, -LARGEST, LARGEST)


def _size(content: Mapping[str, Any], key: str) -> float | None:
    """A length or an error."""
    return number_of(content, key, 0.0, LARGEST)


def _vector(what: str, value: Any, count: int) -> Array:
    vector = as_numbers(what, value, (count,))
    if np.abs(vector).max() > LARGEST:
        raise EpibarError(f"{what} is {vector.tolist()}, which no network has")
    return vector
