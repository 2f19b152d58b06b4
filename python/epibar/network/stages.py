"""How far each stage of a job is."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "stages"]

Progress = Callable[[str, float], None]
"""Takes the name of a stage and the share of it that is done."""


def stages(progress: Progress | None) -> Callable[..., Progress | None]:
    """Make functions that tell how far a stage is, of which so many parts are done."""

    def tell(stage: str, done: int = 0, of: int = 1) -> Progress | None:
        if progress is None:
            return None
        return lambda _, share: progress(stage, (done + share) / of)

    return tell
