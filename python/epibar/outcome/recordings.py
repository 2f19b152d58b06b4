"""Recordings of a run: those that it keeps, and those that it was given."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import EpibarError
from ..recording import Recording
from .stored import Stored

__all__ = ["recording_of"]


def recording_of(folder: Path, entry: Stored) -> Recording:
    """Load what moved before a camera.

    Parameters
    ----------
    folder : Path
        Of the run.
    entry : Stored
        What calibration.json says of the camera.

    Raises
    ------
    EpibarError
        It is not there any more, is damaged, or the entry names no camera.
    """
    name = entry.text("name")
    kept = folder / "recordings" / f"{name}.npz"
    if "\0" in name or os.path.dirname(os.path.realpath(kept)) != os.path.realpath(folder / "recordings"):
        raise EpibarError(f"{entry.path}: damaged: {name!r} is no name of a camera")
    if kept.exists():
        return Recording.load(kept)
    source = entry.values.get("file")
    if not isinstance(source, str) or not source.lower().endswith(".npz"):
        raise EpibarError(f"{kept}, the recording of {name}, is not there")
    recording = Recording.load(source)  # recorded before; the run added the matrix that it was given
    recording.matrix = entry.matrix("matrix")
    return recording
