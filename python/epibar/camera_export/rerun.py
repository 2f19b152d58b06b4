"""Cameras as a recording of the Rerun viewer: pinholes with their names, a grid where z is 0, and walkers.

``world/NAME`` holds a ``Transform3D`` of camera to world and a ``Pinhole``, whose image has pixel centres at
integers and whose axes are x right, y down, z forward, as the reference of ``rerun.Pinhole`` says; it has no
distortion. ``world/walkers/NAME`` is the line that the feet go along; ``NAME/there`` goes from foot to top in
the timeline ``time``, seconds of the network's first camera. What stands in other files as metadata is
a ``TextDocument``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import EpibarError, printable
from ..files.atomic import write_atomically
from ..lens.intrinsics import Intrinsics
from .losses import loss_in_pixels, off_as_pinhole, tell
from .shapes import frustum_depth, ground_grid, positions
from .ways import AFTER, Way
from .world import World

__all__ = ["write_rerun"]

APPLICATION = "epibar"
ROOT = "world"
TIME = "time"


def write_rerun(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write an ``.rrd`` file through ``rerun-sdk``; all is static but for the walkers.

    Raises
    ------
    EpibarError
        ``rerun-sdk`` is missing, or the file cannot be written.
    """
    try:
        import rerun
    except ImportError as error:
        raise EpibarError(
            "rerun-sdk is missing, which writes files of Rerun: pip install 'epibar[live]'"
        ) from error
    off = {camera.name: off_as_pinhole(camera, camera.matrix) for camera in cameras}
    losses = loss_in_pixels("a camera of Rerun has no lens", off)
    stream = rerun.RecordingStream(APPLICATION)
    memory = stream.memory_recording()
    _log(rerun, stream, cameras, world.with_notes(losses))
    content = memory.drain_as_bytes()
    write_atomically(path, lambda file: file.write(content))
    tell(path, losses)
    return [path]


def _log(rerun: Any, stream: Any, cameras: Sequence[Intrinsics], world: World) -> None:
    axes = rerun.ViewCoordinates
    up = axes.RDF if world.zero is None else axes.RIGHT_HAND_Z_UP
    stream.log(ROOT, up, static=True)
    depth = frustum_depth(cameras)
    for camera in cameras:
        pose = camera.posed()
        entity = rerun.new_entity_path([ROOT, printable(camera.name)])
        place = rerun.Transform3D(translation=-pose.R.T @ pose.t, mat3x3=pose.R.T)
        stream.log(entity, place, static=True)
        lens = rerun.Pinhole(
            image_from_camera=camera.matrix,
            resolution=camera.size,
            camera_xyz=axes.RDF,
            image_plane_distance=depth,
        )
        stream.log(entity, lens, static=True)
    names = [printable(camera.name) for camera in cameras]
    stream.log(
        f"{ROOT}/names", rerun.Points3D(positions(cameras), labels=names, radii=depth / 20), static=True
    )
    if world.zero is not None:
        segments, spacing = ground_grid(cameras)
        grid = rerun.LineStrips3D(np.asarray(segments), colors=[(128, 128, 128)] * len(segments))
        stream.log(f"{ROOT}/grid", grid, static=True)
        world = world.with_notes([f"the grid is of {spacing:g}"])
    for way in world.ways:
        _log_way(rerun, stream, way)
    text = "\n\n".join(f"{key}: {printable(value)}" for key, value in world.lines().items())
    stream.log("about", rerun.TextDocument(text), static=True)


def _log_way(rerun: Any, stream: Any, way: Way) -> None:
    entity = rerun.new_entity_path([ROOT, "walkers", way.name])
    stream.log(entity, rerun.LineStrips3D([way.foot]), static=True)
    here = rerun.new_entity_path([ROOT, "walkers", way.name, "there"])
    # After the last place nobody is there.
    times = np.append(way.time, way.time[-1] + AFTER)
    standing = np.stack([way.foot, way.top], axis=1)
    for time, segments in zip(times, [*standing[:, None], []], strict=True):
        stream.set_time(TIME, duration=float(time))
        stream.log(here, rerun.LineStrips3D(segments))
    stream.reset_time()
