"""A known camera: its matrix, its lens, the size of its images, and where it is known its pose."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arguments import LEAST_SKEW, Array, Image, as_camera_matrix, as_numbers
from ..errors import EpibarError
from ..geometry.cameras import Pose
from ..sources.quiet_opencv import opencv
from .undistortion import Undistorter

__all__ = ["Intrinsics", "rotation_vector"]

DISTORTION_COUNTS = (0, 4, 5, 8, 12, 14)
"""Of the OpenCV lens model: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [τx τy]]]]."""


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """One camera of a ``cameras.toml``.

    Parameters
    ----------
    name : str
        Name of the camera.
    size : (int, int)
        Width and height of its images, pixels.
    matrix : (3, 3) array
        Camera matrix, pixels, pixel centres at integers.
    distortions : (n,) array
        OpenCV's coefficients: 0, 4, 5, 8, 12 or 14 of the usual model, 4 of the fisheye model.
    fisheye : bool
        Which of the two.
    rotation, translation : (3,) array, optional
        World to camera: Rodrigues vector, and in the unit of the world.

    Raises
    ------
    EpibarError
        A value of the wrong shape or kind, or not finite.
    """

    name: str
    size: tuple[int, int]
    matrix: Array
    distortions: Array = field(default_factory=lambda: np.zeros(5))
    fisheye: bool = False
    rotation: Array | None = None
    translation: Array | None = None

    def __post_init__(self) -> None:
        size = as_numbers(f"{self.name}: size", self.size, (2,))
        if not all(value > 0 and value == int(value) for value in size):
            raise EpibarError(
                f"{self.name}: size is {list(self.size)}, expected [width, height] in whole pixels"
            )
        try:
            matrix = as_camera_matrix(self.matrix)
        except EpibarError as error:
            raise EpibarError(f"{self.name}: {error}") from None
        if abs(matrix[0, 1]) > LEAST_SKEW or abs(matrix[1, 0]) > LEAST_SKEW:
            raise EpibarError(f"{self.name}: matrix has skew, which OpenCV's lens model does not know")
        distortions = as_numbers(f"{self.name}: distortions", self.distortions, None).ravel()
        allowed = (0, 4) if self.fisheye else DISTORTION_COUNTS
        if len(distortions) not in allowed:
            model = "fisheye" if self.fisheye else "OpenCV"
            raise EpibarError(
                f"{self.name}: {len(distortions)} distortions, the {model} model has {allowed[1:]}"
            )
        values: dict[str, Any] = {"matrix": matrix, "distortions": distortions}
        values["size"] = int(size[0]), int(size[1])
        for key in ("rotation", "translation"):
            if getattr(self, key) is not None:
                values[key] = as_numbers(f"{self.name}: {key}", getattr(self, key), (3,))
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def distorted(self) -> bool:
        """Whether the lens bends lines."""
        return self.fisheye or bool(np.any(self.distortions != 0))

    def check_size(self, size: tuple[int, int], name: str) -> None:
        """Check that frames of this size, (width, height), are what the intrinsics are for.

        Raises
        ------
        EpibarError
            They are not; ``name`` is what has the frames.
        """
        if tuple(size) != self.size:
            width, height = self.size
            raise EpibarError(
                f"{name}: {size[0]}x{size[1]} frames, but its intrinsics are for {width}x{height}"
            )

    def posed(self) -> Pose:
        """Return the camera in the world.

        Raises
        ------
        EpibarError
            Rotation or translation is not known.
        """
        if self.rotation is None or self.translation is None:
            raise EpibarError(
                f"{self.name}: no rotation and translation in the camera file, but they are needed here"
            )
        import cv2

        rotation = np.asarray(cv2.Rodrigues(self.rotation)[0], dtype=np.float64)
        return Pose(self.matrix, rotation, self.translation, self.size)

    def through_lens(self, rays: Array) -> Array:
        """Pixels (n, 2) of rays (n, 2), which are where they meet the plane at depth 1, through the lens."""
        cv2 = opencv()
        if self.fisheye:
            coefficients = np.pad(self.distortions, (0, 4 - len(self.distortions)))
            seen = cv2.fisheye.distortPoints(rays[:, None], self.matrix, coefficients)
        else:
            flat = np.column_stack([rays, np.ones(len(rays))])
            seen = cv2.projectPoints(flat, np.zeros(3), np.zeros(3), self.matrix, self.distortions)[0]
        return np.asarray(seen[:, 0], np.float64)

    def undistort_image(self, image: Image) -> Image:
        """Return an (H, W, 3) uint8 image in undistorted pixels; black where the camera saw nothing."""
        return Undistorter(self, (image.shape[1], image.shape[0])).image(image)


def rotation_vector(rotation: Array) -> Array:
    """Rodrigues vector of a rotation matrix, (3,), as camera files hold it."""
    return np.asarray(opencv().Rodrigues(rotation)[0], dtype=np.float64).ravel()
