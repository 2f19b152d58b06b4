"""Two recordings in, one fundamental matrix with its verdict out."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from .arguments import (
    MAX_SEED,
    AnyArray,
    Array,
    Bits,
    as_camera_matrix,
    as_positive,
    as_whole_number,
    check_choice,
    core_errors,
    is_number,
)
from .clocks import Timing, frame_interval, position_in_b
from .errors import EpibarError
from .files.archive import read_archive, write_archive
from .files.calibration_npz import KIND, from_arrays, to_arrays
from .geometry.correspondences import Candidates, FrontierPoints
from .health.inspection import cause_of_refusal
from .recording import Recording, as_recording

__all__ = ["METHODS", "Calibration", "Candidates", "FrontierPoints", "Timing", "calibrate"]

METHODS = ("frontier", "lines")

MAX_EXPECTED_ERROR = _core.MAX_EXPECTED_ERROR
"""Pixels: a pair that states more is refused by default."""

MAP_SHAPE = _core.MAP_SHAPE
"""Rows and columns of an error map."""

SEARCH_SECONDS = _core.SEARCH_SECONDS
"""How far either way an offset is looked for, of a pair or of the clocks of a network, unless it is said."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """What is known about a pair of cameras, and how far to trust it.

    Attributes
    ----------
    F : ndarray, shape (3, 3), or None
        Fundamental matrix, ``x_b^T F x_a = 0``, Frobenius norm 1. May be present though it is not accepted:
        look at ``accepted`` before using it.
    accepted : bool
        Whether F passed every test.
    kind : str
        The verdict as one machine-readable word.
    reason : str
        The verdict as one sentence in plain English.
    expected_error : float or None
        Mean symmetric epipolar distance to expect over the volume where things moved, pixels.
    time_offset : float
        Where A's first frame falls in B, in frames of B after B's first; not a whole number as a rule. At
        equal frame rates frame i of A is frame ``i + time_offset`` of B; for others see :meth:`frame_of_b`.
    candidates : Candidates
    frontier_points : FrontierPoints
    counts : dict of str to int
        What was counted on the way: lines, candidates, tangents, matches.
    floor : ndarray, shape (3, 3), or None
        Homography of the floor, ``x_b ~ floor x_a``, where one was found.
    rivals : list of dict
        Other geometries with about the same evidence.
    evidence : dict of str to float
        The statistics behind the verdict. ``essential_deviation``, the difference of the singular values of
        ``K_b^T F K_a`` over their sum, is there where both camera matrices were used.
    source : str
        What kind of hypothesis F grew from.
    shift_curve : tuple of two ndarray
        Shifts of B's frames, and the score of F at each.
    method : str
    seed : int
    timing : Timing
        Frame rates, drift of the clocks, and how well the offset is known.
    error_maps : tuple of two ndarray, or None
        Where in each image F is known how well: for (24, 32) cells spread evenly over A, the distance in
        pixels to expect between the epipolar line of a point there and the true one, averaged over the part
        of the line inside B; and the same the other way for B. NaN where the line misses the other image.
        Made of the same parts as ``expected_error``, which is about the volume where things moved, and of
        what outlines that are all off alike do to F beyond it. None where there is none.
    """

    F: Array | None
    accepted: bool
    kind: str
    reason: str
    expected_error: float | None
    time_offset: float
    candidates: Candidates
    frontier_points: FrontierPoints
    counts: dict[str, int]
    floor: Array | None = None
    rivals: list[dict[str, Any]] = field(default_factory=list)
    evidence: dict[str, float] = field(default_factory=dict)
    source: str = "none"
    shift_curve: tuple[Array, Array] = field(default_factory=lambda: (np.empty(0), np.empty(0)))
    method: str = METHODS[0]
    seed: int = 0
    timing: Timing = field(default_factory=Timing)
    error_maps: tuple[Array, Array] | None = None

    @property
    def clock_drift(self) -> float | None:
        """By how much B's clock runs faster than A's, parts per million; None where that is not known."""
        return self.timing.drift

    def frame_of_b(self, frame: ArrayLike) -> Array:
        """Return where frames of A fall among the frames of B, where no frame of either is missing.

        Where frames were dropped the recordings know more: see :func:`epibar.clocks.positions_in_b`.
        """
        return position_in_b(frame, self.time_offset, self.timing.frames_per_frame)

    def trusted(self, max_error: float = MAX_EXPECTED_ERROR) -> tuple[Bits, Bits]:
        """Where in the images F can be relied on: the expected error there is at most ``max_error`` pixels.

        Parameters
        ----------
        max_error : float
            Pixels.

        Returns
        -------
        two ndarray of bool, shape (24, 32)
            For the cells of ``error_maps`` over A, and over B; False all over where the pair is not accepted.

        Raises
        ------
        EpibarError
            The limit is not a positive number.
        """
        limit = as_positive("max_error", max_error, "pixels")
        if self.error_maps is None or not self.accepted:
            return np.zeros(MAP_SHAPE, bool), np.zeros(MAP_SHAPE, bool)
        # Not a number is no place that is known.
        over_a, over_b = (grid <= limit for grid in self.error_maps)
        return over_a, over_b

    def __repr__(self) -> str:
        error = "" if self.expected_error is None else f", expected error {self.expected_error:.2g} px"
        return f"<Calibration {self.kind}{error}: {self.reason}>"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to one compressed ``.npz`` file, whole or not at all.

        Raises
        ------
        EpibarError
            The file cannot be written.
        """
        write_archive(path, to_arrays(self))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Calibration:
        """Read what :meth:`save` wrote. No pickle is involved: the file may come from anyone.

        Raises
        ------
        EpibarError
            The file is missing, damaged, something else, or of another format.
        """
        return cls.from_arrays(read_archive(path, KIND), os.fspath(path))

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, AnyArray], where: str) -> Calibration:
        """Make a calibration of the arrays of a saved one; ``where`` names them in errors.

        Raises
        ------
        EpibarError
            The arrays are something else, damaged, or of another format.
        """
        nested = {"candidates": Candidates, "frontier_points": FrontierPoints, "timing": Timing}
        calibration = from_arrays(cls, nested, arrays, where)
        calibration._check(where)
        return calibration

    def _check(self, where: str) -> None:
        """Refuse arrays whose shapes do not belong together."""
        pairs, points = len(self.candidates.correlation), len(self.frontier_points.residual)
        lines, corners = self.candidates, self.frontier_points
        expected = [
            ("F", self.F, (3, 3)),
            ("floor", self.floor, (3, 3)),
            ("candidates.lines_a", lines.lines_a, (pairs, 3)),
            ("candidates.lines_b", lines.lines_b, (pairs, 3)),
            ("candidates.inliers", lines.inliers, (pairs,)),
            ("frontier_points.frame", corners.frame, (points,)),
            ("frontier_points.a", corners.a, (points, 2)),
            ("frontier_points.b", corners.b, (points, 2)),
        ]
        for name, array, shape in expected:
            if array is not None and np.shape(array) != shape:
                raise EpibarError(f"{where}: damaged ({name} has shape {np.shape(array)}, expected {shape})")


def calibrate(
    rec_a: Recording,
    rec_b: Recording,
    method: Literal["frontier", "lines"] = "frontier",
    seed: int = 0,
    time_offset: float | Literal["search", "auto"] = 0.0,
    upright: bool = True,
    *,
    essential: bool = True,
    candidates: int = 1000,
    draws: int = 10_000,
    max_expected_error: float = MAX_EXPECTED_ERROR,
    search_seconds: float = SEARCH_SECONDS,
    sharpen_offset: bool = False,
    progress: Callable[[str, float], None] | None = None,
) -> Calibration:
    """Find the fundamental matrix of two cameras from what moved before both.

    Parameters
    ----------
    rec_a, rec_b : Recording
        Of the two cameras, over the same time.
    method : {"frontier", "lines"}
        ``"lines"`` is the method of the paper, motion barcodes alone; ``"frontier"`` goes on with the points
        where epipolar planes touch the silhouettes, and is more accurate.
    seed : int
        Of every random draw of the search; how flat motion is judged does not depend on it. The result
        depends on it and the recordings, not on the number of threads.
    time_offset : float, "search" or "auto"
        Where frame 0 of A falls in B, in frames of B after B's frame 0; it need not be a whole number. At
        equal frame rates frame i of A is frame ``i + time_offset`` of B; other rates meet through the times.
        ``"search"`` finds it, to a fraction of a frame. ``"auto"`` tries no offset first: what is accepted so
        has passed the test of shifted clocks, so that another offset would have been noticed. Where it is
        refused an offset is searched for, and where neither is accepted it is the one for which more speaks.
    upright : bool
        Both cameras are the right way up, rolled by less than a quarter turn. Upright walkers look nearly the
        same upside down, and a mirrored geometry may have as much evidence as the true one. With False, up
        comes from how silhouettes stand, for cameras above the waist of those who walk; where they do not
        tell, the mirror is searched too.
    essential : bool
        Where both recordings know their camera matrix, expect F to be an essential matrix under them: its
        singular values equal to about a percent. That leaves five parameters of seven. False leaves all seven
        to the motion, and ``method="lines"`` always does.
    candidates : int
        How many of the best pairs of lines are candidates (paper, section 2: 1,000).
    draws : int
        How many hypotheses to draw from line pairs (paper, section 4.3: 10,000).
    max_expected_error : float
        Accept only below this, pixels.
    search_seconds : float
        How far either way the search for an offset looks. A wider search asks for more evidence.
    sharpen_offset : bool
        A given ``time_offset`` is right to a frame or two only, and is measured with the geometry.
    progress : callable, optional
        Called with the name of the stage and the share of it that is done, 0 to 1.

    Returns
    -------
    Calibration
        Also where no F could be found: then ``F`` is None and ``reason`` says why.

    Raises
    ------
    EpibarError
        An argument is of the wrong kind or out of its range.

    References
    ----------
    Y. Kasten, G. Ben-Artzi, S. Peleg, M. Werman, "Fundamental Matrices from Moving Objects Using Line Motion
    Barcodes", ECCV 2016.

    Examples
    --------
    >>> import epibar
    >>> rec_a, rec_b = epibar.Recording.load("cam1.npz"), epibar.Recording.load("cam2.npz")
    >>> cal = epibar.calibrate(rec_a, rec_b)
    >>> if cal.accepted:
    ...     F, error = cal.F, cal.expected_error
    """
    as_recording("rec_a", rec_a)
    as_recording("rec_b", rec_b)
    check_choice("method", method, METHODS)
    seed = as_whole_number("seed", seed, 0, MAX_SEED)
    limit = as_positive("max_expected_error", max_expected_error, "pixels")
    reach = as_positive("search_seconds", search_seconds, "seconds")
    with core_errors():
        result = _core.calibrate(
            rec_a._core,
            rec_b._core,
            method,
            seed,
            _checked_offset(time_offset, rec_a, rec_b),
            bool(sharpen_offset),
            reach,
            bool(upright),
            _matrices(rec_a, rec_b) if essential else None,
            as_whole_number("candidates", candidates, 3),
            as_whole_number("draws", draws, 1),
            limit,
            progress,
        )
    error = result.expected_error
    cause = cause_of_refusal(result.kind, rec_a, rec_b)
    return Calibration(
        F=result.F,
        accepted=result.accepted,
        kind=result.kind,
        reason=result.reason if cause is None else f"{result.reason} {cause}",
        expected_error=error if error is not None and math.isfinite(error) else None,
        time_offset=result.time_offset,
        candidates=Candidates(result.lines_a, result.lines_b, result.correlation, result.inliers),
        frontier_points=FrontierPoints(
            result.frontier_frame, result.frontier_a, result.frontier_b, result.frontier_residual
        ),
        counts=dict(result.counts),
        floor=result.floor,
        rivals=list(result.rivals),
        evidence=dict(result.evidence),
        source=result.source,
        shift_curve=result.shift_curve,
        method=method,
        seed=seed,
        timing=Timing(**result.timing),
        error_maps=result.error_maps,
    )


def _matrices(rec_a: Recording, rec_b: Recording) -> tuple[Array, Array] | None:
    """Camera matrices, where both are known."""
    if rec_a.matrix is None or rec_b.matrix is None:
        return None
    return as_camera_matrix(rec_a.matrix), as_camera_matrix(rec_b.matrix)


def _checked_offset(time_offset: Any, rec_a: Recording, rec_b: Recording) -> float | str:
    """Return the offset in frames of B, or how it is found."""
    if isinstance(time_offset, str) and time_offset in ("search", "auto"):
        return time_offset
    if not is_number(time_offset):
        raise EpibarError(
            f"time_offset = {time_offset!r}: expected a finite number of frames, 'search' or 'auto'"
        )
    before = (rec_a.times[-1] - rec_a.times[0]) / frame_interval(rec_b)
    if time_offset >= rec_b.frames or -time_offset > before + 1:
        raise EpibarError(
            f"time_offset = {time_offset}: the recordings, of {rec_a.frames} and {rec_b.frames} frames, have "
            "none in common"
        )
    return float(time_offset)
