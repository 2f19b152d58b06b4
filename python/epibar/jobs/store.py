"""What a job keeps under its folder, so that the next run does only what is missing.

``recordings/<name>.npz`` and ``pairs/<a>_<b>.npz``, each with the key of what it was made of. They are what
:meth:`Recording.save` and :meth:`Calibration.save` write with two entries more, and can be loaded like those.
``pictures/<name>.npz`` is for people alone: a run without it shows silhouettes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .. import recording
from ..arguments import AnyArray
from ..calibration import Calibration
from ..errors import EpibarError
from ..files import calibration_npz as calibration_file
from ..files.archive import read_archive, write_archive
from ..files.folders import make_folder
from ..files.json_file import read_json_object, write_json
from ..network.offsets import ClockOffsets
from ..recording import Recording
from ..sources.pictures import KIND as PICTURES
from ..sources.pictures import Pictures
from .folder import Folder
from .inputs import CLOCKS_FILE, pair_file, pictures_file, recording_file
from .returned import are_clocks

__all__ = ["Store"]

KEY = "epibar_key"
SECONDS = "epibar_seconds"


class Store:
    """Recordings and calibrations kept in a folder.

    Parameters
    ----------
    folder : Folder
        The job's.

    Attributes
    ----------
    damaged : list of str
        What could not be read, and what comes of that, one message per file.
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        self.out = folder.path
        self.damaged: list[str] = []

    def recording(self, name: str, key: str | None) -> Recording | None:
        """Return the kept recording of a camera with its pictures, if there is one with this key."""
        path = self._recording(name)
        try:
            arrays = self._read(path, key, recording.KIND)
            if arrays is None:
                return None
            kept = Recording.from_arrays(arrays, str(path))
        except EpibarError as error:
            self._damaged(path, error)
            return None
        kept.pictures = self._pictures(name, key)
        return kept

    def _pictures(self, name: str, key: str | None) -> Pictures | None:
        path = pictures_file(self.out, name)
        try:
            arrays = self._read(path, key, PICTURES)
            return None if arrays is None else Pictures.from_arrays(arrays, str(path))
        except EpibarError as error:
            self._damaged(path, error, "silhouettes are shown instead")
            return None

    def _damaged(self, path: Path, error: Exception, then: str = "it is made again") -> None:
        reason = str(error) if isinstance(error, EpibarError) else f"{path}: damaged"
        self.damaged.append(f"{reason}; {then}")

    def pair(self, stem: str, key: str | None) -> tuple[Calibration, float] | None:
        """Return the kept calibration of a pair and the seconds it took, if there is one with this key."""
        path = self._pair(stem)
        try:
            arrays = self._read(path, key, calibration_file.KIND)
            if arrays is None:
                return None
            return Calibration.from_arrays(arrays, str(path)), float(arrays[SECONDS])
        except (KeyError, TypeError, ValueError) as error:
            self._damaged(path, error)
            return None

    def keep_recording(self, name: str, key: str | None, kept: Recording, seconds: float) -> None:
        """Write a recording and its pictures, unless it has no key to be found by."""
        if kept.pictures is not None:  # first, as nothing is recorded again for its pictures alone
            self._write(pictures_file(self.out, name), key, kept.pictures.to_arrays(), seconds)
        self._write(self._recording(name), key, kept.to_arrays(), seconds)

    def keep_pair(self, stem: str, key: str | None, kept: Calibration, seconds: float) -> None:
        """Write a calibration, unless it has no key to be found by."""
        self._write(self._pair(stem), key, calibration_file.to_arrays(kept), seconds)

    def clocks(self, key: str | None, cameras: int) -> ClockOffsets | None:
        """Return the kept offsets of the clocks of so many cameras, if there are some with this key."""
        path = self.out / CLOCKS_FILE
        if key is None or not path.exists():
            return None
        try:
            kept = read_json_object(path, "clocks kept by epibar")
            if kept.get(KEY) != key:
                return None
            seconds = [math.nan if value is None else float(value) for value in kept["seconds"]]
            found = ClockOffsets(tuple(seconds), kept["together"])
            if are_clocks(found, cameras):
                return found
            raise ValueError
        except (KeyError, TypeError, ValueError, EpibarError) as error:
            self._damaged(path, error)
            return None

    def keep_clocks(self, key: str | None, kept: ClockOffsets) -> None:
        """Write the offsets of all clocks, unless they have no key to be found by."""
        if key is not None:
            content = {KEY: key, "seconds": list(kept.seconds), "together": kept.together}
            self._write_kept(self.out / CLOCKS_FILE, lambda path: write_json(path, content))

    def _recording(self, name: str) -> Path:
        return recording_file(self.out, name)

    def _pair(self, stem: str) -> Path:
        return pair_file(self.out, stem)

    def _read(self, path: Path, key: str | None, kind: str) -> dict[str, AnyArray] | None:
        if key is None or not path.exists():
            return None
        arrays = read_archive(path, kind)
        return arrays if str(arrays.get(KEY)) == key else None

    def _write(self, path: Path, key: str | None, arrays: dict[str, AnyArray], seconds: float) -> None:
        if key is not None:
            more = {KEY: np.array(key), SECONDS: np.array(seconds)}
            self._write_kept(path, lambda path: write_archive(path, {**arrays, **more}))

    def _write_kept(self, path: Path, write: Callable[[Path], None]) -> None:
        make_folder(path.parent)
        self._folder.will_write(path)
        write(path)
