"""How far each stage of a network's job is; no share of a stage is ever less than one told before."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "of_pairs", "stages"]

Progress = Callable[[str, float], None]
"""Takes the name of a stage and the share of it that is done."""


def stages(progress: Progress | None) -> Callable[[str], Progress | None]:
    """Make functions that tell how far a stage is, whatever its parts are called."""

    def tell(stage: str) -> Progress | None:
        if progress is None:
            return None
        return lambda _, share: progress(stage, share)

    return tell


def of_pairs(progress: Progress | None, done: int, of: int) -> Progress | None:
    """Make what is called while a pair is searched after so many, and tells how many of all are done.

    Stages of a pair begin anew in each, and nobody knows how many there will be, so the pair itself counts
    when it is done.
    """
    if progress is None:
        return None
    return lambda *_: progress("pairs", done / of)
