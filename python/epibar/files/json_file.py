"""JSON objects in files of their own: written whole or not at all, and read back, whoever they come from.

The JSON holds no numpy type, no NaN and no infinity: a number that is not known is null.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ..errors import UNPRINTABLE, EpibarError
from .atomic import write_text
from .json_values import plain

__all__ = ["json_text", "read_json_object", "write_json"]

LARGEST = 512 << 20
"""Bytes of a file that is read: a calibration.json of a hundred cameras is a twentieth of it."""


def json_text(content: dict[str, Any]) -> str:
    """Set it as strict JSON, in which what a terminal would obey is spelt out."""
    text = json.dumps(plain(content), indent=2, allow_nan=False, ensure_ascii=False)
    return UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def write_json(path: str | os.PathLike[str], content: dict[str, Any]) -> None:
    """Write it, whole or not at all.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """
    text = json_text(content)
    write_text(path, text + "\n")


def read_json_object(path: str | os.PathLike[str], kind: str) -> dict[str, Any]:
    """Read it; ``kind`` is what the file should be, for the message.

    Raises
    ------
    EpibarError
        Missing, no regular file, too large, not JSON, or no object.
    """
    where, file = os.fspath(path), Path(path)
    try:
        if not file.is_file():  # a pipe would be waited for
            raise EpibarError(f"{where}: {'not a file' if file.exists() else 'no such file'}")
        size = file.stat().st_size
        if size > LARGEST:
            raise EpibarError(f"{where}: not {kind}: of {size:,} bytes, where at most {LARGEST:,} can be")
        content = json.loads(file.read_text(encoding="utf-8"), parse_constant=_refuse)
    except OSError as error:
        raise EpibarError(f"{where}: cannot be read ({error.strerror or error})") from error
    except RecursionError as error:
        raise EpibarError(f"{where}: not JSON that epibar wrote (too deep)") from error
    except EpibarError:
        raise
    except ValueError as error:
        raise EpibarError(f"{where}: not JSON ({error})") from error
    if not isinstance(content, dict):
        raise EpibarError(f"{where}: not {kind}")
    return content


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")
