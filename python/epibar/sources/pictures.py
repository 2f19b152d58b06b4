"""Small pictures of some frames of a camera, taken while it was recorded: no video is read again for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..arguments import AnyArray, Image
from ..errors import EpibarError
from ..files.checks import check_format
from .quiet_opencv import opencv

__all__ = ["KIND", "Pictures", "as_jpeg", "decoded", "jpeg_within", "to_width"]

KIND = "pictures kept by epibar"
MARK = "epibar_pictures"
FORMAT = 1

LONGEST_SIDES = (960, 800, 640, 480, 360, 240)
"""Pixels; the resolutions that are tried one after the other."""
QUALITY = 80
JPEG_START = b"\xff\xd8\xff"


class Pictures(Mapping[int, bytes]):
    """JPEG by the number of the frame in the recording, in undistorted pixels where the recording is.

    Parameters
    ----------
    jpegs : mapping of int to bytes

    Raises
    ------
    EpibarError
        A number is below 0, or one is no JPEG.
    """

    def __init__(self, jpegs: Mapping[int, bytes] | None = None) -> None:
        self._jpegs = dict(sorted((jpegs or {}).items()))
        for frame, jpeg in self._jpegs.items():
            if frame < 0 or not jpeg.startswith(JPEG_START):
                raise EpibarError(f"the picture of frame {frame} is no JPEG of a frame")

    def __getitem__(self, frame: int) -> bytes:
        return self._jpegs[frame]

    def __iter__(self) -> Iterator[int]:
        return iter(self._jpegs)

    def __len__(self) -> int:
        return len(self._jpegs)

    def __repr__(self) -> str:
        return f"<Pictures of {len(self)} frames, {sum(map(len, self._jpegs.values())):,} bytes>"

    def to_arrays(self) -> dict[str, AnyArray]:
        """Return everything as named arrays, as they are in the file."""
        starts = np.cumsum([0, *map(len, self._jpegs.values())], dtype=np.int64)
        return {
            MARK: np.array(FORMAT),
            "frames": np.array(list(self._jpegs), dtype=np.int64),
            "starts": starts,
            "bytes": np.frombuffer(b"".join(self._jpegs.values()), np.uint8),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, AnyArray], where: str) -> Pictures:
        """Make pictures of the arrays that :meth:`to_arrays` returned; ``where`` names them in errors.

        Raises
        ------
        EpibarError
            The arrays are something else, damaged, or of a newer format.
        """
        if MARK not in arrays:
            raise EpibarError(f"{where}: not {KIND}")
        check_format(where, arrays[MARK], FORMAT)
        try:
            frames, starts, data = (arrays[name] for name in ("frames", "starts", "bytes"))
            fits = frames.dtype.kind == starts.dtype.kind == "i" and data.dtype == np.uint8
            fits = fits and frames.ndim == starts.ndim == data.ndim == 1
            if not fits or len(starts) != len(frames) + 1 or starts[0] != 0 or starts[-1] != len(data):
                raise ValueError("lengths that do not fit together")
            if (np.diff(starts) <= 0).any() or (np.diff(frames) <= 0).any():
                raise ValueError("frames in no order")
            ends = zip(frames.tolist(), starts[:-1].tolist(), starts[1:].tolist(), strict=True)
            return cls({frame: data[start:end].tobytes() for frame, start, end in ends})
        except (KeyError, ValueError, EpibarError) as error:
            raise EpibarError(f"{where}: damaged ({error})") from error


def to_width(image: Image, width: int) -> Image:
    """Scale an image to a width."""
    if width == image.shape[1]:
        return image
    cv2 = opencv()
    height = max(1, round(image.shape[0] * width / image.shape[1]))
    method = cv2.INTER_AREA if width < image.shape[1] else cv2.INTER_LINEAR
    result: Image = cv2.resize(image, (width, height), interpolation=method)
    return result


def as_jpeg(image: Image) -> bytes:
    """Encode an image.

    Raises
    ------
    EpibarError
        It cannot be encoded.
    """
    cv2 = opencv()
    ok, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    if not ok:
        raise EpibarError(f"a picture of {image.shape[1]}x{image.shape[0]} pixels cannot be encoded as JPEG")
    result: bytes = data.tobytes()
    return result


def decoded(jpeg: bytes) -> Image | None:
    """Decode a picture, (H, W, 3); None where it is damaged."""
    cv2 = opencv()
    try:
        image: Image | None = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    return image


def jpeg_within(image: Image, budget: int, longest: int = LONGEST_SIDES[0]) -> bytes:
    """Encode at the highest resolution that fits into so many bytes; at the lowest where none does.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3), uint8
    budget : int
        Bytes.
    longest : int
        Pixels that the longer side has at most.
    """
    side = max(image.shape[:2])
    sides = [min(side, longest), *(shorter for shorter in LONGEST_SIDES if shorter < min(side, longest))]
    data = b""
    for shorter in sides:
        # Each is scaled from the one before, which is quicker and as good.
        image = to_width(image, max(1, round(image.shape[1] * shorter / max(image.shape[:2]))))
        data = as_jpeg(image)
        if len(data) <= budget:
            break
    return data
