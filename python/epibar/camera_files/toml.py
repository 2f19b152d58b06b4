"""Camera files of aniposelib and Caliscope."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ..lens.camera_file import write_cameras
from ..lens.intrinsics import Intrinsics

__all__ = ["write_anipose", "write_caliscope"]

Metadata = Mapping[str, str | list[str]]


def write_anipose(cameras: Sequence[Intrinsics], path: Path, metadata: Metadata) -> list[Path]:
    """Write what ``CameraGroup.load`` of aniposelib reads; the metadata are in a table of that name."""
    write_cameras(path, cameras, metadata)
    return [path]


def write_caliscope(cameras: Sequence[Intrinsics], path: Path, metadata: Metadata) -> list[Path]:
    """Write Caliscope's camera array; its numbers are places in the table."""
    write_cameras(path, cameras, metadata, caliscope=True)
    return [path]
