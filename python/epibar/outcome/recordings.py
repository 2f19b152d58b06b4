"""Recordings of a run: those that it keeps, and those that it was given."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import EpibarError
from ..recording import Recording
from .stored import Stored

__all__ = ["recording_of"]


def refuse_of_another_run(path: Path, recording: Recording, entry: Stored) -> None:
    """Refuse a recording that calibration.json does not tell of, as after a run that was interrupted.

    Raises
    ------
    EpibarError
        The frames are others.
    """
    found = {"frames": recording.frames, "first_frame": recording.first_frame}
    for key, value in found.items():
        if entry.values.get(key, value) != value:
            raise EpibarError(
                f"{path} is of another run than {entry.path}, by its {key}: 'epibar calibrate' with the same "
                "videos and options writes both anew"
            )


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
        recording = Recording.load(kept)
        refuse_of_another_run(kept, recording, entry)
        return recording
    source = entry.values.get("file")
    if not isinstance(source, str) or not source.lower().endswith(".npz"):
        raise EpibarError(f"{kept}, the recording of {name}, is not there")
    recording = Recording.load(source)  # recorded before; the run added the matrix that it was given
    recording.matrix = entry.matrix("matrix")
    return recording
