"""network.json: its version, and its schema."""

from __future__ import annotations

from typing import Any

from .json_schema import address, described

__all__ = ["FORMAT", "SCHEMA", "schema"]

FORMAT = 1
"""Version of network.json; a file of another one is refused."""

NAME = f"network-{FORMAT}"

SCHEMA = address(NAME)
"""Where its description is: a JSON Schema, which is in the package too."""


def schema() -> dict[str, Any]:
    """JSON Schema of network.json, in the format that is written."""
    return described(NAME)
