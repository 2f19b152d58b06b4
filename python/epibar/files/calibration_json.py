"""calibration.json: its version, its schema, and reading it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import EpibarError
from .checks import check_format
from .json_file import read_json_object
from .json_schema import address, described

__all__ = ["FORMAT", "SCHEMA", "is_plain_name", "read_json", "schema"]

FORMAT = 1
"""Version of calibration.json; a file of another one is refused."""

NAME = f"calibration-{FORMAT}"

SCHEMA = address(NAME)
"""Where its description is: a JSON Schema, which is in the package too."""


def schema() -> dict[str, Any]:
    """JSON Schema of calibration.json, in the format that is written."""
    return described(NAME)


def read_json(path: Path) -> dict[str, Any]:
    """Read a calibration.json.

    Raises
    ------
    EpibarError
        Missing, not JSON, or not what this program writes.
    """
    kind = "a calibration written by 'epibar calibrate'"
    result = read_json_object(path, kind)
    if "epibar_network" in result:
        raise EpibarError(
            f"{path}: a network by itself, not {kind}: give calibration.json, or the folder that holds it"
        )
    if not isinstance(result.get("pairs"), list) or "cameras" not in result:
        raise EpibarError(f"{path}: not {kind}")
    check_format(str(path), result.get("format"), FORMAT)
    return result


def is_plain_name(name: str) -> bool:
    """Whether a name is that of a file in the folder itself, on every system."""
    return name not in ("", ".", "..") and not any(sign in name for sign in "/\\:\0")
