"""Taking the lens out of masks and images.

Lens distortion bends lines, so it goes before anything else. Undistorted pixels keep the camera matrix. A
strong barrel lens sees more than fits into an image of that size and matrix: what lies outside is cut off.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..arguments import AnyArray, Array, Array32, Image, Mask, Size

__all__ = ["Lens", "Undistorter"]

OUTSIDE = -1e4
"""Pixels: no source is there."""


class Lens(Protocol):
    """What has to be known to take a lens out: :class:`~epibar.Intrinsics` has it."""

    @property
    def name(self) -> str:
        """Of the camera."""

    @property
    def size(self) -> Size:
        """Width and height, pixels."""

    @property
    def matrix(self) -> Array:
        """(3, 3), pixels."""

    @property
    def distortions(self) -> Array:
        """OpenCV's coefficients."""

    @property
    def fisheye(self) -> bool:
        """Whether they are those of OpenCV's fisheye model."""

    @property
    def distorted(self) -> bool:
        """Whether the lens bends lines."""

    def check_size(self, size: Size, name: str) -> None:
        """Raise EpibarError where frames of this size are not what this is for; ``name`` has them."""


class Undistorter:
    """Turns masks and images into undistorted pixels of the same camera matrix.

    Parameters
    ----------
    intrinsics : Intrinsics
        Camera the frames are of.
    size : (int, int), optional
        Width and height of the frames, to be checked.
    name : str, optional
        What the error message is to call them; by default the camera's name.

    Attributes
    ----------
    valid : ndarray, shape (H, W), uint8
        1 where an undistorted pixel has a source; 0 where the lens did not look, or where the distortion
        polynomial folds back and would show a part of the image twice.

    Raises
    ------
    EpibarError
        The frames have another size than the intrinsics are for.

    Examples
    --------
    >>> import epibar
    >>> undistort = Undistorter(epibar.load_cameras("cameras.toml")[0])
    >>> straight = undistort(np.zeros(undistort.valid.shape, bool))
    """

    def __init__(self, intrinsics: Lens, size: Size | None = None, name: str | None = None) -> None:
        self.intrinsics = intrinsics
        self._name = name or intrinsics.name
        intrinsics.check_size(size or intrinsics.size, self._name)
        width, height = intrinsics.size
        self.valid: Mask = np.ones((height, width), np.uint8)
        if intrinsics.distorted:
            self._x, self._y = _maps(intrinsics)
            self.valid = ((self._x > -0.5) & (self._x < width - 0.5)).astype(np.uint8)
            self.valid &= (self._y > -0.5) & (self._y < height - 0.5)

    def _remap(self, image: Image) -> AnyArray:
        import cv2

        return cv2.remap(
            image, self._x, self._y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=(0, 0, 0)
        )

    def __call__(self, mask: Mask) -> Mask:
        """Undistort an (H, W) mask, bool or uint8, non-zero = moving; returns uint8 of 0 and 1."""
        self.intrinsics.check_size((mask.shape[1], mask.shape[0]), self._name)
        binary = (np.asarray(mask) != 0).astype(np.uint8)
        if not self.intrinsics.distorted:
            result: Mask = binary
            return result
        return (self._remap(binary * np.uint8(255)) >= 128).astype(np.uint8)

    def image(self, image: Image) -> Image:
        """Undistort an (H, W, 3) or (H, W) uint8 image; black where there is no source."""
        self.intrinsics.check_size((image.shape[1], image.shape[0]), self._name)
        return self._remap(image) if self.intrinsics.distorted else image.copy()


def _maps(camera: Lens) -> tuple[Array32, Array32]:
    """Source pixel of each undistorted pixel, far outside where there is none."""
    import cv2

    maker = cv2.fisheye.initUndistortRectifyMap if camera.fisheye else cv2.initUndistortRectifyMap
    coefficients = camera.distortions
    if not len(coefficients):
        coefficients = np.zeros(4)
    map_x, map_y = maker(camera.matrix, coefficients, np.eye(3), camera.matrix, camera.size, cv2.CV_32FC1)
    width, height = camera.size
    x = (np.arange(width) - camera.matrix[0, 2]) / camera.matrix[0, 0]
    y = (np.arange(height) - camera.matrix[1, 2]) / camera.matrix[1, 1]
    radius = np.hypot(x[None, :], y[:, None])
    folded = radius > _fold_radius(camera, float(radius.max()))
    outside = np.float32(OUTSIDE)
    return np.where(folded, outside, map_x), np.where(folded, outside, map_y)


def _fold_radius(camera: Lens, largest: float) -> float:
    """Where the distorted radius stops growing with the undistorted one, in units of the focal length."""
    radius = np.linspace(0.0, largest, 4097)
    if camera.fisheye:
        theta = np.arctan(radius)
        k = np.zeros(4)
        k[: len(camera.distortions)] = camera.distortions
        distorted = theta * (1 + sum(k[power] * theta ** (2 * power + 2) for power in range(4)))
    else:
        k = np.zeros(14)
        k[: len(camera.distortions)] = camera.distortions
        square = radius**2
        above = 1 + square * (k[0] + square * (k[1] + square * k[4]))
        below = 1 + square * (k[5] + square * (k[6] + square * k[7]))
        with np.errstate(divide="ignore", invalid="ignore"):
            distorted = radius * above / below
    growing = np.diff(distorted) > 0  # false for NaN too
    return float("inf") if growing.all() else float(radius[int(np.argmin(growing))])
