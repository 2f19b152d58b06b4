"""Has a camera moved? New recordings of the cameras of a network, held against what is stored of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from .. import _core
from ..arguments import Array, as_positive, core_errors
from ..errors import EpibarError
from ..recording import Recording
from .core_parts import covariance_of
from .offsets import ClockOffsets, TimeOffset, find_offsets, given_offsets
from .parts import NetworkCamera, NetworkParts, evidence_of
from .recordings import Recordings, named_recordings
from .stages import Progress, as_stage

__all__ = [
    "MOVED",
    "SUSPECT",
    "UNMOVED",
    "UNSURE",
    "CameraCheck",
    "NetworkCheck",
    "NewPlace",
    "cameras_to_check",
    "check_network",
    "stored_camera",
]

UNMOVED, MOVED, SUSPECT, UNSURE = "unmoved", "moved", "suspect", "unsure"

EXPECTED = ("focal", "rotation", "position")
"""What errors are stated of."""

SAME_MATRIX = 1e-9
"""By how much two camera matrices may differ and be one, of each element."""


@dataclass(frozen=True, eq=False)
class NewPlace:
    """Where a camera that moved stands now, by the new footage, the cameras that did not move being held.

    Attributes
    ----------
    matrix : ndarray, shape (3, 3)
        Camera matrix, pixels; distortions stay as stored.
    rotation : ndarray, shape (3, 3)
        World to camera, ``X_c = R X + t``.
    translation : ndarray, shape (3,)
        In the network's unit.
    zoomed, reposed : bool
        Whether the focal length, or rotation and position, were solved for; the others are as stored.
    expected : dict of str to float
        ``focal``, ``rotation`` and ``position`` as those of a :class:`NetworkCamera`, of what was solved for:
        errors against the cameras that did not move; 0 of what was not.
    position_covariance : ndarray, shape (3, 3), or None
        Of the same position, square of the network's unit; 0 where it was not solved for.
    pairs : dict of str to dict of str to float
        What speaks for the pairs with the other cameras, by their names, as the evidence of a
        :class:`NetworkPair`.
    """

    matrix: Array
    rotation: Array
    translation: Array
    zoomed: bool
    reposed: bool
    expected: dict[str, float]
    position_covariance: Array | None
    pairs: dict[str, dict[str, float]]


@dataclass(frozen=True)
class CameraCheck:
    """How a camera of a network stands in new footage, beside what is stored of it.

    Attributes
    ----------
    name : str
    status : str
        "unmoved", "moved", "suspect" or "unsure"; of suspects one moved, and it is not known which.
    reason : str
        The same in plain English.
    turned, turned_error : float or None
        By how many degrees it is turned, and the error of that, which the true one is below nine times in
        ten. None, as all that follows, where nothing tells.
    shifted, shifted_error : float or None
        By how much it stands elsewhere, in the network's unit, and the error of that.
    focal, focal_error : float or None
        Relative change of the focal length, and the error of that. A camera whose ``reason`` does not speak
        of it has the one that is stored, within errors.
    deviate : float or None
        What speaks for what it has in common with the others, as a normal deviate.
    since : float or None
        Seconds of the new recording, since its first frame, from which on it is so; None where it is so of
        all of it.
    place : NewPlace or None
        Where it stands now. None where it did not move, and where its new place is not certain: two cameras
        that did not move must confirm it, and no pair of it may agree better with another one; ``reason``
        tells.
    rivals : list of str
        Of a suspect the others: it moved, or one of them. What is said of its move is true if it did.
    """

    name: str
    status: str
    reason: str
    turned: float | None = None
    turned_error: float | None = None
    shifted: float | None = None
    shifted_error: float | None = None
    focal: float | None = None
    focal_error: float | None = None
    deviate: float | None = None
    since: float | None = None
    place: NewPlace | None = None
    rivals: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class NetworkCheck:
    """Which cameras of a network have moved.

    Attributes
    ----------
    cameras : dict of str to CameraCheck
        Those that were looked at, in the order of the recordings.
    left_out : dict of str to str
        The other cameras of the network, and why they were not looked at.
    unit : str
        Of ``shifted``: that of the network.
    positions : dict of str to ndarray, shape (3,), float64
        Where the network had the cameras that were looked at: new places are beside these.
    """

    cameras: dict[str, CameraCheck]
    left_out: dict[str, str] = field(default_factory=dict)
    unit: str = ""
    positions: dict[str, Array] = field(default_factory=dict)

    @property
    def moved(self) -> list[str]:
        """Names of the cameras that are known to have moved."""
        return [name for name, camera in self.cameras.items() if camera.status == MOVED]

    @property
    def suspects(self) -> list[str]:
        """Names of the cameras one of which has moved, or several; which is not known."""
        return [name for name, camera in self.cameras.items() if camera.status == SUSPECT]

    @property
    def unsure(self) -> list[str]:
        """Names of the cameras that cannot be judged."""
        known = (MOVED, SUSPECT, UNMOVED)
        return [name for name, camera in self.cameras.items() if camera.status not in known]

    @property
    def ok(self) -> bool:
        """Whether every camera that was looked at is known not to have moved."""
        return not (self.moved or self.suspects or self.unsure)

    @property
    def reason(self) -> str:
        """What was found, in one sentence."""
        count = len(self.cameras)
        have = "has" if len(self.moved) == 1 else "have"
        known = [f"{', '.join(self.moved)} {have} moved"] if self.moved else []
        rivals = [name for one in self.suspects for name in self.cameras[one].rivals]
        suspected = [name for name in self.cameras if name in self.suspects or name in rivals]
        # Where none is left that stands, several may have moved.
        either = "one or more" if len(self.suspects) == count > 2 else "one"
        known += [f"{either} of {', '.join(suspected)} has moved"] if suspected else []
        unsure = [f"{', '.join(self.unsure)} cannot be judged"] if self.unsure else []
        if known:
            found = f"of {count} cameras {', and '.join(known + unsure)}"
        elif unsure:
            found = f"of {count} cameras none is known to have moved, but {unsure[0]}"
        else:
            found = f"none of {count} cameras has moved"
        return found + (f"; not looked at: {', '.join(self.left_out)}" if self.left_out else "")

    def as_dict(self) -> dict[str, Any]:
        """Return it as ``epibar check --json`` prints it."""
        return {
            "ok": self.ok,
            "moved": self.moved,
            "suspects": self.suspects,
            "unsure": self.unsure,
            "reason": self.reason,
            "unit": self.unit,
            "cameras": {name: asdict(camera) for name, camera in self.cameras.items()},
            "left_out": self.left_out,
        }


def check_network(
    network: NetworkParts,
    recordings: Recordings,
    time_offset: TimeOffset,
    search_seconds: float,
    progress: Progress | None,
) -> NetworkCheck:
    """Tell which cameras have moved; see :meth:`epibar.Network.check`."""
    films = named_recordings(recordings)
    reach = as_positive("search_seconds", search_seconds, "seconds")
    offsets = given_offsets(list(films), time_offset)
    filmed, left_out = cameras_to_check(network, films)
    stored, unfit = _stored_cameras(network, films, filmed)
    names, cameras = list(stored), list(stored.values())
    checked = [films[name] for name in names]
    if offsets is None:
        offsets = find_offsets(checked, reach, as_stage("clocks", progress))
    else:
        offsets = _clocks_of(names, list(films), offsets)
    with core_errors():
        found = _core.check_network(
            [one._core for one in checked], names, cameras, offsets.to_core(), as_stage("check", progress)
        )
    checked_cameras = {name: _answer(one, films[name]) for name, one in zip(names, found, strict=True)}
    answers = {name: checked_cameras.get(name) or unfit[name] for name in filmed}
    positions = {name: position for name in names if (position := network.cameras[name].position) is not None}
    return NetworkCheck(answers, left_out, network.unit, positions)


def _answer(one: Mapping[str, Any], film: Recording) -> CameraCheck:
    """What the compiled module says of a camera."""
    place = None if one["place"] is None else _place(one["place"])
    reason = one["reason"]
    if place is not None and place.zoomed and film.matrix is not None:
        place = None
        reason += "; its lens was taken out as it was before: calibrate the lens again, and then the network"
    return CameraCheck(**{**one, "place": place, "reason": reason})


def _place(one: Mapping[str, Any]) -> NewPlace:
    pairs = {name: evidence_of(deviates) for name, deviates in one["pairs"].items()}
    covariance = covariance_of(one["position_covariance"])
    converted = {"expected": dict(one["expected"]), "position_covariance": covariance, "pairs": pairs}
    return NewPlace(**{**one, **converted})


def cameras_to_check(network: NetworkParts, names: Iterable[str]) -> tuple[list[str], dict[str, str]]:
    """Return which of the cameras that were filmed anew can be checked, and why all others cannot.

    Raises
    ------
    EpibarError
        A name is none of the network's, or fewer than two can be checked.
    """
    filmed = list(names)
    network.refuse_unknown(filmed)
    left_out = {}
    for name, camera in network.cameras.items():
        if not camera.accepted:
            left_out[name] = f"not accepted in the network: {camera.why_left_out}"
        elif name not in filmed:
            left_out[name] = "there is no new recording of it"
    chosen = [name for name in filmed if name not in left_out]
    if len(chosen) < 2:
        why = "; ".join(f"{name}: {text}" for name, text in left_out.items())
        raise EpibarError(
            "cameras are checked against each other: at least two are needed, but "
            f"{len(chosen)} can be looked at ({why})"
        )
    return chosen, left_out


def _stored_cameras(
    network: NetworkParts, films: Mapping[str, Recording], names: Iterable[str]
) -> tuple[dict[str, dict[str, Any]], dict[str, CameraCheck]]:
    """Return the cameras whose films are as they were stored, and what is said of the others.

    Raises
    ------
    EpibarError
        Fewer than two are.
    """
    stored, unfit = {}, {}
    for name in names:
        try:
            stored[name] = stored_camera(network.cameras[name], films[name])
        except EpibarError as error:
            unfit[name] = CameraCheck(name, UNSURE, str(error).removeprefix(f"{name}: "))
    if len(stored) < 2:
        raise EpibarError("; ".join(f"{name}: {one.reason}" for name, one in unfit.items()))
    return stored, unfit


def stored_camera(camera: NetworkCamera, recording: Recording) -> dict[str, Any]:
    """Return a stored camera as the compiled module takes it, for a recording that is raw or without lens.

    Raises
    ------
    EpibarError
        The recording is of another size or camera matrix, or has a lens that was known and taken out before.
    """
    name = camera.name
    if recording.size != camera.size:
        new, stored = ("x".join(map(str, size)) for size in (recording.size, camera.size))
        raise EpibarError(
            f"{name}: {new} frames, but the network was calibrated at {stored}; film as then, or calibrate "
            "anew"
        )
    if camera.lens is not None and camera.undistorted and recording.matrix is None:
        raise EpibarError(
            f"{name}: the network has it in undistorted pixels, and this recording still has its lens; "
            f"record the video with intrinsics=network.cameras[{name!r}].lens"
        )
    assert camera.matrix is not None
    assert camera.distortions is not None
    assert camera.rotation is not None
    assert camera.translation is not None
    distortions = camera.distortions
    if recording.matrix is not None:
        if not np.allclose(recording.matrix, camera.matrix, rtol=SAME_MATRIX, atol=SAME_MATRIX):
            raise EpibarError(
                f"{name}: this recording has had its lens taken out with another camera matrix than the "
                "network has; record the video again without intrinsics, or with those of the network"
            )
        distortions = np.zeros(5)
    return {
        "camera": {
            "matrix": camera.matrix.tolist(),
            "distortions": distortions.tolist(),
            "rotation": camera.rotation.tolist(),
            "translation": camera.translation.tolist(),
        },
        "expected": {key: (camera.expected or {}).get(key, math.inf) for key in EXPECTED},
    }


def _clocks_of(names: list[str], given: list[str], offsets: ClockOffsets) -> ClockOffsets:
    """Keep the clocks of some cameras, against the first of these."""
    seconds: Mapping[str, float] = dict(zip(given, offsets.seconds, strict=True))
    return ClockOffsets(tuple(seconds[name] - seconds[names[0]] for name in names), given=offsets.given)
