"""What is known of a camera before, each part by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import NoneType
from typing import Any, Literal

from numpy.typing import ArrayLike

from .. import _core
from ..arguments import LEAST_SKEW, as_camera_matrix, as_numbers, as_positive, is_number
from ..errors import EpibarError
from ..lens.intrinsics import Intrinsics
from ..recording import Recording

__all__ = ["KnownCamera", "has_focal", "knowledge_of", "known_by_name", "lenses_by_name"]

TANGENTIAL = _core.TANGENTIAL
"""Largest p1 and p2 that are taken for none: silhouettes go through a lens that has none."""


@dataclass(frozen=True, eq=False)
class KnownCamera:
    """What is known of a camera whose lens was not taken out of the recording. The default is nothing.

    Attributes
    ----------
    matrix : array_like, shape (3, 3), optional
        Camera matrix, pixels, without skew.
    distortions : array_like, shape (n,), optional
        OpenCV's k1 k2 p1 p2 [k3]; p1 and p2 near 0. With a matrix and without these the lens is taken to bend
        nothing.
    focal : float, optional
        Focal length along x alone, pixels.
    focal_error : float
        Its relative standard error. Below 0.05 it counts as known, as two cameras need it.
    principal_point : (float, float), optional
        Alone, pixels.
    aspect : float or "unknown", optional
        fy / fx, where pixels are not square; "unknown" where it is to be solved for. By default what the
        video said, :attr:`Recording.pixel_aspect`.
    """

    matrix: ArrayLike | None = None
    distortions: ArrayLike | None = None
    focal: float | None = None
    focal_error: float = 0.05
    principal_point: ArrayLike | None = None
    aspect: float | Literal["unknown"] | None = None

    def to_core(self, name: str) -> dict[str, Any]:
        """Return it as the compiled module takes it.

        Raises
        ------
        EpibarError
            A number is of the wrong kind or out of its range; ``name`` is the camera.
        """
        matrix = None
        if self.matrix is not None:
            matrix = as_camera_matrix(self.matrix, f"{name}: matrix")
            if abs(matrix[0, 1]) > LEAST_SKEW or abs(matrix[1, 0]) > LEAST_SKEW:
                raise EpibarError(f"{name}: matrix has skew, which the network does not know")
            matrix[0, 1] = matrix[1, 0] = 0.0
        distortions = None
        if self.distortions is not None:
            distortions = _distortions(name, self.distortions)
        focal = None
        if self.focal is not None:
            focal = (
                as_positive(f"{name}: focal", self.focal, "pixels"),
                as_positive(f"{name}: focal_error", self.focal_error, "parts"),
            )
        principal = None
        if self.principal_point is not None:
            principal = as_numbers(f"{name}: principal_point", self.principal_point, (2,)).tolist()
        return {
            "matrix": None if matrix is None else matrix.tolist(),
            "distortions": distortions,
            "focal": focal,
            "principal": principal,
            "aspect": _aspect(name, self.aspect),
        }


def _distortions(name: str, given: ArrayLike) -> list[float]:
    """k1 k2 p1 p2 k3."""
    found = as_numbers(f"{name}: distortions", given, None).ravel().tolist()
    if len(found) not in (0, 4, 5):
        raise EpibarError(f"{name}: {len(found)} distortions, expected k1 k2 p1 p2 [k3]")
    found = [*found, 0.0, 0.0, 0.0, 0.0, 0.0][:5]
    if max(map(abs, found[2:4])) >= TANGENTIAL:
        raise EpibarError(
            f"{name}: p1 and p2 are {found[2:4]}, but must be near 0; record the video with these "
            "intrinsics, which takes any lens out"
        )
    return found


def _aspect(name: str, aspect: Any) -> float | None:
    if aspect is None:
        return None
    if isinstance(aspect, str) and aspect == "unknown":
        return math.nan
    if is_number(aspect) and aspect > 0:
        return float(aspect)
    raise EpibarError(f"{name}: aspect = {aspect!r}: expected fy / fx, or 'unknown'")


def known_of(name: str, recording: Recording, known: KnownCamera | None) -> dict[str, Any]:
    """Return what is known of a recorded camera, as the compiled module takes it.

    Raises
    ------
    EpibarError
        The recording has had its lens taken out, and something else is said of it.
    """
    if recording.matrix is None:
        knowledge = known or KnownCamera()
        if knowledge.aspect is None and knowledge.matrix is None:
            knowledge = replace(knowledge, aspect=recording.pixel_aspect)
        return knowledge.to_core(name)
    if known is not None:
        raise EpibarError(
            f"{name}: this recording has had its lens taken out and knows its camera matrix; leave it out of "
            "known"
        )
    return KnownCamera(matrix=recording.matrix).to_core(name)


def known_by_name(known: Any) -> Mapping[str, KnownCamera]:
    """Return what is known of cameras, if it goes by names; nothing of None."""
    if not isinstance(known, (Mapping, NoneType)):
        raise EpibarError(f"known is a {type(known).__name__}, expected a mapping of names to KnownCamera")
    return known or {}


def knowledge_of(
    recordings: Mapping[str, Recording], known: Mapping[str, KnownCamera] | None
) -> list[dict[str, Any]]:
    """Return what is known of each camera, as the compiled module takes it."""
    known = known_by_name(known)
    for name, one in known.items():
        if name not in recordings:
            raise EpibarError(f"known has {name!r}, but the cameras are {', '.join(recordings)}")
        if not isinstance(one, KnownCamera):
            raise EpibarError(f"known[{name!r}] is a {type(one).__name__}, expected a KnownCamera")
    return [known_of(name, one, known.get(name)) for name, one in recordings.items()]


def has_focal(knowledge: dict[str, Any]) -> bool:
    """Whether the focal length is known well enough for a network of two cameras."""
    focal = knowledge["focal"]
    return knowledge["matrix"] is not None or (focal is not None and focal[1] < 0.05)


def lenses_by_name(lenses: Any, sizes: Mapping[str, tuple[int, int]]) -> dict[str, Intrinsics]:
    """Return lenses that were taken out of recordings, if they can be those of cameras of these sizes.

    Raises
    ------
    EpibarError
        No mapping of names to lenses, a name of no camera, a lens for images of another size.
    """
    if lenses is None:
        return {}
    if not isinstance(lenses, Mapping):
        raise EpibarError(f"lenses is a {type(lenses).__name__}, expected a mapping of names to Intrinsics")
    for name, lens in lenses.items():
        if name not in sizes:
            raise EpibarError(f"lenses has {name!r}, which is none of the cameras: {', '.join(sizes)}")
        if not isinstance(lens, Intrinsics):
            raise EpibarError(f"lenses[{name!r}] is a {type(lens).__name__}, expected Intrinsics")
        if tuple(lens.size) != tuple(sizes[name]):
            of_lens, of_camera = ("x".join(map(str, size)) for size in (lens.size, sizes[name]))
            raise EpibarError(f"lenses[{name!r}] is of {of_lens} images, and the camera films {of_camera}")
    return dict(lenses)
