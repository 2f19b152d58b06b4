"""Frames of a camera as JPEG, small enough for the file they go into."""

from __future__ import annotations

import base64
from collections.abc import Collection
from contextlib import closing

import numpy as np

from ..arguments import Image
from ..errors import EpibarError, is_address
from ..lens.undistortion import Undistorter
from ..recording import Recording
from ..sources.colour_frames import ColourFrames
from ..sources.frame_range import FrameRange
from ..sources.mask_frames import MaskFrames
from ..sources.opencv import opencv
from .inputs import ReportCamera

__all__ = ["data_url", "heat_picture", "read_frames"]

WIDTHS = (960, 800, 640, 480, 360, 240)
QUALITY = 80
CARD_WIDTH = 480


def read_frames(camera: ReportCamera, wanted: Collection[int], budget: int) -> dict[int, bytes]:
    """Read frames of a camera again, in one pass.

    Parameters
    ----------
    camera : ReportCamera
    wanted : collection of int
        Frames of the recording.
    budget : int
        Bytes per picture; the resolution follows.

    Returns
    -------
    dict of int to bytes
        JPEG. Without those that cannot be read, so empty where the source is gone, is no video, or no longer
        is the one that was recorded.
    """
    source = camera.source
    if source is None or not wanted or is_address(source):
        return {}
    recording = camera.recording
    first = recording.first_frame
    part = FrameRange(first, first + max(wanted) + 1)
    pictures: dict[int, bytes] = {}
    try:
        undistort = Undistorter(camera.intrinsics, recording.size) if camera.intrinsics else None
        with (MaskFrames if camera.masks else ColourFrames)(source, frames=part) as frames:
            if frames.size != recording.size:
                return {}
            with closing(iter(frames)) as stream:
                for index, _, image in stream:
                    if index in wanted:
                        if camera.masks:
                            image = np.repeat(image[:, :, None] * np.uint8(255), 3, axis=2)
                        straight = image if undistort is None else undistort.image(image)
                        pictures[index] = _jpeg_within(straight, budget)
    except EpibarError:
        pass  # what was read so far is shown, silhouettes elsewhere
    return pictures


def _jpeg_within(image: Image, budget: int) -> bytes:
    """Encode at the largest width that fits; at the smallest where none does."""
    widths = [image.shape[1], *(width for width in WIDTHS if width < image.shape[1])]
    if image.shape[1] > WIDTHS[0]:
        widths = widths[1:]
    data = b""
    for width in widths:
        data = _jpeg(_to_width(image, width))
        if len(data) <= budget:
            break
    return data


def _to_width(image: Image, width: int) -> Image:
    if width == image.shape[1]:
        return image
    cv2 = opencv()
    height = max(1, round(image.shape[0] * width / image.shape[1]))
    method = cv2.INTER_AREA if width < image.shape[1] else cv2.INTER_LINEAR
    result: Image = cv2.resize(image, (width, height), interpolation=method)
    return result


def _jpeg(image: Image, quality: int = QUALITY) -> bytes:
    cv2 = opencv()
    ok, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not ok:
        raise EpibarError(f"a picture of {image.shape[1]}x{image.shape[0]} pixels cannot be encoded as JPEG")
    result: bytes = data.tobytes()
    return result


def heat_picture(recording: Recording, frame: bytes | None = None) -> bytes:
    """Draw the motion heat map, over a grey frame (JPEG) where there is one, as JPEG."""
    cv2 = opencv()
    width = min(CARD_WIDTH, recording.width)
    heat = np.sqrt(recording.heat / max(1, int(recording.heat.max())))
    heat = _to_width((255 * heat).astype(np.uint8), width)
    colours = cv2.applyColorMap(heat, cv2.COLORMAP_INFERNO).astype(np.float32)
    if frame is None:
        return _jpeg(colours.astype(np.uint8))
    grey = cv2.imdecode(np.frombuffer(frame, np.uint8), cv2.IMREAD_GRAYSCALE)
    grey = cv2.resize(grey, (colours.shape[1], colours.shape[0]), interpolation=cv2.INTER_AREA)
    strength = np.minimum(1.0, 1.2 / 255 * heat[..., None])
    mixed = 0.8 * (1 - strength) * grey[..., None] + (0.25 * grey[..., None] + 0.85 * colours) * strength
    return _jpeg(np.clip(mixed, 0, 255).astype(np.uint8))


def data_url(jpeg: bytes) -> str:
    """Make a picture part of the file."""
    return "data:image/jpeg;base64," + base64.b64encode(jpeg).decode("ascii")
