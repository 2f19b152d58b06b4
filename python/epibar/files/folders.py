"""Folders that are written to."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..errors import EpibarError

__all__ = ["make_folder", "refuse_others_files"]


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


def refuse_others_files(path: Path, names: Iterable[str], signed_file: str, mark: str) -> None:
    """Refuse a folder that holds files of these names which this program did not write.

    Parameters
    ----------
    path : Path
    names : iterable of str
        What would be written, or would be read instead of it.
    signed_file : str
        The file that says who wrote them.
    mark : str
        What it then holds.

    Raises
    ------
    EpibarError
        There are such files.
    """
    found = [name for name in names if (path / name).exists()]
    if not found:
        return
    try:
        own = mark in (path / signed_file).read_text(encoding="utf-8", errors="replace")
    except OSError:
        own = False
    if not own:
        raise EpibarError(
            f"{path}: holds {', '.join(found)}, which epibar did not write and would replace: "
            "give another folder"
        )
