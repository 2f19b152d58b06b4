"""calibration.json: its version, its schema, and reading it."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..errors import EpibarError
from .json_file import read_json_object

__all__ = ["FORMAT", "SCHEMA", "read_json", "schema"]

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


def read_json(path: Path) -> dict[str, Any]:
    """Read a calibration.json.

    Raises
    ------
    EpibarError
        Missing, not JSON, or not what this program writes.
    """
    kind = "a calibration written by 'epibar calibrate'"
    result = read_json_object(path, kind)
    if not isinstance(result.get("pairs"), list) or "cameras" not in result:
        raise EpibarError(f"{path}: not {kind}")
    if result.get("format") != FORMAT:
        raise EpibarError(f"{path}: format {result.get('format')!r}, but this epibar reads format {FORMAT}")
    return result
