"""What a network is made of: cameras, clocks, pairs, ground and scale."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from ..arguments import Array
from ..camera_export.world import METRE
from ..errors import EpibarError
from ..lens.intrinsics import Intrinsics, rotation_vector

__all__ = [
    "BASELINE",
    "METRE",
    "Ground",
    "KnownLength",
    "NetworkCamera",
    "NetworkClock",
    "NetworkPair",
    "NetworkPairs",
    "NetworkParts",
    "Scale",
    "evidence_of",
]

BASELINE = "baseline"
"""Unit of length where the scale is not known: the distance between the first two cameras that stand."""


def evidence_of(deviates: tuple[float, float]) -> dict[str, float]:
    """Name the compiled module's statistics; those that there are none of are left out."""
    named = zip(("tangents", "silhouettes"), deviates, strict=True)
    return {name: float(value) for name, value in named if math.isfinite(value)}


@dataclass(frozen=True, eq=False)
class NetworkCamera:
    """A camera of a network.

    Attributes
    ----------
    name : str
    size : (int, int)
        Width and height of its images, pixels.
    accepted : bool
        Whether it can be relied on.
    status : str
        The verdict as one machine-readable word.
    reason : str
        The verdict in plain English.
    matrix : ndarray, shape (3, 3), or None
        Camera matrix, pixels, pixel centres at integers. None, as all that follows, where it has no place in
        the network; there may be one though the camera is not accepted.
    distortions : ndarray, shape (5,), or None
        OpenCV's k1 k2 p1 p2 k3; 0 where the lens was taken out of the recording.
    rotation : ndarray, shape (3, 3), or None
        World to camera, ``X_c = R X + t``; world z is up.
    translation : ndarray, shape (3,), or None
        In the network's unit.
    expected : dict of str to float, or None
        Errors to expect, which the true ones are below nine times in ten: ``focal`` relative, ``rotation`` in
        degrees, ``position`` in the network's unit, after the similarity that lays the network best over the
        truth. Infinite where the data does not tell.
    position_covariance : ndarray, shape (3, 3), or None
        What ``expected["position"]`` is by direction: covariance of the position along the axes of the
        world, square of the network's unit. None where the data does not tell, and for networks that an
        earlier version saved.
    evidence : dict of str to float
        What speaks for it on moments kept aside, as normal deviates: of ``tangents``, and of whole
        ``silhouettes``.
    undistorted : bool
        Whether all this is in pixels that are not those of the video: the lens was taken out of the
        recording, or only its camera matrix is known, as where masks were given with one.
    lens : Intrinsics or None
        That lens; None where it is not known, or none was taken out.
    """

    name: str
    size: tuple[int, int]
    accepted: bool
    status: str
    reason: str
    matrix: Array | None = None
    distortions: Array | None = None
    rotation: Array | None = None
    translation: Array | None = None
    expected: dict[str, float] | None = None
    position_covariance: Array | None = None
    evidence: dict[str, float] = field(default_factory=dict)
    undistorted: bool = False
    lens: Intrinsics | None = None

    @property
    def why_left_out(self) -> str:
        """:attr:`reason` without the words that it was left out, for where these are said before it."""
        return self.reason.removeprefix("left out: ")

    @property
    def position(self) -> Array | None:
        """Where it stands, (3,), in the network's unit."""
        if self.rotation is None or self.translation is None:
            return None
        return -self.rotation.T @ self.translation

    @property
    def lens_reach(self) -> float | None:
        """How far out its lens shows anything, pixels from the principal point; None where that is all.

        The polynomial that fits where things moved may turn back before the corners. No direction is seen
        beyond, and what undoes a lens makes nonsense of it. None as well where it has no place.
        """
        if self.matrix is None:
            return None
        return _core.lens_reach(np.ascontiguousarray(self.matrix), self._lens(), self.size)

    def directions(self, pixels: ArrayLike) -> Array:
        """Return where pixels look, through the lens that was found.

        Parameters
        ----------
        pixels : (n, 2) array
            As the camera filmed them; undistorted ones where its lens was taken out of the recording.

        Returns
        -------
        ndarray, shape (n, 2)
            x and y of rays ``(x, y, 1)`` in the camera's frame; NaN beyond :attr:`lens_reach`. The tangential
            part of a lens, which is 0 of all that a network finds, is not used.

        Raises
        ------
        EpibarError
            It has no place in the network, or the pixels are not (n, 2).
        """
        if self.matrix is None:
            raise EpibarError(f"{self.name} has no place in the network: {self.reason}")
        points = np.asarray(pixels, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 2:
            raise EpibarError(f"pixels are (n, 2), not of shape {points.shape}")
        return _core.lens_directions(np.ascontiguousarray(self.matrix), self._lens(), points.tolist())

    def _lens(self) -> tuple[float, float, float, float, float]:
        k1, k2, p1, p2, k3 = (0.0,) * 5 if self.distortions is None else self.distortions.tolist()
        return k1, k2, p1, p2, k3

    def intrinsics(self, lens: Intrinsics | None = None) -> Intrinsics:
        """Return it as camera files describe it, through the lens that was taken out of the recording.

        That is ``lens``, or else the one that the recording knew; where neither is known it is in undistorted
        pixels.

        Raises
        ------
        EpibarError
            It has no place in the network.
        """
        if self.matrix is None or self.rotation is None or self.translation is None:
            raise EpibarError(f"{self.name} has no place in the network: {self.reason}")
        rotation = rotation_vector(self.rotation)
        distortions = np.zeros(5) if self.distortions is None else self.distortions
        found = Intrinsics(self.name, self.size, self.matrix, distortions, False, rotation, self.translation)
        lens = lens or self.lens
        if lens is None or not lens.distorted:
            return found
        return replace(found, distortions=lens.distortions, fisheye=lens.fisheye)


@dataclass(frozen=True)
class NetworkClock:
    """The clock of a camera against that of the first: t there is ``t + offset + 1e-6 drift t`` here.

    Attributes
    ----------
    offset : float or None
        Seconds, both counted from the camera's own first frame. None where the camera has no place.
    drift : float or None
        Parts per million.
    offset_error : float or None
        Standard error of the offset, seconds.
    """

    offset: float | None = None
    drift: float | None = None
    offset_error: float | None = None

    def at(self, time: float) -> float:
        """Seconds of this clock when that of the first camera shows ``time``.

        Raises
        ------
        EpibarError
            The camera has no place, so that its clock is not known.
        """
        offset, rate = self._line()
        return offset + time * rate

    def time_of(self, seconds: float) -> float:
        """Seconds of the first camera's clock when this one shows ``seconds``; raises as :meth:`at`."""
        offset, rate = self._line()
        return (seconds - offset) / rate

    def _line(self) -> tuple[float, float]:
        if self.offset is None:
            raise EpibarError("a clock whose offset is not known shows no time")
        return self.offset, 1 + 1e-6 * (self.drift or 0.0)


@dataclass(frozen=True, eq=False)
class NetworkPair:
    """A pair of cameras of a network.

    Attributes
    ----------
    a, b : str
        The cameras.
    accepted : bool
        Whether both are accepted, they stand apart, and nothing contradicts.
    status : str
        ``confirmed`` by what moves in both; ``predicted`` where too little does; ``contradicts`` where the
        pair by itself was accepted with another geometry; ``no_baseline`` where both stand at one place, as
        far as is known, so that any epipole fits; ``outside`` where a camera has no place.
    F : ndarray, shape (3, 3), or None
        ``x_b^T F x_a = 0`` in undistorted pixels of the two camera matrices, Frobenius norm 1.
    evidence : dict of str to float
        As that of a camera.
    """

    a: str
    b: str
    accepted: bool
    status: str
    F: Array | None = None
    evidence: dict[str, float] = field(default_factory=dict)

    def swapped(self) -> NetworkPair:
        """Return the same pair seen from B: F transposed."""
        return replace(self, a=self.b, b=self.a, F=None if self.F is None else self.F.T)


class NetworkPairs(Mapping[tuple[str, str], NetworkPair]):
    """Pairs by the names of their cameras, in either order; iteration is in the order of the cameras."""

    def __init__(self, pairs: Sequence[NetworkPair]) -> None:
        self._pairs = {(pair.a, pair.b): pair for pair in pairs}

    def __getitem__(self, key: tuple[str, str]) -> NetworkPair:
        if key in self._pairs:
            return self._pairs[key]
        if isinstance(key, tuple) and key[::-1] in self._pairs:
            return self._pairs[key[::-1]].swapped()
        raise KeyError(key)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self._pairs)

    def __len__(self) -> int:
        return len(self._pairs)

    def __repr__(self) -> str:
        return f"<NetworkPairs {', '.join(map(' - '.join, self._pairs))}>"


BROADEST, MOST_DIVERSE = 0.57, 0.2
"""People who walk are 0.33 to 0.42 times as broad as tall, the median of all their steps, those who dance
0.41 to 0.52, and their heights scatter by 2 to 13 % (43 made-up networks of development); animals are 0.62 to
0.78 times as broad and scatter by up to 80 %, cars are 1.2 times as broad. Cyclists (0.51 to 0.67) are
between, and as tall as people."""


@dataclass(frozen=True)
class Ground:
    """Where a network's vertical comes from, and its floor.

    Attributes
    ----------
    source : str
        ``"floor"``: z is the normal of the floor that figures stand on, and z = 0 is that floor.
        ``"cameras"``: z is the mean of the cameras' own up, and z = 0 the mean of their heights.
    height : float or None
        Median height of the figures, in the network's unit.
    vertical_error : float or None
        Standard error of the vertical, degrees.
    figures : int or None
        How many it rests on.
    diversity : float or None
        Robust standard deviation of their heights over the median.
    breadth : float or None
        Median of their breadth over their height: 0.3 to 0.55 of people on their feet.
    level_error : float or None
        Standard error of the floor's level where they stand, in the network's unit.
    """

    source: str
    height: float | None = None
    vertical_error: float | None = None
    figures: int | None = None
    diversity: float | None = None
    breadth: float | None = None
    level_error: float | None = None

    @property
    def not_people(self) -> str | None:
        """Why what stands on the floor is not people on their feet, in words; None where it may be."""
        if self.breadth is not None and not self.breadth <= BROADEST:
            return (
                f"what moves on the floor is {self.breadth:.2f} times as broad as it is tall, which people "
                "on their feet are not: animals, vehicles or the like"
            )
        if self.diversity is not None and not self.diversity <= MOST_DIVERSE:
            share = f"{100 * self.diversity:.0f} %"
            return f"what moves on the floor differs in height by {share}, more than people do"
        return None


@dataclass(frozen=True)
class KnownLength:
    """A length that was given, and what it says of the metres of a network.

    Attributes
    ----------
    what : str
        In words.
    of : tuple of str
        "distance" and two cameras, "camera_height" and one, or "person_height".
    ratio : float
        What a metre of the network measures by this length alone, metres.
    error : float
        Relative standard error of that.
    """

    what: str
    of: tuple[str, ...]
    ratio: float
    error: float


@dataclass(frozen=True)
class Scale:
    """What metres rest on.

    Attributes
    ----------
    error : float
        Relative error of all lengths, which the true one is below nine times in ten.
    sources : tuple of str
        What was measured, in words.
    lengths : tuple of KnownLength
        The same in numbers; none in networks of before there were any.
    """

    error: float
    sources: tuple[str, ...]
    lengths: tuple[KnownLength, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class NetworkParts:
    """All that a network holds; :class:`~epibar.Network` says what each is, and adds what is done with it."""

    cameras: dict[str, NetworkCamera]
    pairs: NetworkPairs
    clocks: dict[str, NetworkClock]
    accepted: bool
    reason: str
    unit: str
    ground: Ground
    radius: float | None = None
    scale: Scale | None = None

    @property
    def known_lenses(self) -> list[str]:
        """Names of the cameras of which it is stored what lens was taken out."""
        return [name for name, camera in self.cameras.items() if camera.lens is not None]

    def refuse_unknown(self, names: Iterable[str]) -> None:
        """Check that there is a camera of every name.

        Raises
        ------
        EpibarError
            There is none of one.
        """
        for name in names:
            if name not in self.cameras:
                raise EpibarError(
                    f"{name}: the network has no camera of that name; it has {', '.join(self.cameras)}"
                )
