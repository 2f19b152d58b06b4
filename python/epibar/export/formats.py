"""The formats of ``epibar export``, one module of this package each.

To add one: a module with a function that takes a :class:`~epibar.runs.Run` and a path, writes, and returns
the files it wrote; and a line in :data:`FORMATS`. The command line and its help follow the table.
Standard library only: the command line reads it before anything heavy is imported.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["FORMATS", "Format"]


class Format(NamedTuple):
    """One format.

    Attributes
    ----------
    name : str
        As it is called on the command line.
    module, function : str
        What writes it.
    what : str
        For the help.
    poses : bool
        Relative poses are part of it, where camera matrices are known.
    lenses : bool
        It needs lenses: its function takes a camera file as third argument.
    """

    name: str
    module: str
    function: str
    what: str
    poses: bool = True
    lenses: bool = False

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
        Format("opencv", "opencv", "write_opencv", "FileStorage YAML of OpenCV"),
        Format("npz", "npz", "write_npz", "NumPy arrays"),
        Format("colmap", "colmap", "write_colmap", "a database with the frontier points as verified matches"),
        Format("csv", "csv", "write_csv", "the frontier points", poses=False),
        Format("anipose", "anipose", "write_toml", "camera file of aniposelib, with poses", lenses=True),
        Format("toml", "anipose", "write_toml", "the same, as it was called before", lenses=True),
        Format(
            "caliscope", "caliscope", "write_caliscope", "camera file of Caliscope, with poses", lenses=True
        ),
    )
}
