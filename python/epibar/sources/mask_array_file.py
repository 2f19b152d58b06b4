"""Masks kept as a numpy array in a file, read frame by frame: a long recording need not fit in memory."""

from __future__ import annotations

import math
import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import numpy as np

from ..arguments import Mask
from ..errors import EpibarError
from ..files.archive import DAMAGED, check_compression, read_array
from ..files.checks import LONGEST_SIDE
from ..files.npy_header import read_npy_header

__all__ = ["ARRAY_SUFFIXES", "MaskArrayFile"]

ARRAY_SUFFIXES = {".npz", ".npy"}


class MaskArrayFile:
    """The array ``masks`` of an ``.npz``, or an ``.npy``: (T, H, W), bool or uint8, non-zero = moving.

    Iterating yields (H, W) uint8 masks of 0 and 1; it ends early where the file is cut off.

    Attributes
    ----------
    shape : (int, int, int)
        Frames, height, width.
    fps : float or None
        The number under key ``fps``, if there is one.

    Raises
    ------
    EpibarError
        Missing or damaged file, no such key, wrong rank or dtype, no frames.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)
        self.fps: float | None = None
        self._is_npz = self.path.lower().endswith(".npz")
        file = Path(self.path)
        if not file.exists():
            raise EpibarError(f"{self.path}: no such file or folder")
        if file.stat().st_size == 0:
            raise EpibarError(f"{self.path}: the file is empty; save the masks again")
        if self._is_npz:
            self._read_keys()
        with self._stream() as stream:
            self.shape = self._header(stream)

    def _read_keys(self) -> None:
        try:
            with open(self.path, "rb") as stream, zipfile.ZipFile(stream) as archive:
                check_compression(archive, self.path)
                keys = [name.removesuffix(".npy") for name in archive.namelist()]
            if "fps" in keys:
                fps = float(read_array(self.path, "fps").reshape(-1)[0])
                self.fps = fps if math.isfinite(fps) and fps > 0 else None
        except EpibarError:
            raise
        except (*DAMAGED, IndexError) as error:
            raise EpibarError(f"{self.path}: not a numpy archive that can be read ({error})") from error
        if "masks" not in keys:
            if "core_seed" in keys:
                raise EpibarError(
                    f"{self.path}: a saved recording, not masks; give it without --masks (masks=True)"
                )
            found = ", ".join(keys) or "none"
            raise EpibarError(f"{self.path}: no key 'masks' (found: {found}); use np.savez(path, masks=...)")

    def _stream(self) -> IO[bytes]:
        try:
            if not self._is_npz:
                return open(self.path, "rb")
            with zipfile.ZipFile(self.path) as archive:  # the member keeps the file open for itself
                return archive.open("masks.npy")
        except DAMAGED as error:
            raise EpibarError(f"{self.path}: cannot be read ({error})") from error

    def _header(self, stream: IO[bytes]) -> tuple[int, int, int]:
        where = f"{self.path}: key 'masks'" if self._is_npz else f"{self.path}: the array"
        try:
            shape, fortran, dtype = read_npy_header(stream)
        except DAMAGED as error:
            raise EpibarError(f"{where} is not a numpy array that can be read ({error})") from error
        if dtype not in (np.dtype(bool), np.dtype(np.uint8)):
            raise EpibarError(f"{where} has dtype {dtype}, expected bool or uint8, non-zero = moving")
        if len(shape) != 3:
            raise EpibarError(f"{where} has shape {shape}, expected (frames, height, width)")
        if min(shape) < 1:
            raise EpibarError(f"{where} has shape {shape}: no frames or no pixels")
        if max(shape[1:]) > LONGEST_SIDE:
            raise EpibarError(f"{where} has shape {shape}: no side of an image may be above {LONGEST_SIDE}")
        if fortran:
            raise EpibarError(f"{where} is in Fortran order; save np.ascontiguousarray(masks)")
        return shape

    def __iter__(self) -> Iterator[Mask]:
        frames, height, width = self.shape
        with self._stream() as stream:
            self._header(stream)
            for index in range(frames):
                try:
                    data = stream.read(height * width)
                except DAMAGED as error:
                    raise EpibarError(f"{self.path}: damaged at frame {index} ({error})") from error
                if len(data) < height * width:
                    return
                yield (np.frombuffer(data, np.uint8).reshape(height, width) != 0).astype(np.uint8)
