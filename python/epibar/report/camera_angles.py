"""What a network says of its cameras, as lengths and angles: how they stand and what they see."""

from __future__ import annotations

import math

import numpy as np

from ..arguments import Array
from ..network.parts import NetworkCamera

__all__ = ["field_of_view", "focal_length", "image_corners", "tilt"]


WITHIN = 0.98
"""Share of the reach that is drawn: next to its end a pixel more is a large angle."""


def _rays(camera: NetworkCamera, pixels: Array) -> Array:
    """Take (n, 2) pixels, as the lens shows them, to (n, 3) directions in the camera, z = 1.

    Those beyond where the lens holds are taken back to there.
    """
    assert camera.matrix is not None
    reach = camera.lens_reach
    if reach is not None:
        middle = camera.matrix[:2, 2]
        out = pixels - middle
        far = np.linalg.norm(out, axis=1, keepdims=True) / (WITHIN * reach)
        pixels = middle + out / np.maximum(far, 1.0)
    return np.column_stack([camera.directions(pixels), np.ones(len(pixels))])


def focal_length(camera: NetworkCamera) -> float | None:
    """Geometric mean of both focal lengths, pixels; None where the camera has no place."""
    if camera.matrix is None:
        return None
    return float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))


def field_of_view(camera: NetworkCamera) -> float | None:
    """Angle from the left of the image to its right through its middle, degrees; None without a place.

    As far as the lens holds that was found.
    """
    if camera.matrix is None:
        return None
    width, height = camera.size
    ends = _rays(camera, np.array([[-0.5, (height - 1) / 2], [width - 0.5, (height - 1) / 2]]))
    ends /= np.linalg.norm(ends, axis=1, keepdims=True)
    return math.degrees(math.acos(float(np.clip(ends[0] @ ends[1], -1, 1))))


def tilt(camera: NetworkCamera) -> float | None:
    """How far it looks down from the horizontal, degrees, negative upwards; None without a place."""
    if camera.rotation is None:
        return None
    return math.degrees(math.asin(float(np.clip(-camera.rotation[2, 2], -1, 1))))


def image_corners(camera: NetworkCamera, depth: float) -> Array | None:
    """Corners of the image at a depth before the camera, (4, 3), clockwise from its upper left.

    Without the lens, and at most 80° off the axis, so that the picture of a fisheye-like lens stays finite.
    """
    if camera.rotation is None or camera.position is None:
        return None
    width, height = camera.size
    right, bottom = width - 0.5, height - 0.5
    rays = _rays(camera, np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]]))
    wide = np.hypot(rays[:, 0], rays[:, 1]) / math.tan(math.radians(80))
    rays[:, :2] /= np.maximum(wide, 1.0)[:, None]
    corners: Array = camera.position + depth * rays @ camera.rotation
    return corners
