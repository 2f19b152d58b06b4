"""What a NumPy array in a file says of itself."""

from __future__ import annotations

import ast
import io
import struct
from typing import IO, Any

import numpy as np

__all__ = ["LONGEST_HEADER", "read_npy_header"]

LONGEST_HEADER = 10_000
"""Bytes; a longer one costs time and memory, and no array needs it."""

READERS = {
    (1, 0): ("<H", np.lib.format.read_array_header_1_0),
    (2, 0): ("<I", np.lib.format.read_array_header_2_0),
}
"""Of each version, the format of the header's length, and what reads both."""
NOT_PLAIN = (SyntaxError, ValueError, TypeError, MemoryError, RecursionError)


def read_npy_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Read shape, whether the order is Fortran's, and type; the stream is left where the numbers begin.

    Raises
    ------
    ValueError
        It is no header, longer than :data:`LONGEST_HEADER`, or none without Python 2, of which NumPy would
        only warn.
    """
    version = np.lib.format.read_magic(stream)
    if version not in READERS:
        raise ValueError(f"version {version} of the format, which no plain array needs")
    length_format, read = READERS[version]
    prefix = stream.read(struct.calcsize(length_format))
    if len(prefix) < struct.calcsize(length_format):
        raise ValueError("it ends in its header")
    (length,) = struct.unpack(length_format, prefix)
    if length > LONGEST_HEADER:
        raise ValueError(f"a header of {length} bytes, where {LONGEST_HEADER} are the most")
    header = stream.read(length)
    try:
        ast.literal_eval(header.decode("latin1"))
    except NOT_PLAIN as error:
        raise ValueError("its header is damaged, or of Python 2: load it and save it again") from error
    return read(io.BytesIO(prefix + header), max_header_size=LONGEST_HEADER)
