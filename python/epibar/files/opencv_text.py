"""Texts as OpenCV's FileStorage reads them back."""

from __future__ import annotations

from ..errors import printable

__all__ = ["opencv_text"]

LONGEST = 2000
"""Characters of a text; OpenCV's reader takes no more than some thousand."""


def opencv_text(text: str) -> str:
    """Quote what OpenCV would read as another text, or not at all: it writes what looks quoted as it is."""
    text = printable(text if len(text) <= LONGEST else text[:LONGEST] + "...")
    if text[:1] in ("'", '"') or text != text.strip() or text.lower() == "null":
        return (
            '"'
            + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t")
            + '"'
        )
    return text
