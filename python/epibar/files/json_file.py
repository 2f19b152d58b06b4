"""JSON objects in files of their own: written whole or not at all, and read back.

The JSON holds no numpy type, no NaN and no infinity: a number that is not known is null.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ..errors import EpibarError
from .atomic import write_atomically
from .json_values import plain

__all__ = ["json_text", "read_json_object", "write_json"]


def json_text(content: dict[str, Any]) -> str:
    """Set it as strict JSON: no numpy type, no NaN, no infinity."""
    return json.dumps(plain(content), indent=2, allow_nan=False, ensure_ascii=False)


def write_json(path: str | os.PathLike[str], content: dict[str, Any]) -> None:
    """Write it, whole or not at all.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """
    text = json_text(content)
    write_atomically(path, lambda stream: stream.write(text.encode() + b"\n"))


def read_json_object(path: str | os.PathLike[str], kind: str) -> dict[str, Any]:
    """Read it; ``kind`` is what the file should be, for the message.

    Raises
    ------
    EpibarError
        Missing, not JSON, or no object.
    """
    where = os.fspath(path)
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise EpibarError(f"{where}: no such file") from None
    except OSError as error:
        raise EpibarError(f"{where}: cannot be read ({error.strerror or error})") from error
    except (ValueError, RecursionError) as error:
        raise EpibarError(f"{where}: not JSON ({error})") from error
    if not isinstance(content, dict):
        raise EpibarError(f"{where}: not {kind}")
    return content
