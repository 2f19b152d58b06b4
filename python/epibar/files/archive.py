"""Named arrays in one ``.npz`` file, written whole or not at all, and read without pickle, within limits.

A file may come from anyone. What it says of itself is checked before anything is expanded: no more than
:func:`room` bytes in all, no more in an array than its header says, no dtype but numbers and texts. What is
written keeps the limit: arrays that would be compressed too well are stored as they are.
"""

from __future__ import annotations

import io
import math
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from tokenize import TokenError
from typing import IO, Any, Literal

import numpy as np

from ..arguments import AnyArray
from ..errors import EpibarError
from .atomic import write_atomically
from .npy_header import LONGEST_HEADER, read_npy_header

__all__ = [
    "DAMAGED",
    "ArrayHeader",
    "array_names",
    "check_compression",
    "read_archive",
    "read_array",
    "room",
    "write_archive",
]

SLACK = 32 * 2**20
MOST_EXPANDED = 64
"""Recordings of real videos expand 4 to 11 times, those in which nothing moves some hundred times."""

MOST_ENTRIES = 10_000
KINDS = "biufU"
"""Truth values, whole and real numbers, texts."""

DAMAGED = (
    *(OSError, ValueError, EOFError, KeyError, TypeError, AttributeError, SyntaxError, OverflowError),
    *(zipfile.BadZipFile, zlib.error, NotImplementedError, MemoryError, RuntimeError, TokenError),
)
"""What reading a damaged archive may raise."""


@dataclass(frozen=True)
class ArrayHeader:
    """What an entry says that it holds, before any of it is read."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    order: Literal["C", "F"] = "C"


def room(file_bytes: int) -> int:
    """Return how many bytes a file of so many may expand to."""
    return SLACK + MOST_EXPANDED * file_bytes


def write_archive(path: str | os.PathLike[str], arrays: Mapping[str, Any]) -> None:
    """Write compressed arrays under their names.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """

    def write(stream: IO[bytes]) -> None:
        np.savez_compressed(stream, **arrays)
        with zipfile.ZipFile(stream) as archive:
            expanded = sum(entry.file_size for entry in archive.infolist())
        if expanded > room(stream.seek(0, io.SEEK_END)):
            stream.seek(0)
            stream.truncate()
            np.savez(stream, **arrays)

    write_atomically(path, write)


def array_names(path: str | os.PathLike[str]) -> frozenset[str]:
    """Return the names of the arrays; none of what is missing or damaged, which is told when it is read."""
    if not os.path.isfile(path):  # a pipe would be waited for
        return frozenset()
    try:
        with zipfile.ZipFile(path) as archive:
            return frozenset(name.removesuffix(".npy") for name in archive.namelist())
    except DAMAGED:
        return frozenset()


def read_archive(
    path: str | os.PathLike[str],
    kind: str,
    check: Callable[[Mapping[str, ArrayHeader]], None] | None = None,
) -> dict[str, AnyArray]:
    """Read every array of a file.

    Parameters
    ----------
    path : str or path
        The file.
    kind : str
        What the file should be, for the error message.
    check : callable, optional
        Called with the headers of all arrays before one is expanded; raises EpibarError where they do not fit
        together.

    Raises
    ------
    EpibarError
        The file is missing, damaged, not an ``.npz``, holds pickled objects, or expands beyond all measure.
    """
    where = os.fspath(path)
    if os.path.exists(path) and not os.path.isfile(path):
        raise EpibarError(f"{where}: not a file")
    try:
        with open(path, "rb") as stream, zipfile.ZipFile(stream) as archive:
            entries = _entries(archive, where, os.fstat(stream.fileno()).st_size)
            if check is not None:
                check({name: _header(archive, entry)[0] for name, entry in entries.items()})
            return {name: _array(archive, entry) for name, entry in entries.items()}
    except FileNotFoundError:
        raise EpibarError(f"{where}: no such file") from None
    except EpibarError:
        raise
    except DAMAGED as error:
        raise EpibarError(f"{where}: not {kind}, or damaged") from error


def read_array(path: str | os.PathLike[str], name: str) -> AnyArray:
    """Read one array of a file whose others may be of any size; raises one of :data:`DAMAGED`."""
    if os.path.exists(path) and not os.path.isfile(path):  # a pipe would be waited for
        raise OSError(f"{os.fspath(path)}: not a file")
    with open(path, "rb") as stream, zipfile.ZipFile(stream) as archive:
        return _array(archive, archive.getinfo(f"{name}.npy"), room(0))


def check_compression(archive: zipfile.ZipFile, where: str) -> None:
    """Check that an archive is compressed as numpy does it: other ways expand a file to any length.

    Raises
    ------
    EpibarError
        It is not.
    """
    usual = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
    if any(entry.compress_type not in usual for entry in archive.infolist()):
        raise EpibarError(f"{where}: damaged: compressed in a way that epibar never uses")


def _entries(archive: zipfile.ZipFile, where: str, file_bytes: int) -> dict[str, zipfile.ZipInfo]:
    """Entries by the name of their array, if they may be read."""
    entries = archive.infolist()
    names = [entry.filename.removesuffix(".npy") for entry in entries]
    if len(entries) > MOST_ENTRIES or len(set(names)) < len(names):
        raise EpibarError(f"{where}: damaged: {len(entries)} arrays, of {len(set(names))} names")
    check_compression(archive, where)
    expanded = sum(entry.file_size for entry in entries)
    if expanded > room(file_bytes):
        if "masks" in names:
            raise EpibarError(f"{where}: its key 'masks' says that it holds masks: give --masks")
        raise EpibarError(
            f"{where}: {file_bytes:,} bytes that say they expand to {expanded:,}; no file that epibar wrote "
            "does, so it is damaged or made to fill the memory"
        )
    return dict(zip(names, entries, strict=True))


def _header(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> tuple[ArrayHeader, int]:
    """What an entry says of itself, and after how many bytes its numbers begin."""
    with archive.open(entry) as stream:
        return _parsed(io.BytesIO(stream.read(LONGEST_HEADER + 32)), entry.filename, entry.file_size)


def _parsed(start: IO[bytes], name: str, size: int) -> tuple[ArrayHeader, int]:
    shape, columns_first, dtype = read_npy_header(start)
    if dtype.kind not in KINDS or dtype.names is not None:
        raise ValueError(f"{name}: {dtype} is not what epibar writes")
    if any(side < 0 for side in shape) or math.prod(shape) * dtype.itemsize != size - start.tell():
        raise ValueError(f"{name}: {size} bytes for {shape} of {dtype}")
    return ArrayHeader(shape, dtype, "F" if columns_first else "C"), start.tell()


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, most: int | None = None) -> AnyArray:
    if most is not None and entry.file_size > most:
        raise ValueError(f"{entry.filename}: {entry.file_size:,} bytes")
    with archive.open(entry) as stream:
        data = stream.read(entry.file_size)
    header, start = _parsed(io.BytesIO(data), entry.filename, len(data))
    if 0 in header.shape or not header.dtype.itemsize:
        return np.zeros(header.shape, header.dtype)
    numbers = np.frombuffer(data, header.dtype, offset=start).reshape(header.shape, order=header.order)
    # As numpy reads them: aligned, writable, in the byte order of this machine.
    return numbers.astype(header.dtype.newbyteorder("="))
