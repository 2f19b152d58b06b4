"""Parts of a network as the compiled module tells them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arguments import Array
from ..lens.intrinsics import Intrinsics
from ..recording import Recording
from .parts import Ground, NetworkCamera, NetworkClock, NetworkPair, evidence_of

__all__ = ["camera_of", "clock_of", "covariance_of", "finite", "ground_of", "pair_of"]


def camera_of(
    one: Mapping[str, Any], size: tuple[int, int], recording: Recording | None = None
) -> NetworkCamera:
    """Make a camera whose images are of a size; ``recording`` knows of which pixels it is."""
    lens = None if recording is None else recording.lens
    straight = recording is not None and recording.matrix is not None
    if lens is not None:
        lens = Intrinsics(one["name"], lens.size, lens.matrix, lens.distortions, lens.fisheye)
    return NetworkCamera(
        name=one["name"],
        size=size,
        accepted=bool(one["accepted"]),
        status=one["status"],
        reason=one["reason"],
        matrix=one["matrix"],
        distortions=one["distortions"],
        rotation=one["rotation"],
        translation=one["translation"],
        expected=None if one["expected"] is None else dict(one["expected"]),
        position_covariance=covariance_of(one["position_covariance"]),
        evidence=evidence_of(one["deviates"]),
        undistorted=straight and (lens is None or lens.distorted),
        lens=lens,
    )


def covariance_of(value: Array | None) -> Array | None:
    """Return a covariance; None where it is not known."""
    return value if value is not None and np.isfinite(value).all() else None


def clock_of(one: Mapping[str, Any]) -> NetworkClock:
    """Make the clock of a camera; of one without a place nothing is known."""
    if one["clock"] is None:
        return NetworkClock()
    offset, drift = one["clock"]
    return NetworkClock(float(offset), float(drift), finite(one["offset_error"]))


def pair_of(one: Mapping[str, Any], names: Sequence[str]) -> NetworkPair:
    """Make a pair of cameras of some names."""
    return NetworkPair(
        names[one["a"]],
        names[one["b"]],
        bool(one["accepted"]),
        one["status"],
        one["F"],
        evidence_of(one["deviates"]),
    )


def ground_of(one: Mapping[str, Any]) -> Ground:
    """Make the ground; an error that is not known is None."""
    errors = {key: finite(one[key]) for key in ("vertical_error", "level_error") if key in one}
    return Ground(**{**one, **errors})


def finite(value: float) -> float | None:
    """Return a number; None where it is none."""
    return float(value) if math.isfinite(value) else None
