"""How far each stage of a network's job is."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "as_stage", "of_pairs"]

Progress = Callable[[str, float], None]
"""Takes the name of a stage and the share of it that is done."""


def as_stage(name: str, progress: Progress | None) -> Progress | None:
    """Make what tells how far a stage is, whatever its own parts are called."""
    return None if progress is None else lambda _, share: progress(name, share)


def of_pairs(progress: Progress | None, done: int, of: int) -> Progress | None:
    """Make what is called while a pair is searched after so many, and tells how many of all are done.

    Stages of a pair begin anew in each, and nobody knows how many there will be, so the pair itself counts
    when it is done.
    """
    if progress is None:
        return None
    return lambda *_: progress("pairs", done / of)
