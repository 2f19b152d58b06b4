"""JSON Schemas of the files that are written, which lie beside them in the package."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

__all__ = ["address", "described"]

ADDRESS = "https://raw.githubusercontent.com/epibar/epibar/main/python/epibar/files/schemas/"


def address(name: str) -> str:
    """Where the schema of that name is for everybody."""
    return f"{ADDRESS}{name}.schema.json"


def described(name: str) -> dict[str, Any]:
    """Return the schema of that name."""
    text = files(__package__).joinpath("schemas", f"{name}.schema.json").read_text("utf-8")
    found: dict[str, Any] = json.loads(text)
    return found
