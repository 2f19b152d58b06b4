"""Runs as camera files of Caliscope."""

from __future__ import annotations

from pathlib import Path

from ..arguments import PathLike
from ..runs.run import Run
from .anipose import write_toml

__all__ = ["write_caliscope"]


def write_caliscope(run: Run, path: PathLike, intrinsics: PathLike | None = None) -> list[Path]:
    """Write the cameras as :func:`write_toml` does, in tables as Caliscope reads them.

    Caliscope numbers its cameras: a number is the place in the run, and a camera that has no place in the
    world is there without one.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    EpibarError
        As for :func:`write_toml`.
    """
    return write_toml(run, path, intrinsics, caliscope=True)
