"""Camera files of aniposelib, Caliscope, FreeMoCap and Pose2Sim, which are one another's kin.

- aniposelib: ``CameraGroup.load`` (``aniposelib/cameras.py``) sorts the tables by their names and takes all
  but ``metadata`` for cameras.
- Caliscope: ``CameraArray.from_toml`` (``caliscope/cameras/camera_array.py``), tables ``cameras.0``, ...
- FreeMoCap: its own ``CameraGroup.load`` (``capture_volume_calibration/anipose_camera_calibration/
  freemocap_anipose.py``), aniposelib's with ``world_orientation`` and ``world_position`` of each camera;
  millimetres, as its ``charuco_square_size``.
- Pose2Sim: ``retrieve_calib_params`` and ``computeP`` (``Pose2Sim/common.py``) take every table but
  ``metadata``, ``capture_volume``, ``charuco`` and ``checkerboard`` for a camera, in the order of the file,
  which is to be that of the folders of poses; four distortions, as its ``toml_write`` (``calibration.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..lens.cameras_toml import write_cameras
from ..lens.intrinsics import Intrinsics
from .losses import fewer_coefficients, loss_in_pixels, tell
from .world import World

__all__ = ["write_anipose", "write_caliscope", "write_freemocap", "write_pose2sim"]

MILLIMETRES = 1000.0


def write_anipose(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write what ``CameraGroup.load`` of aniposelib reads; the metadata are in a table of that name."""
    write_cameras(path, cameras, world.metadata())
    return [path]


def write_caliscope(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write Caliscope's camera array; its numbers are places in the table."""
    write_cameras(path, cameras, world.metadata(), caliscope=True)
    return [path]


def write_freemocap(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write FreeMoCap's calibration, a thousand times as long: it counts in millimetres."""
    longer = [replace(camera, translation=MILLIMETRES * camera.posed().t) for camera in cameras]
    unit = "millimetre" if world.in_metres else f"a thousandth of {world.unit}"
    stands = [
        {"world_orientation": pose.R.T, "world_position": -pose.R.T @ pose.t}
        for pose in (camera.posed() for camera in longer)
    ]
    write_cameras(path, longer, replace(world, unit=unit).metadata(), more=stands)
    return [path]


def write_pose2sim(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write Pose2Sim's calibration, with k1 k2 p1 p2 and no more.

    Raises
    ------
    EpibarError
        A camera has a fisheye lens, or the file cannot be written.
    """
    known, off = [], {}
    for camera in cameras:
        distortions, off[camera.name] = fewer_coefficients(camera, 4, "Pose2Sim")
        known.append(replace(camera, distortions=distortions))
    losses = loss_in_pixels("Pose2Sim has four distortion coefficients, fitted to the lens", off)
    write_cameras(path, known, world.with_notes(losses).metadata())
    tell(path, losses)
    return [path]
