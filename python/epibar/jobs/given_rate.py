"""A frame rate that is given, ``--fps``: for what states none of its own."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ..errors import EpibarError, address_without_secrets, is_address
from ..files.archive import array_names
from ..sources.images import IMAGE_SUFFIXES
from ..sources.mask_array_file import ARRAY_SUFFIXES
from .inputs import RecordOptions

__all__ = ["refuse_rate"]


def refuse_rate(sources: Sequence[str], options: RecordOptions) -> None:
    """Refuse a frame rate for what has one: of videos it would put all frames at wrong times.

    Raises
    ------
    EpibarError
        A rate is given, and a source is a video, a stream, a saved recording, or masks that state one.
    """
    for source in sources if options.fps is not None else ():
        states = _states_its_own(source, options)
        if states is not None:
            raise EpibarError(
                f"{address_without_secrets(source)}: {states}, so --fps (fps=) is not for it but for folders "
                "of images and masks that state none; record those by themselves"
            )


def _states_its_own(source: str, options: RecordOptions) -> str | None:
    """Why a source needs no frame rate; None where it does, or is not there."""
    path = Path(source)
    if is_address(source) or options.chapters:
        return "a stream or chapters of a video, which state their own frame rate"
    if not os.path.exists(source) or path.is_dir() or path.suffix.lower() in IMAGE_SUFFIXES:
        return None
    if path.suffix.lower() not in ARRAY_SUFFIXES:
        return "a video, which states its own frame rate"
    if not options.masks:
        return "recorded already, with its frame rate"
    return "its key 'fps' states the frame rate" if "fps" in array_names(path) else None
