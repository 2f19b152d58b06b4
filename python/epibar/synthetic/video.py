"""Real-looking colour video of a scene, for trying the whole path from video to F.

A static textured background per camera, objects of their own colour with shading and a texture that moves
with them, sensor noise and a slight flicker of the light. Where an object is drawn is exactly where its mask
is.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from ..arguments import Array32, Image, Index
from .raster import Spans
from .scene import Scene

_CHUNK = 8


def background(size: tuple[int, int], rng: np.random.Generator) -> Array32:
    """Make a static background, (H, W, 3) float32 in 0–255: multi-scale noise, and a tiled floor below."""
    width, height = size
    image = np.empty((height, width, 3), np.float32)
    image[:] = rng.uniform(95, 150) + rng.uniform(-12, 12, 3)
    for cells, strength in ((4, 22.0), (16, 14.0), (64, 9.0), (200, 6.0)):
        shape = (max(2, cells * height // width), cells)
        noise = rng.normal(0, strength, (*shape, 1)) + rng.normal(0, 0.25 * strength, (*shape, 3))
        noise = noise.astype(np.float32)
        image += cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC)
    # A floor of tiles in rough perspective below a horizon.
    horizon = rng.uniform(0.25, 0.45) * height
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32)
    depth = 1.0 / np.maximum(rows - horizon, 4.0)
    along = np.floor(60.0 * height * depth / 10 + rng.uniform(0, 1))
    across = np.floor((columns - rng.uniform(0.3, 0.7) * width) * depth * 6.0)
    tiles = np.where((along + across) % 2 == 0, 14.0, -14.0) * np.clip(
        (rows - horizon) / (0.2 * height), 0, 1
    )
    result: Array32 = np.clip(image + tiles[..., None].astype(np.float32), 25, 225)
    return result


def render_frames(
    scene: Scene,
    camera_index: int,
    seed: int = 0,
    empty_frames: int = 25,
    noise: float = 2.5,
    flicker: float = 0.006,
) -> Iterator[Image]:
    """Colour frames of one camera, one by one.

    Parameters
    ----------
    scene : Scene
        Its dirt is not used: the video is what makes masks dirty here.
    camera_index : int
    seed : int
    empty_frames : int
        Frames of empty background before frame 0 of the scene, for a background model to learn from.
    noise : float
        Standard deviation of the sensor noise, grey levels.
    flicker : float
        Standard deviation of the brightness from frame to frame, as a share.

    Yields
    ------
    (H, W, 3) uint8 array
        Blue, green, red. ``empty_frames + scene.frames`` of them.
    """
    camera, solids = scene.cameras[camera_index], scene.solids
    width, height = camera.size
    empty = background(camera.size, np.random.default_rng((seed, camera_index, 0)))
    rng = np.random.default_rng((seed, camera_index, 1))
    # An object has one colour in all cameras, saturated: before a greyish background a shadow test must not
    # take it.
    objects = int(solids.owner.max(initial=0)) + 1
    hues = np.random.default_rng((seed, 2)).uniform((0, 170, 150), (180, 240, 255), (1, objects, 3))
    colours = cv2.cvtColor(hues.astype(np.uint8), cv2.COLOR_HSV2BGR)[0].astype(np.float64)
    grain = rng.normal(0, noise, (height + 64, width + 64, 3)).astype(np.float32)

    def finished(frame: Array32) -> Image:
        # One noise field at random places: as good as fresh noise for a background model, and much faster.
        y, x = rng.integers(0, 64, 2)
        lit = frame * np.float32(1 + rng.normal(0, flicker)) + grain[y : y + height, x : x + width]
        result: Image = cv2.convertScaleAbs(np.maximum(lit, 0))
        return result

    def painted(picture: Array32, spans: Spans, solid: Index) -> Array32:
        span, pixel = spans.pixels(width)
        across = (pixel % width - spans.left[span] + 0.5) / (spans.right - spans.left + 1)[span]
        shade = 0.7 + 0.3 * np.sqrt(np.maximum(1 - (2 * across - 1) ** 2, 0))
        checks = np.where((np.floor(4 * across) + spans.row[span] // 6) % 2 == 0, 10.0, -10.0)
        colour = colours[solids.owner[solid]][span] * shade[:, None] + checks[:, None]
        flat = picture.reshape(-1, 3)
        # With an index repeated, numpy keeps the last value: the nearest solid.
        flat[pixel] = np.where(
            solids.moving[solid][span, None], np.clip(colour, 0, 255), furnished.reshape(-1, 3)[pixel]
        )
        return picture

    furnished = empty.copy()
    spans, drawn = scene.spans(camera_index, 0, 1, ordered=True)
    still = spans.take(np.flatnonzero(~solids.moving[drawn][spans.item]))
    pixel = still.pixels(width)[1]
    furnished.reshape(-1, 3)[pixel] = 0.4 * empty.reshape(-1, 3)[pixel] + 30
    for _ in range(empty_frames):
        yield finished(furnished)
    for first in range(0, scene.frames, _CHUNK):
        stop = min(first + _CHUNK, scene.frames)
        spans, drawn = scene.spans(camera_index, first, stop, ordered=True)
        frame_of, solid = np.divmod(spans.item, max(len(drawn), 1))
        for frame in range(stop - first):
            own = np.flatnonzero(frame_of == frame)
            yield finished(painted(furnished.copy(), spans.take(own), drawn[solid[own]]))


def render_video(
    scene: Scene,
    camera_index: int,
    path: str | Path,
    seed: int = 0,
    empty_frames: int = 25,
    noise: float = 2.5,
    flicker: float = 0.006,
) -> Path:
    """Write one camera's colour video, frame by frame; the parameters are those of `render_frames`.

    Returns
    -------
    Path
        What was written: ``path``, or beside it an ``.avi`` in motion JPEG where this OpenCV cannot write
        mp4v.

    Raises
    ------
    OSError
        If neither can be written.
    """
    size = scene.cameras[camera_index].size
    for target, codec in ((Path(path), "mp4v"), (Path(path).with_suffix(".avi"), "MJPG")):
        if codec == "mp4v" and target.suffix.lower() == ".avi":
            continue
        writer = cv2.VideoWriter(str(target), cv2.VideoWriter.fourcc(*codec), scene.fps, size)
        if not writer.isOpened():
            continue
        try:
            for frame in render_frames(scene, camera_index, seed, empty_frames, noise, flicker):
                writer.write(frame)
        finally:
            writer.release()
        return target
    raise OSError(f"{path}: OpenCV can write neither mp4v nor motion JPEG here; does the folder exist?")
