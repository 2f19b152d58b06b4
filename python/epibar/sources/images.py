"""Single images."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..arguments import Image
from ..errors import EpibarError
from .quiet_opencv import opencv

__all__ = ["IMAGE_SUFFIXES", "as_bgr", "missing_numbers", "natural_order", "numbers_of", "read_image"]

IMAGE_SUFFIXES = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"}


def natural_order(path: Path) -> list[tuple[int, int, str]]:
    """Sort key that puts ``frame2`` before ``frame10``."""
    parts = re.split(r"(\d+)", path.name.lower())
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts]


def numbers_of(files: Sequence[Path]) -> list[int] | None:
    """Return of each file the one number in which the names of all differ; None where they differ in more."""
    parts = [re.split(r"(\d+)", file.stem.lower()) for file in files]
    if len({(len(part), *part[::2]) for part in parts}) != 1:
        return None
    differ = [place for place in range(1, len(parts[0]), 2) if len({part[place] for part in parts}) > 1]
    return [int(part[differ[0]]) for part in parts] if len(differ) == 1 else None


def missing_numbers(files: Sequence[Path]) -> int:
    """How many are missing between images in natural order, by the one number in which names differ, or 0."""
    numbers = numbers_of(files)
    if numbers is None or len(numbers) < 3:
        return 0
    steps = [after - before for before, after in pairwise(numbers)]
    (usual, count), *_ = Counter(steps).most_common(1)
    if min(steps) <= 0 or 2 * count <= len(steps) or any(step % usual for step in steps):
        return 0
    return sum(step // usual - 1 for step in steps)


def as_bgr(image: Image) -> Image:
    """Convert a grey or BGRA image to BGR."""
    cv2 = opencv()
    if image.ndim == 2 or image.shape[2] == 1:
        result: Image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
        return result
    return image if image.shape[2] == 3 else cv2.cvtColor(image, cv2.COLOR_BGRA2BGR)


def read_image(path: Path) -> Image:
    """One image as BGR uint8; the bytes are read by Python because OpenCV cannot open every file name."""
    cv2 = opencv()
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise EpibarError(f"{path}: cannot be read ({error.strerror or error})") from error
    image = None
    if data.size:
        try:
            image = cv2.imdecode(data, cv2.IMREAD_COLOR)
        except cv2.error:
            image = None
    if image is None:
        raise EpibarError(f"{path}: not an image that OpenCV can decode; remove it or save it again")
    result: Image = image
    return result
