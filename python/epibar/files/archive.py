"""Named arrays in one ``.npz`` file, written whole or not at all and read without pickle."""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import EpibarError
from .atomic import write_atomically

__all__ = ["read_archive", "write_archive"]


def write_archive(path: str | os.PathLike[str], arrays: Mapping[str, Any]) -> None:
    """Write compressed arrays under their names."""
    write_atomically(path, lambda stream: np.savez_compressed(stream, **arrays))


def read_archive(path: str | os.PathLike[str], kind: str) -> dict[str, NDArray[Any]]:
    """Read every array of a file.

    Parameters
    ----------
    path : str or path
        The file.
    kind : str
        What the file should be, for the error message.

    Raises
    ------
    EpibarError
        The file is missing, damaged, not an ``.npz`` or holds pickled objects.
    """
    try:
        # Opened here, because numpy leaves the file open when it turns out to be no archive.
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise EpibarError(f"{os.fspath(path)}: not {kind}")
            return {name: archive[name] for name in archive.files}
    except FileNotFoundError:
        raise EpibarError(f"{os.fspath(path)}: no such file") from None
    except EpibarError:
        raise
    except (OSError, ValueError, EOFError, KeyError, TypeError, AttributeError, SyntaxError) as error:
        raise EpibarError(f"{os.fspath(path)}: not {kind}, or damaged") from error
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, MemoryError, RuntimeError) as error:
        raise EpibarError(f"{os.fspath(path)}: not {kind}, or damaged") from error
