"""Folders that are written to."""

from __future__ import annotations

from pathlib import Path

from ..errors import EpibarError

__all__ = ["make_folder"]


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, where it is not there yet.

    Raises
    ------
    EpibarError
        It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EpibarError(f"{path}: cannot be made ({error.strerror or error})") from error
