"""Pictures of a camera, small enough for the file they go into."""

from __future__ import annotations

import base64
from collections.abc import Collection

import numpy as np

from ..recording import Recording
from ..sources.pictures import Pictures, as_jpeg, decoded, jpeg_within, to_width
from ..sources.quiet_opencv import opencv

__all__ = ["data_url", "heat_picture", "pictures_within"]

CARD_WIDTH = 480


def pictures_within(pictures: Pictures | None, wanted: Collection[int], budget: int) -> dict[int, bytes]:
    """Choose the pictures of some frames.

    Parameters
    ----------
    pictures : Pictures or None
        Of the camera.
    wanted : collection of int
        Frames of the recording.
    budget : int
        Bytes per picture; the resolution of larger ones is lowered.

    Returns
    -------
    dict of int to bytes
        JPEG. Without those that are not there or are damaged.
    """
    kept = pictures or Pictures()
    shown: dict[int, bytes] = {}
    for frame in sorted(set(wanted) & set(kept)):
        image = decoded(kept[frame])
        if image is not None:
            shown[frame] = kept[frame] if len(kept[frame]) <= budget else jpeg_within(image, budget)
    return shown


def heat_picture(recording: Recording, frame: bytes | None = None) -> bytes:
    """Draw the motion heat map, over a grey frame (JPEG) where there is one, as JPEG."""
    cv2 = opencv()
    width = min(CARD_WIDTH, recording.width)
    heat = np.sqrt(recording.heat / max(1, int(recording.heat.max())))
    heat = to_width((255 * heat).astype(np.uint8), width)
    colours = cv2.applyColorMap(heat, cv2.COLORMAP_INFERNO).astype(np.float32)
    if frame is None:
        return as_jpeg(colours.astype(np.uint8))
    grey = cv2.imdecode(np.frombuffer(frame, np.uint8), cv2.IMREAD_GRAYSCALE)
    grey = cv2.resize(grey, (colours.shape[1], colours.shape[0]), interpolation=cv2.INTER_AREA)
    strength = np.minimum(1.0, 1.2 / 255 * heat[..., None])
    mixed = 0.8 * (1 - strength) * grey[..., None] + (0.25 * grey[..., None] + 0.85 * colours) * strength
    return as_jpeg(np.clip(mixed, 0, 255).astype(np.uint8))


def data_url(jpeg: bytes) -> str:
    """Make a picture part of the file."""
    return "data:image/jpeg;base64," + base64.b64encode(jpeg).decode("ascii")
