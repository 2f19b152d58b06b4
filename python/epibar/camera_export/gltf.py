"""Cameras as a glTF 2.0 scene, for Blender, game engines and viewers.

As the Khronos Group's *glTF 2.0 Specification* has it: the world is y up and in metres ("Coordinate System
and Units"); a camera looks along its -z with y up, and ``yfov`` and ``aspectRatio`` are its lens
("Cameras"); a mesh of ``mode`` 1 is segments ("Meshes"). The root node turns z up into y up; below it all is
as in the network.

A perspective camera of glTF has no distortion, and its axis meets the middle of the image: ``extras`` of a
camera's node hold its ``matrix``, ``distortions``, ``fisheye`` and ``size``.

A walker is the line that the feet go along, a mesh of ``mode`` 3, and a vertical segment from foot to top
that an animation moves; it has size 0 before and after ("Animations"). Seconds are those of the network's
first camera.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import printable
from ..files.atomic import write_atomically
from ..geometry.cameras import opengl_pose
from ..lens.intrinsics import Intrinsics
from .losses import loss_in_pixels, off_as_pinhole, tell
from .shapes import frustum, frustum_depth, ground_grid
from .ways import AFTER, Way
from .world import World

__all__ = ["write_gltf"]

Z_UP = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]
"""Quaternion x y z w that turns z into y."""
Y_DOWN = [1.0, 0.0, 0.0, 0.0]
"""Quaternion x y z w that turns -y into y, where the world is the first camera."""

OPENGL = np.array([1.0, -1.0, -1.0])
FLOAT, ARRAY_BUFFER, LINES, LINE_STRIP = 5126, 34962, 1, 3
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
NEAR = 0.01
"""Where a camera's view begins, over the depth of its frustum."""


def write_gltf(cameras: Sequence[Intrinsics], path: Path, world: World) -> list[Path]:
    """Write cameras, their frusta, a grid at z = 0 where z is up, and walkers: ``.glb`` binary, else JSON.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """
    off = {camera.name: off_as_pinhole(camera, _centred(camera)) for camera in cameras}
    losses = loss_in_pixels("a camera of glTF has no lens, and looks through the middle of its image", off)
    scene = _Scene(cameras, world.with_notes(losses))
    content = scene.binary() if path.suffix.lower() == ".glb" else scene.text()
    write_atomically(path, lambda stream: stream.write(content))
    tell(path, losses)
    return [path]


def _centred(camera: Intrinsics) -> Array:
    """Return the camera matrix that is left of it."""
    width, height = camera.size
    matrix = camera.matrix.copy()
    matrix[:2, 2] = (width - 1) / 2, (height - 1) / 2
    return matrix


class _Scene:
    """What a file holds, but for the buffer."""

    def __init__(self, cameras: Sequence[Intrinsics], world: World) -> None:
        depth = frustum_depth(cameras)
        self._vertices = b""
        self._samples = b""
        self._channels: list[dict[str, Any]] = []
        self._samplers: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._meshes: list[dict[str, Any]] = []
        self._nodes: list[dict[str, Any]] = [
            {
                "name": "epibar",
                "rotation": Y_DOWN if world.zero is None else Z_UP,
                "children": [],
                "extras": world.metadata(),
            }
        ]
        for index, camera in enumerate(cameras):
            self._add_camera(index, camera, depth)
        if world.zero is not None:
            segments, spacing = ground_grid(cameras)
            unit = " m" if world.in_metres else ""
            self._add_lines(f"{world.zero}, grid of {spacing:g}{unit}", segments, self._nodes[0])
        ways = [way for way in world.ways if len(way.time) > 1]  # a line has two ends
        # An animation begins at 0 and not before.
        began = min([0.0, *(float(way.time[0]) for way in ways)])
        for way in ways:
            self._add_way(way, way.time - began)
        if began < 0:
            notes = self._nodes[0]["extras"]["notes"]
            notes.append(f"the animation begins {-began:.3f} s before the first frame of the first camera")
        self._cameras = [_perspective(camera, NEAR * depth) for camera in cameras]

    def _add_camera(self, index: int, camera: Intrinsics, depth: float) -> None:
        rotation, position = opengl_pose(camera.posed())
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation, position
        node = {
            "name": printable(camera.name),
            "matrix": matrix.T.ravel().tolist(),  # column by column
            "camera": index,
            "children": [],
            "extras": {
                "matrix": camera.matrix.tolist(),
                "distortions": camera.distortions.tolist(),
                "fisheye": camera.fisheye,
                "size": list(camera.size),
            },
        }
        self._nodes[0]["children"].append(len(self._nodes))
        self._nodes.append(node)
        self._add_lines(f"{printable(camera.name)} frustum", frustum(camera, depth) * OPENGL, node)

    def _add_way(self, way: Way, time: Array) -> None:
        root = self._nodes[0]
        self._add_lines(way.name, way.foot, root, LINE_STRIP)
        moved = len(self._nodes)
        height = float(np.median(way.top[:, 2] - way.foot[:, 2]))
        self._add_lines(f"{way.name} moving", np.array([[0, 0, 0], [0, 0, height]]), root)
        self._animate(moved, "translation", "LINEAR", time, way.foot)
        # With the first value it begins before its first time as well.
        first, last = float(time[0]), float(time[-1])
        times = np.array([0.0, first, last + AFTER] if first > 0 else [first, last + AFTER])
        shown = np.repeat([[0.0], [1.0], [0.0]] if first > 0 else [[1.0], [0.0]], 3, axis=1)
        self._animate(moved, "scale", "STEP", times, shown)

    def _animate(self, node: int, path: str, interpolation: str, times: Array, values: Array) -> None:
        """Move a node by values (n, 3) at times (n,)."""
        sampler: dict[str, Any] = {"interpolation": interpolation}
        for key, samples in (("input", times[:, None]), ("output", values)):
            sampler[key] = len(self._accessors)
            self._samples += self._accessible(samples, view=1, at=len(self._samples))
        self._channels.append({"sampler": len(self._samplers), "target": {"node": node, "path": path}})
        self._samplers.append(sampler)

    def _add_lines(self, name: str, points: Array, parent: dict[str, Any], mode: int = LINES) -> None:
        primitive = {"attributes": {"POSITION": len(self._accessors)}, "mode": mode}
        parent["children"].append(len(self._nodes))
        self._nodes.append({"name": name, "mesh": len(self._meshes)})
        self._meshes.append({"name": name, "primitives": [primitive]})
        self._vertices += self._accessible(points.reshape(-1, 3), view=0, at=len(self._vertices))

    def _accessible(self, values: Array, view: int, at: int) -> bytes:
        """Return values (n, 3) or (n, 1) as bytes, which stand from a place on in a view of the buffer."""
        numbers = values.astype("<f4")
        accessor = {
            "bufferView": view,
            "byteOffset": at,
            "componentType": FLOAT,
            "count": len(numbers),
            "type": "VEC3" if numbers.shape[1] == 3 else "SCALAR",
            "min": numbers.min(axis=0).tolist(),
            "max": numbers.max(axis=0).tolist(),
        }
        self._accessors.append(accessor)
        return numbers.tobytes()

    @property
    def _buffer(self) -> bytes:
        return self._vertices + self._samples

    def _document(self, buffer: dict[str, Any]) -> bytes:
        vertices = len(self._vertices)
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "epibar"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self._nodes,
            "cameras": self._cameras,
            "meshes": self._meshes,
            "accessors": self._accessors,
            "bufferViews": [{"buffer": 0, "byteLength": vertices, "target": ARRAY_BUFFER}],
            "buffers": [{"byteLength": len(self._buffer), **buffer}],
        }
        if self._channels:  # neither may be empty
            samples = {"buffer": 0, "byteOffset": vertices, "byteLength": len(self._samples)}
            document["bufferViews"].append(samples)
            walkers = {"name": "walkers", "channels": self._channels, "samplers": self._samplers}
            document["animations"] = [walkers]
        return json.dumps(document, allow_nan=False).encode()

    def text(self) -> bytes:
        """Return a ``.gltf`` file, the buffer in it."""
        data = base64.b64encode(self._buffer).decode()
        return self._document({"uri": f"data:application/octet-stream;base64,{data}"})

    def binary(self) -> bytes:
        """Return a ``.glb`` file: a header and two chunks, whose lengths are multiples of four."""
        document = self._document({})
        document += b" " * (-len(document) % 4)
        chunks = b"".join(
            struct.pack("<II", len(content), kind) + content
            for content, kind in ((document, JSON_CHUNK), (self._buffer, BINARY_CHUNK))
        )
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _perspective(camera: Intrinsics, near: float) -> dict[str, Any]:
    width, height = camera.size
    focal_x, focal_y = camera.matrix[0, 0], camera.matrix[1, 1]
    lens = {
        "yfov": float(2 * np.arctan(height / (2 * focal_y))),
        "aspectRatio": float(width * focal_y / (height * focal_x)),
        "znear": near,
    }
    return {"name": printable(camera.name), "type": "perspective", "perspective": lens}
