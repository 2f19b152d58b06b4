"""One camera over time: all that a pair needs, and nothing of a second camera.

A saved :class:`Recording` holds no image: lines with their motion barcodes, silhouettes, a motion heat map,
frame times. It is small, can be saved, sent to another machine and matched with any other.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from .arguments import (
    MAX_SEED,
    AnyArray,
    Array,
    Mask,
    PackedBits,
    Unsigned,
    as_camera_matrix,
    as_masks,
    as_positive,
    as_text,
    as_whole_number,
    core_errors,
)
from .errors import EpibarError
from .files.archive import ArrayHeader, read_archive, write_archive
from .files.checks import check_format, check_recording
from .lens.intrinsics import Intrinsics
from .sources.pictures import Pictures

__all__ = ["DEFAULT_LINES", "MIN_COMPONENT_AREA", "Recording", "as_recording", "new_recorder"]

DEFAULT_LINES = 20_000
"""Random lines per camera: the number of true candidate pairs grows with it."""

MIN_COMPONENT_AREA = 12
"""Pixels. A smaller component is mostly noise, yet would have as many tangents as a walker."""

FORMAT = 1
"""Version of the saved file; a file of a newer one is refused."""

KIND = "a recording saved by epibar"
MARK = "epibar_recording"
PREFIX = "core_"
MAX_LINES = _core.MAX_LINES


class Recording:
    """Lines with motion barcodes, silhouettes and motion heat map of one camera.

    Made by :func:`epibar.record`, :meth:`from_masks` or :meth:`load`.

    Attributes
    ----------
    name : str
        Of the camera; used in messages and file names.
    warnings : list of str
        What was wrong with the video but bearable, in plain English.
    matrix : ndarray, shape (3, 3), or None
        Camera matrix of the undistorted pixels that all is in; None where no intrinsics were given.
    lens : Intrinsics or None
        What was taken out of the video; None where nothing was, or all that is known is the matrix.
    health : dict of str to float
        What was counted while the video was watched: how often the camera moved, by how much the light
        flickers and so on. Empty where there were no images, as for ready masks. :func:`epibar.inspect` says
        what it means.
    first_frame : int
        Number in the video of frame 0.
    pixel_aspect : float or None
        Width of a pixel over its height, as the video says: fy / fx of its camera. None where pixels are
        square or nothing is said.
    pictures : Pictures or None
        Of some frames, where :func:`epibar.record` was asked for them. They travel with a pickle, and are not
        in the file that :meth:`save` writes.
    """

    def __init__(
        self,
        core: _core.Recording,
        *,
        name: str = "",
        warnings: Sequence[str] = (),
        matrix: ArrayLike | None = None,
        health: Mapping[str, float] | None = None,
        first_frame: int = 0,
        pixel_aspect: float | None = None,
        pictures: Pictures | None = None,
        lens: Intrinsics | None = None,
    ) -> None:
        self._core = core
        self.name = as_text("name", name)
        self.warnings = list(warnings)
        self.matrix = None if matrix is None else as_camera_matrix(matrix)
        self.lens = lens
        self.health = dict(health or {})
        self.first_frame = first_frame
        self.pixel_aspect = (
            None if pixel_aspect is None else as_positive("pixel_aspect", pixel_aspect, "widths for a height")
        )
        self.pictures = pictures

    @classmethod
    def from_masks(
        cls,
        masks: ArrayLike,
        fps: float = 25.0,
        lines: int = DEFAULT_LINES,
        seed: int = 0,
        *,
        name: str = "",
        min_component_area: int = MIN_COMPONENT_AREA,
        matrix: ArrayLike | None = None,
    ) -> Recording:
        """Make a recording of ready masks.

        Parameters
        ----------
        masks : array_like, shape (T, H, W), bool or uint8
            Non-zero where something moves.
        fps : float
            Frames per second.
        lines : int
            How many random lines to draw; more find more true candidate pairs, and take longer.
        seed : int
            Of the lines. Two cameras may share it.
        name : str
            Of the camera, for messages.
        min_component_area : int
            Connected components of fewer pixels give no silhouette; with 1 all do.
        matrix : array_like, shape (3, 3), optional
            Camera matrix, if it is known. The masks must be free of lens distortion.

        Raises
        ------
        EpibarError
            Wrong rank, dtype or size of the masks, a number out of its range, or no camera matrix.

        Examples
        --------
        >>> import numpy as np, epibar
        >>> masks = np.zeros((100, 48, 64), bool)
        >>> for t in range(100):
        ...     masks[t, 10:20, t % 50 : t % 50 + 8] = True
        >>> epibar.Recording.from_masks(masks, lines=200)
        <Recording 64x48, 100 frames, 200 lines>
        """
        stack = as_masks(masks)
        if matrix is not None:
            matrix = as_camera_matrix(matrix)
        try:
            fps = float(fps)
        except (TypeError, ValueError, OverflowError):
            raise EpibarError(f"fps = {fps!r}: expected a number") from None
        if not (math.isfinite(fps) and fps > 0):
            raise EpibarError(f"fps = {fps}: it must be positive and finite")
        recorder = new_recorder(stack.shape[2], stack.shape[1], lines, seed, min_component_area)
        with core_errors():
            for index, mask in enumerate(stack):
                recorder.push(mask, index / fps)
            return cls(recorder.finish(), name=name, matrix=matrix)

    @property
    def width(self) -> int:
        """Pixels."""
        return self._core.width

    @property
    def height(self) -> int:
        """Pixels."""
        return self._core.height

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self._core.frames

    @property
    def seed(self) -> int:
        """Seed of the lines."""
        return self._core.seed

    @property
    def informative(self) -> int:
        """Lines whose barcode says enough to be matched."""
        return self._core.informative

    @property
    def times(self) -> Array:
        """Seconds of each frame since frame 0, (T,)."""
        return self._core.times

    @property
    def segments(self) -> Array:
        """Lines as (x0, y0, x1, y1) on the image border, (n, 4), pixels."""
        return self._core.segments

    @property
    def barcodes(self) -> PackedBits:
        """Packed motion barcodes of the lines, (n, words)."""
        return self._core.barcodes

    @property
    def heat(self) -> Unsigned:
        """In how many frames each pixel moved, (H, W)."""
        return self._core.heat

    @property
    def moving_pixels(self) -> Unsigned:
        """Moving pixels of each frame, (T,)."""
        return self._core.moving_pixels

    @property
    def visible(self) -> Mask | None:
        """Where motion can be seen, (H, W), non-zero; None where that is all of the image.

        Outlines that end elsewhere are those of the view, not of what moves, and give no frontier points.
        """
        return self._core.visible

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self._core.width, self._core.height

    def hulls(self, frame: int) -> list[Array]:
        """Convex hulls of the silhouettes of a frame, each (k, 2) corners in pixels."""
        index = as_whole_number("frame", frame, 0, self._core.frames - 1)
        with core_errors():
            return self._core.hulls(index)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as arrays, on the way to another process or machine."""
        pictures = None if self.pictures is None else self.pictures.to_arrays()
        return _unpickled, (self.to_arrays(), pictures)

    def __repr__(self) -> str:
        name = f" {self.name!r}" if self.name else ""
        return (
            f"<Recording{name} {self.width}x{self.height}, {self.frames} frames, {len(self.segments)} lines>"
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to one compressed ``.npz`` file, whole or not at all.

        Raises
        ------
        EpibarError
            The file cannot be written.
        """
        write_archive(path, self.to_arrays())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Recording:
        """Read what :meth:`save` wrote. No pickle is involved: the file may come from anyone.

        Raises
        ------
        EpibarError
            The file is missing, damaged, something else, or of a newer format.
        """
        where = os.fspath(path)

        def check(headers: Mapping[str, ArrayHeader]) -> None:
            if MARK in headers:  # what is no recording is told from its arrays
                check_recording(where, headers)

        return cls.from_arrays(read_archive(path, KIND, check), where)

    def to_arrays(self) -> dict[str, AnyArray]:
        """Return everything as named arrays, as they are in the file."""
        arrays: dict[str, Any] = {PREFIX + key: value for key, value in self._core.to_arrays().items()}
        arrays[MARK] = np.array(FORMAT)
        arrays["name"] = np.array(self.name)
        arrays["warnings"] = np.array(self.warnings, dtype=np.str_)
        arrays["health_names"] = np.array(list(self.health), dtype=np.str_)
        arrays["health_values"] = np.array(list(self.health.values()), dtype=np.float64)
        arrays["first_frame"] = np.array(self.first_frame)
        if self.pixel_aspect is not None:
            arrays["pixel_aspect"] = np.array(self.pixel_aspect)
        if self.matrix is not None:
            arrays["matrix"] = self.matrix
        if self.lens is not None:
            arrays["distortions"], arrays["fisheye"] = self.lens.distortions, np.array(self.lens.fisheye)
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, AnyArray], where: str) -> Recording:
        """Make a recording of the arrays that :meth:`to_arrays` returned; ``where`` names them in errors.

        Raises
        ------
        EpibarError
            The arrays are something else, damaged, or of a newer format.
        """
        if MARK not in arrays:
            hint = (
                "; its key 'masks' says that it holds masks: give --masks, or masks=True"
                if "masks" in arrays
                else ""
            )
            raise EpibarError(f"{where}: not {KIND}{hint}")
        try:
            check_format(where, arrays[MARK], FORMAT)
            check_recording(where, arrays)
            matrix = arrays.get("matrix")
            core = {
                key.removeprefix(PREFIX): value for key, value in arrays.items() if key.startswith(PREFIX)
            }
            name, made = str(arrays["name"]), _core.Recording.from_arrays(core)
            return cls(
                made,
                name=name,
                warnings=[str(text) for text in np.atleast_1d(arrays["warnings"])],
                matrix=matrix,
                health=_stored_health(arrays),
                first_frame=as_whole_number("first_frame", arrays.get("first_frame", np.array(0))[()], 0),
                pixel_aspect=_stored_aspect(arrays),
                lens=_stored_lens(arrays, name, (made.width, made.height)),
            )
        except (ValueError, TypeError, KeyError, OverflowError) as error:
            text = str(error)
            raise EpibarError(text if text.startswith(where) else f"{where}: damaged ({text})") from error


def as_recording(name: str, value: Any) -> Recording:
    """Return ``value``, the argument ``name``, if it is a recording."""
    if not isinstance(value, Recording):
        raise EpibarError(
            f"{name} is a {type(value).__name__}, expected a Recording, e.g. from epibar.record"
        )
    return value


def _stored_lens(arrays: Mapping[str, AnyArray], name: str, size: tuple[int, int]) -> Intrinsics | None:
    """Read the lens that was taken out; files of older versions have the matrix alone."""
    matrix, distortions = arrays.get("matrix"), arrays.get("distortions")
    if matrix is None or distortions is None:
        return None
    return Intrinsics(name, size, matrix, distortions, bool(arrays.get("fisheye", np.array(False))))


def _stored_aspect(arrays: Mapping[str, AnyArray]) -> float | None:
    """Read how wide pixels are; files of older versions do not say."""
    return float(arrays["pixel_aspect"]) if "pixel_aspect" in arrays else None


def _stored_health(arrays: Mapping[str, AnyArray]) -> dict[str, float]:
    """Read the numbers of the camera's health; files of older versions have none."""
    names, values = arrays.get("health_names"), arrays.get("health_values")
    if names is None or values is None:
        return {}
    if names.ndim != 1 or names.shape != values.shape:
        raise ValueError("the numbers of the camera's health do not fit their names")
    found = {str(name): float(value) for name, value in zip(names, values, strict=True)}
    for name, value in found.items():
        # A view that went altogether moved infinitely far.
        if not (math.isfinite(value) or (name.startswith("moved_") and value > 0)):
            raise ValueError(f"{name} of the camera's health is {value}")
    return found


def _unpickled(arrays: dict[str, AnyArray], pictures: dict[str, AnyArray] | None = None) -> Recording:
    # Buffers that came over a network need not be aligned, and the compiled module wants them so.
    aligned = {name: np.require(array, requirements=["C", "A"]) for name, array in arrays.items()}
    recording = Recording.from_arrays(aligned, "pickled recording")
    if pictures is not None:
        recording.pictures = Pictures.from_arrays(pictures, "pickled recording: its pictures")
    return recording


def new_recorder(
    width: int,
    height: int,
    lines: int,
    seed: int,
    min_component_area: int,
    visible: Mask | None = None,
) -> _core.Recorder:
    """Make a recorder, with every argument checked; ``visible`` as in :attr:`Recording.visible`."""
    with core_errors():
        return _core.Recorder(
            width,
            height,
            as_whole_number("lines", lines, 1, MAX_LINES),
            as_whole_number("seed", seed, 0, MAX_SEED),
            as_whole_number("min_component_area", min_component_area, 1),
            visible,
        )
