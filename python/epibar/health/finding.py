"""One thing that is wrong with a camera, in plain English."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Finding"]


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    Attributes
    ----------
    kind : str
        One machine-readable word.
    text : str
        What it is and what to do, in plain English.
    serious : bool
        It can by itself be why a pair is refused.
    """

    kind: str
    text: str
    serious: bool = True
