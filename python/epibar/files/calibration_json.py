"""calibration.json: written, and read back.

The JSON holds no numpy type, no NaN and no infinity: a number that is not known is null.
"""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..errors import UNPRINTABLE, EpibarError
from .atomic import write_atomically
from .checks import check_format
from .json_values import plain

__all__ = ["FORMAT", "SCHEMA", "is_plain_name", "json_text", "read_json", "schema", "write_json"]

FORMAT = 1
"""Version of calibration.json; a file of another one is refused."""

SCHEMA = (
    "https://raw.githubusercontent.com/epibar/epibar/main/python/epibar/files/schemas/"
    f"calibration-{FORMAT}.schema.json"
)
"""Where its description is: a JSON Schema, which is in the package too."""


def schema() -> dict[str, Any]:
    """JSON Schema of calibration.json, in the format that is written."""
    text = files(__package__).joinpath("schemas", f"calibration-{FORMAT}.schema.json").read_text("utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def json_text(result: dict[str, Any]) -> str:
    """Set the result as JSON, in which what a terminal would obey is spelt out."""
    text = json.dumps(plain(result), indent=2, allow_nan=False, ensure_ascii=False)
    return UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def write_json(path: Path, result: dict[str, Any]) -> None:
    """Write the result, whole or not at all."""
    text = json_text(result)
    write_atomically(path, lambda stream: stream.write(text.encode() + b"\n"))


def read_json(path: Path) -> dict[str, Any]:
    """Read a calibration.json.

    Raises
    ------
    EpibarError
        Missing, not JSON, or not what this program writes.
    """
    try:
        if not path.is_file():  # a pipe would be waited for
            raise EpibarError(f"{path}: {'not a file' if path.exists() else 'no such file'}")
        result = json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    except OSError as error:
        raise EpibarError(f"{path}: cannot be read ({error.strerror or error})") from error
    except RecursionError as error:
        raise EpibarError(f"{path}: not JSON that epibar wrote (too deep)") from error
    except ValueError as error:
        if isinstance(error, EpibarError):
            raise
        raise EpibarError(f"{path}: not JSON ({error})") from error
    if not isinstance(result, dict) or not isinstance(result.get("pairs"), list) or "cameras" not in result:
        raise EpibarError(f"{path}: not a calibration written by 'epibar calibrate'")
    check_format(str(path), result.get("format"), FORMAT)
    return result


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")


def is_plain_name(name: str) -> bool:
    """Whether a name is that of a file in the folder itself, on every system."""
    return name not in ("", ".", "..") and not any(sign in name for sign in "/\\:\0")
