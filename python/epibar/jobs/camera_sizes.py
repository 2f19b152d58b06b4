"""How much a camera has to record, and how fast it filmed, from the head of its file: nothing is decoded."""

from __future__ import annotations

from pathlib import Path

from ..errors import EpibarError, is_address
from ..sources.chapters import chapter_files, has_chapters
from ..sources.images import IMAGE_SUFFIXES, read_image
from ..sources.mask_array_file import ARRAY_SUFFIXES, MaskArrayFile
from ..sources.quiet_opencv import opencv
from ..sources.source import DEFAULT_FPS
from .inputs import CameraInput, RecordOptions

__all__ = ["frame_rate", "frames_and_pixels"]


def frames_and_pixels(camera: CameraInput, options: RecordOptions) -> tuple[int, int] | None:
    """Frames that are to be recorded, and pixels of each; None where the source does not tell, or is live."""
    announced = _announced_if_readable(camera, options)
    if announced is None:
        return None
    counts, pixels, fps = announced
    try:
        frames = options.frames.expected(options.frames.count(camera.shown, counts), fps)
    except EpibarError:  # whoever records it says what is wrong
        return None
    return None if frames is None or frames < 1 or pixels < 1 else (frames, pixels)


def frame_rate(camera: CameraInput, options: RecordOptions) -> float | None:
    """Frames a second as the source announces them; None where it does not, is live, or is a recording."""
    if not options.masks and Path(camera.source).suffix.lower() in ARRAY_SUFFIXES:
        return None
    announced = _announced_if_readable(camera, options)
    return None if announced is None or min(announced[:2]) < 1 else announced[2]


def _announced_if_readable(camera: CameraInput, options: RecordOptions) -> tuple[int, int, float] | None:
    """What :func:`_announced` says of a camera's source; None where it cannot be read, or is live."""
    if is_address(camera.source):
        return None
    try:
        return _announced(Path(camera.source), options)
    except (EpibarError, OSError):  # whoever records it says what is wrong
        return None


def _announced(path: Path, options: RecordOptions) -> tuple[int, int, float]:
    """Frames of the whole source, pixels of each, frames a second."""
    if options.masks and path.suffix.lower() in ARRAY_SUFFIXES:
        array = MaskArrayFile(path)
        count, height, width = array.shape
        return count, height * width, array.fps or DEFAULT_FPS
    if has_chapters(path):
        heads = [_head(file) for file in chapter_files(path)]
        return sum(count for count, _, _ in heads), heads[0][1], heads[0][2]
    images = sorted(path.iterdir()) if path.is_dir() else [path]
    images = [file for file in images if file.suffix.lower() in IMAGE_SUFFIXES]
    if images:
        height, width = read_image(images[0]).shape[:2]
        return len(images), height * width, DEFAULT_FPS
    return _head(path)


def _head(path: Path) -> tuple[int, int, float]:
    """What the head of a video says of itself."""
    if not path.is_file():  # a device, or nothing
        raise EpibarError(f"{path}: no file")
    cv2 = opencv()
    capture = cv2.VideoCapture(str(path))
    try:
        width, height = (capture.get(key) for key in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
        count, fps = capture.get(cv2.CAP_PROP_FRAME_COUNT), capture.get(cv2.CAP_PROP_FPS)
    except cv2.error as error:
        raise EpibarError(f"{path}: {error}") from error
    finally:
        capture.release()
    usual = all(0 < number < 1e12 for number in (width, height, count))
    return (int(count), int(width * height), fps if 0 < fps < 1e4 else DEFAULT_FPS) if usual else (0, 0, 1.0)
