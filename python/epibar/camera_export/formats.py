"""The programs that cameras in one world are written for, one module of this package each.

To add one: a module with a function that takes a sequence of :class:`~epibar.Intrinsics` with rotations and
translations, a path and the :class:`~epibar.camera_export.world.World` they stand in, writes, and returns the
files it wrote; and a line in :data:`CAMERA_FORMATS`. Pairs have a table of their own,
:mod:`epibar.pair_export.formats`. The command line, its help and ``epibar formats`` follow
:data:`epibar.export.FORMATS`.
Standard library only: the command line reads it before anything heavy is imported.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["ALIASES", "CAMERA_FORMATS", "OPENCV_AXES", "Format"]


class Format(NamedTuple):
    """One format.

    Attributes
    ----------
    name : str
        The program, as it is called on the command line.
    program : str
        Its full name, or who else reads this.
    files : str
        What is written, and where the program looks for it.
    unit : str
        "metre", "millimetre", or "network" for that of the network.
    axes : str
        Those of the world, and of a camera.
    loses : str
        Besides verdicts, expected errors and clocks, for which no program has a place.
    function : str
        What writes it, ``module:name``.
    extra : str
        Extra of the package that it needs.
    reads : bool
        Whether ``epibar`` reads it too, as camera file.
    tracks : bool
        Whether walkers have a place in it.
    points : bool
        Whether points that two cameras share have a place in it.
    package : str
        Where the module is.
    """

    name: str
    program: str
    files: str
    unit: str
    axes: str
    loses: str
    function: str
    extra: str = ""
    reads: bool = False
    tracks: bool = False
    points: bool = False
    package: str = __package__

    @property
    def write(self) -> Callable[..., list[Path]]:
        """The function."""
        module, _, name = self.function.partition(":")
        found: Any = getattr(import_module(f".{module}", self.package), name)
        write: Callable[..., list[Path]] = found
        return write


OPENCV_AXES = "world z up; camera x right, y down, z forward"
OPENGL_AXES = "world z up; camera x right, y up, z back"
GLTF_AXES = "world y up; camera x right, y up, z back"

CAMERA_FORMATS = {
    one.name: one
    for one in (
        Format(
            "anipose",
            "aniposelib, Anipose",
            "a .toml file",
            "network",
            OPENCV_AXES,
            "nothing more",
            "toml:write_anipose",
            reads=True,
        ),
        Format(
            "caliscope",
            "Caliscope",
            "camera_array.toml",
            "network",
            OPENCV_AXES,
            "names: Caliscope numbers its cameras",
            "toml:write_caliscope",
            reads=True,
        ),
        Format(
            "freemocap",
            "FreeMoCap",
            "NAME_camera_calibration.toml, in the folder of the recording",
            "millimetre",
            OPENCV_AXES,
            "nothing more",
            "toml:write_freemocap",
            reads=True,
        ),
        Format(
            "pose2sim",
            "Pose2Sim",
            "Calib.toml, in the folder calibration",
            "metre",
            OPENCV_AXES,
            "distortion coefficients after the fourth (k3), to which k1 k2 p1 p2 are fitted anew; no fisheye",
            "toml:write_pose2sim",
            reads=True,
        ),
        Format(
            "easymocap",
            "EasyMocap",
            "a folder with intri.yml and extri.yml",
            "metre",
            OPENCV_AXES,
            "distortion coefficients after the fifth; no fisheye; names but for letters, digits, - and _",
            "easymocap:write_easymocap",
        ),
        Format(
            "opencv",
            "OpenCV",
            "a YAML file of FileStorage",
            "network",
            OPENCV_AXES,
            "nothing more",
            "opencv:write_cameras_opencv",
        ),
        Format(
            "colmap",
            "COLMAP",
            "a folder with a model in text files, points of tops and bottoms of walkers, and README.txt",
            "network",
            OPENCV_AXES,
            "distortion coefficients after the eighth; who a walker is, and when",
            "colmap:write_cameras_colmap",
            extra="colmap",
            tracks=True,
            points=True,
        ),
        Format(
            "nerfstudio",
            "nerfstudio, MultiNeRF",
            "transforms.json, beside a folder images with a picture of each camera",
            "network",
            OPENGL_AXES,
            "distortion coefficients after the fifth; MultiNeRF knows one lens for all, no k3, no fisheye",
            "nerfstudio:write_nerfstudio",
        ),
        Format(
            "gltf",
            "Blender, game engines, viewers",
            "a .gltf or .glb file: cameras, frusta, grid of the floor, walkers",
            "metre",
            GLTF_AXES,
            "the lens, and a principal point off the middle, which stand in extras; digits after the seventh",
            "gltf:write_gltf",
            tracks=True,
        ),
        Format(
            "rerun",
            "Rerun",
            "an .rrd file: cameras with names, grid of the floor, walkers",
            "network",
            OPENCV_AXES,
            "the lens; digits after the seventh",
            "rerun:write_rerun",
            extra="live",
            tracks=True,
        ),
        Format(
            "npz",
            "NumPy",
            "an .npz file, without pickle",
            "network",
            OPENCV_AXES,
            "nothing more",
            "npz:write_cameras_npz",
        ),
    )
}

ALIASES = {"toml": "anipose"}
"""What a format was called before."""
