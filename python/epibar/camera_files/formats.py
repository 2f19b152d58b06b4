"""The programs that cameras in one world are written for, one module of this package each.

To add one: a module with a function that takes a sequence of :class:`~epibar.Intrinsics` with rotations
and translations, a path and what the file is to say of itself, writes, and returns the files it wrote; and
a line in :data:`FORMATS`. Standard library only: the command line reads it before anything heavy is imported.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["FORMATS", "CameraFormat"]


class CameraFormat(NamedTuple):
    """One format.

    Attributes
    ----------
    name : str
        The program.
    module, function : str
        What writes it.
    what : str
        For the help.
    """

    name: str
    module: str
    function: str
    what: str

    @property
    def write(self) -> Callable[..., list[Path]]:
        """The function."""
        module = import_module(f".{self.module}", __package__)
        found: Any = getattr(module, self.function)
        write: Callable[..., list[Path]] = found
        return write


FORMATS = {
    one.name: one
    for one in (
        CameraFormat("anipose", "toml", "write_anipose", "TOML of aniposelib, which epibar reads too"),
        CameraFormat("caliscope", "toml", "write_caliscope", "TOML of Caliscope"),
        CameraFormat("opencv", "opencv", "write_opencv", "FileStorage YAML of OpenCV"),
        CameraFormat("colmap", "colmap", "write_colmap", "a COLMAP model, in a folder"),
        CameraFormat("npz", "npz", "write_npz", "NumPy arrays"),
    )
}
