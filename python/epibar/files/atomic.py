"""Files written whole or not at all."""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO

from ..errors import EpibarError

__all__ = ["sweep", "write_atomically", "write_text"]

LEFT_OVER = re.compile(r"\..+\.[0-9a-f]{16}\.epibar-part")


def write_atomically(path: str | os.PathLike[str], write: Callable[[IO[bytes]], object]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then rename it: no reader ever sees half a file.

    File and folder are synced, so that what is there after a power cut is the old file or the new one. The
    file gets the permissions that the user's umask leaves.

    Raises
    ------
    EpibarError
        The folder is missing or not writable, the disk is full, or there is a pipe or a device of this name.
        What was there before is there still.
    """
    target = _place_of(Path(path))
    temporary = target.with_name(f".{target.name}.{secrets.token_hex(8)}.epibar-part")
    try:
        handle = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
        try:
            with os.fdopen(handle, "w+b") as stream:
                write(stream)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(temporary, target)
        except BaseException:
            with suppress(OSError):
                os.unlink(temporary)
            raise
        _sync_folder(target.parent)
    except (OSError, ValueError) as error:  # a name that no file can have, too
        reason = getattr(error, "strerror", None) or error
        raise EpibarError(f"{target}: cannot be written ({reason})") from error


def _place_of(path: Path) -> Path:
    """Where a file of this name is: what a link leads to stays where it is, and gets the new content."""
    if path.name in ("", ".."):
        raise EpibarError(f"{os.fspath(path)!r}: cannot be written (no name of a file)")
    try:
        target = path.resolve() if path.is_symlink() else path
        replaces_other = target.exists() and not target.is_file()
    except (OSError, RuntimeError, ValueError) as error:  # links that lead to one another, no name of a file
        raise EpibarError(f"{path}: cannot be written ({error})") from error
    if replaces_other:
        what = "it is a folder" if target.is_dir() else "it is a pipe or a device, which a file would replace"
        raise EpibarError(f"{path}: cannot be written ({what})")
    return target


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text as UTF-8, as :func:`write_atomically` writes; raises as that does."""
    write_atomically(path, lambda stream: stream.write(text.encode()))


def _sync_folder(folder: Path) -> None:
    """Make the new name last. Windows has no such thing, and some file systems refuse it."""
    if os.name == "nt":
        return
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def sweep(folder: Path) -> None:
    """Remove what writers that were killed left in a folder that nobody else writes to."""
    with suppress(OSError):
        for left in folder.iterdir():
            if LEFT_OVER.fullmatch(left.name):
                with suppress(OSError):
                    left.unlink()
