"""A whole made-up situation: cameras, clocks, what they film, and what is true of every pair.

Geometry is in undistorted pixels of each camera's true matrix; recordings are in the pixels that the lens
gives, unless they are asked for without it. What is at t seconds in the first camera, since its frame 0, is
at offset + t (1 + drift · 10⁻⁶) seconds in another, since its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array, Bits, Mask
from ..geometry import symmetric_epipolar_distance
from .camera import Camera, true_fundamental
from .film import Clock, Film
from .information import error_bound

if TYPE_CHECKING:
    from ..recording import Recording


LEAST_COMMON = 0.12
"""Share of the points where things moved that two cameras must both see to have an answer by definition."""

LEAST_BASELINE = 0.4
"""Metres between two cameras that have an answer by definition."""

DETERMINED = 1.0
"""Pixels over the volume that the best method may expect, by `error_bound`, where there is an answer."""


@dataclass(frozen=True)
class Answer:
    """Whether a pair has an answer, and why not."""

    exists: bool
    reason: str = ""


@dataclass(frozen=True)
class Fault:
    """Something that was planted: what, and in which cameras."""

    kind: str
    cameras: tuple[int, ...]
    detail: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Situation:
    """Cameras before something that moves, drawn from one seed; `situation` makes one.

    Attributes
    ----------
    family : str
    seed : int
    cameras : list of Camera
        The truth: matrix, lens, pose, size and name.
    clocks : list of Clock
    films : list of Film
        What each camera films.
    volume_points : (n, 3) array
        Random points in what moved, metres.
    room_points : (n, 3) array
        Random points over the whole room, up to 2 m high: where an F may be used, whether or not anything
        moved there.
    groups : tuple of int
        Cameras with the same number have answers among each other.
    area : (float, float)
        Metres along x and y on which things move, about the origin.
    undetermined : str
        Why the motion determines no geometry, or empty. There is a true F then, which nobody can know.
    faults : tuple of Fault
    """

    family: str
    seed: int
    cameras: list[Camera]
    clocks: list[Clock]
    films: list[Film]
    volume_points: Array
    room_points: Array
    groups: tuple[int, ...]
    area: tuple[float, float]
    undetermined: str = ""
    faults: tuple[Fault, ...] = field(default_factory=tuple)

    def __repr__(self) -> str:
        return f"<Situation {self.family} {self.seed}: {len(self.cameras)} cameras>"

    # --- what is true ---

    @property
    def names(self) -> list[str]:
        """Names of the cameras."""
        return [camera.name for camera in self.cameras]

    def pairs(self) -> list[tuple[int, int]]:
        """All pairs of cameras."""
        return list(combinations(range(len(self.cameras)), 2))

    def answer(self, a: int, b: int) -> Answer:
        """Tell whether a pair has an answer."""
        if self.undetermined:
            return Answer(False, self.undetermined)
        if self.groups[a] != self.groups[b]:
            blamed = [fault for fault in self.faults if a in fault.cameras or b in fault.cameras]
            return Answer(False, "; ".join(fault.kind for fault in blamed))
        if np.linalg.norm(self.cameras[a].centre - self.cameras[b].centre) < LEAST_BASELINE:
            return Answer(False, "no baseline")
        if (self.visible(a) & self.visible(b)).sum() < LEAST_COMMON * max(len(self.volume_points), 1):
            return Answer(False, "little in common")
        if error_bound(self, a, b) > DETERMINED:
            return Answer(False, "barely determined")
        return Answer(True)

    def has_fundamental(self, a: int, b: int) -> bool:
        """Whether an F holds between the pixels of two films, be it determined or not.

        It does where both show one thing at one time, and also where one of them is mirrored: that F has a
        rank of 2 and maps points to lines as any other, though poses from it are of another scene.
        """
        faults = {fault.kind for fault in self.faults if a in fault.cameras or b in fault.cameras}
        return self.groups[a] == self.groups[b] or faults == {"mirrored"}

    def fundamental(self, a: int, b: int) -> Array:
        """Return the true F of a pair in undistorted pixels of the true matrices, as its films show them.

        A mirrored film has the F of mirrored pixels; a knocked camera that of before it was knocked.
        """
        F = true_fundamental(self.cameras[a], self.cameras[b])
        F = self._mirror(b).T @ F @ self._mirror(a)
        return F / np.linalg.norm(F)

    def _mirror(self, index: int) -> Array:
        if not self.films[index].mirrored:
            return np.eye(3)
        return np.array([[-1.0, 0.0, self.cameras[index].size[0] - 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

    def clock_between(self, a: int, b: int) -> tuple[float, float]:
        """Return offset and drift: t seconds of a are offset + t (1 + drift · 10⁻⁶) seconds of b.

        Both since the camera's own frame 0; the drift is in parts per million.
        """
        one, other = self.clocks[a], self.clocks[b]
        return (one.start - other.start) * other.rate, (other.rate / one.rate - 1) * 1e6

    def time_offset(self, a: int, b: int) -> float:
        """Return where frame 0 of a falls in b, in frames of b, as `epibar.calibrate` takes it."""
        return self.clock_between(a, b)[0] * self.clocks[b].fps

    @property
    def synchronised(self) -> bool:
        """Whether all clocks are one."""
        first = self.clocks[0]
        return all((c.start, c.fps, c.drift) == (first.start, first.fps, first.drift) for c in self.clocks)

    # --- where to measure ---

    def seen(self, index: int, points: Array) -> Bits:
        """Tell which of some (n, 3) points this camera's image shows, lens and all."""
        camera = self.cameras[index]
        pixels, depth = camera.project(points)
        with np.errstate(invalid="ignore"):
            bent = camera.distort(pixels)
            inside = ((bent >= 0) & (bent <= np.array(camera.size) - 1)).all(axis=1)
        return inside & (depth > 0)

    def visible(self, index: int) -> Bits:
        """Tell which of the volume points this camera sees."""
        return self.seen(index, self.volume_points)

    def correspondences(
        self, a: int, b: int, points: Array | None = None, lens: bool = False
    ) -> tuple[Array, Array]:
        """Project points that both see: two (m, 2) arrays, undistorted pixels or (``lens``) as filmed.

        Parameters
        ----------
        points : (n, 3) array, optional
            By default the volume points.
        """
        points = self.volume_points if points is None else points
        points = points[self.seen(a, points) & self.seen(b, points)]
        found = []
        for index in (a, b):
            pixels = self.cameras[index].project(points)[0]
            pixels = self.cameras[index].distort(pixels) if lens else pixels
            if self.films[index].mirrored:
                pixels = np.column_stack([self.cameras[index].size[0] - 1 - pixels[:, 0], pixels[:, 1]])
            found.append(pixels)
        return found[0], found[1]

    def error(self, F: Array, a: int, b: int, points: Array | None = None) -> float:
        """Mean symmetric epipolar distance of an F over points that both see, pixels; NaN where none is.

        F and the error are in undistorted pixels; for films through a lens take the lens off first.
        """
        matches = self.correspondences(a, b, points)
        return float(symmetric_epipolar_distance(F, *matches).mean()) if len(matches[0]) else float("nan")

    # --- what is filmed ---

    def iter_masks(
        self, index: int, start: int = 0, stop: int | None = None, lens: bool = True
    ) -> Iterator[Mask]:
        """Draw the masks of one camera frame by frame, (H, W) uint8, 0 and 1; through its lens or without."""
        film = self.films[index] if lens else self.films[index].without_lens()
        return film.iter_masks(start, stop)

    def masks(self, index: int, start: int = 0, stop: int | None = None, lens: bool = True) -> Mask:
        """Draw the masks of one camera at once, (T, H, W)."""
        width, height = self.cameras[index].size
        found = list(self.iter_masks(index, start, stop, lens))
        return np.stack(found) if found else np.empty((0, height, width), np.uint8)

    def recording(
        self,
        index: int,
        lines: int = 20_000,
        seed: int | None = None,
        *,
        undistorted: bool = False,
        matrix: bool | None = None,
        frames: int | None = None,
    ) -> Recording:
        """Record one camera in bounded memory.

        Parameters
        ----------
        index : int
        lines : int
        seed : int, optional
            Of the lines; by default one of its own for every camera.
        undistorted : bool
            As a pinhole of the same matrix would film it, for calibrating pairs of known cameras.
        matrix : bool, optional
            Whether the recording knows its camera matrix; by default where it is undistorted on request.
        frames : int, optional
            Only the first so many.
        """
        from ..recording import MIN_COMPONENT_AREA, Recording, new_recorder

        camera = self.cameras[index]
        seed = (self.seed * 101 + index) % 2**32 if seed is None else seed
        recorder = new_recorder(*camera.size, lines, seed, MIN_COMPONENT_AREA)
        for frame, mask in enumerate(self.iter_masks(index, 0, frames, not undistorted)):
            recorder.push(np.ascontiguousarray(mask), frame / self.clocks[index].fps)
        known = undistorted if matrix is None else matrix
        return Recording(recorder.finish(), name=camera.name, matrix=camera.K if known else None)
