"""Recordings of a run: those that it keeps, and those that it was given."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import EpibarError
from ..files.json_values import plain
from ..recording import Recording
from .entries import camera_entry
from .stored import Stored

__all__ = ["recording_of", "refuse_of_another_run"]


def refuse_of_another_run(path: Path, found: Mapping[str, Any], entry: Stored) -> None:
    """Refuse what calibration.json does not tell of, as after a run that was interrupted.

    Raises
    ------
    EpibarError
        A number is another one.
    """
    for key, value in plain(found).items():
        if entry.values.get(key) != value:
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
        expected = camera_entry(name, "", 0, recording)
        there = [key for key in expected if key in entry.values and key not in ("file", "index")]
        refuse_of_another_run(kept, {key: expected[key] for key in there}, entry)
        return recording
    source = entry.values.get("file")
    if not isinstance(source, str) or not source.lower().endswith(".npz"):
        raise EpibarError(f"{kept}, the recording of {name}, is not there")
    recording = Recording.load(source)  # recorded before; the run added the matrix that it was given
    recording.matrix = entry.matrix("matrix")
    return recording
