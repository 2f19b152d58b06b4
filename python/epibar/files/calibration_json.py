"""calibration.json: written, and read back.

The JSON holds no numpy type, no NaN and no infinity: a number that is not known is null.
"""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..errors import EpibarError
from .atomic import write_atomically
from .json_values import plain

__all__ = ["FORMAT", "SCHEMA", "json_text", "read_json", "schema", "write_json"]

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
    """Set the result as JSON."""
    return json.dumps(plain(result), indent=2, allow_nan=False, ensure_ascii=False)


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
        result = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise EpibarError(f"{path}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:
        raise EpibarError(f"{path}: not JSON ({error})") from error
    if not isinstance(result, dict) or not isinstance(result.get("pairs"), list) or "cameras" not in result:
        raise EpibarError(f"{path}: not a calibration written by 'epibar calibrate'")
    if result.get("format") != FORMAT:
        raise EpibarError(f"{path}: format {result.get('format')!r}, but this epibar reads format {FORMAT}")
    return result
