"""A picture of a pair: both views with matched epipolar lines in matching colours."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Array, Image
from ..calibration import Calibration
from ..errors import EpibarError
from ..files.atomic import write_atomically
from ..lens.intrinsics import Intrinsics
from ..recording import Recording
from ..show.colours import RGB
from ..show.matched_lines import frames_to_show, matched_lines
from ..sources.single_frame import read_frame

__all__ = ["draw_pair", "write_pair_picture"]

PANEL_HEIGHT = 600
LINES = 8
MARGIN = 12
BGR = [colour[::-1] for colour in RGB]


def write_pair_picture(
    path: Path,
    names: tuple[str, str],
    sources: tuple[str, str],
    recordings: tuple[Recording, Recording],
    calibration: Calibration,
    intrinsics: tuple[Intrinsics | None, Intrinsics | None] = (None, None),
) -> Path:
    """Draw a pair over a real frame of each video and write it as PNG.

    Parameters
    ----------
    path : Path
        The file to write.
    names, sources : two of str
        Of the cameras and of the files they were recorded from. Where a frame cannot be read again, e.g.
        because the source is a saved recording, the motion heat map takes its place.
    recordings : two of Recording
    calibration : Calibration
        Of the pair.
    intrinsics : two of Intrinsics or None
        With which the frames are undistorted.
    """
    import cv2

    frames = frames_to_show(recordings, calibration)
    images = [_view(*view) for view in zip(sources, frames, recordings, intrinsics, strict=True)]
    captions = [f"{name}, frame {frame}" for name, frame in zip(names, frames, strict=True)]
    picture = draw_pair((images[0], images[1]), (captions[0], captions[1]), calibration, frames[0])
    ok, data = cv2.imencode(".png", picture)
    if not ok:
        raise EpibarError(f"{path}: the picture cannot be encoded")
    write_atomically(path, lambda stream: stream.write(data.tobytes()))
    return path


def draw_pair(
    images: tuple[Image, Image], captions: tuple[str, str], calibration: Calibration, frame: int
) -> Image:
    """Put two views side by side, with the verdict above and matched epipolar lines in matching colours.

    Parameters
    ----------
    images : two of ndarray, shape (H, W, 3), uint8
        Blue, green, red.
    captions : two of str
        Below the views.
    calibration : Calibration
        Of the pair.
    frame : int
        Frame of A that is shown; its frontier points come first and are marked.
    """
    views = [_scaled(image) for image in images]
    if calibration.F is not None:
        _draw_lines(views, images, calibration, frame)
    height = PANEL_HEIGHT
    gap = np.full((height, MARGIN, 3), 255, np.uint8)
    body = np.hstack([gap, views[0][0], gap, views[1][0], gap])
    verdict = "accepted" if calibration.accepted else f"REFUSED ({calibration.kind})"
    if calibration.expected_error is not None:
        verdict += f", expected error {calibration.expected_error:.2g} px"
    head = [verdict, *textwrap.wrap(calibration.reason, max(30, body.shape[1] // 11))]
    left = MARGIN + views[0][0].shape[1] + MARGIN
    heading = _text_band(body.shape[1], [(MARGIN, line) for line in head], heading=True)
    caption = _text_band(body.shape[1], [(MARGIN, captions[0]), (left, captions[1])], heading=False)
    return np.vstack([heading, body, caption])


def _view(source: str, frame: int, recording: Recording, intrinsics: Intrinsics | None) -> Image:
    """Read one frame, undistorted where the recording is; the heat map where there is no such frame."""
    try:
        image = read_frame(source, recording.first_frame + frame)
    except EpibarError:
        return _heat_map(recording)
    if image.shape[:2] != (recording.height, recording.width):
        return _heat_map(recording)
    if image.max() <= 1:
        image = image * np.uint8(255)
    return image if intrinsics is None else intrinsics.undistort_image(image)


def _heat_map(recording: Recording) -> Image:
    import cv2

    heat = np.sqrt(recording.heat / max(1, int(recording.heat.max())))
    return cv2.applyColorMap((255 * heat).astype(np.uint8), cv2.COLORMAP_INFERNO)  # type: ignore[return-value]


def _scaled(image: Image) -> tuple[Image, float]:
    """Scale to the height of a panel; also returns the factor."""
    import cv2

    scale = PANEL_HEIGHT / image.shape[0]
    size = (max(1, round(image.shape[1] * scale)), PANEL_HEIGHT)
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(image, size, interpolation=method), scale  # type: ignore[return-value]


def _draw_lines(
    views: list[tuple[Image, float]], images: tuple[Image, Image], calibration: Calibration, frame: int
) -> None:
    """Draw the epipolar lines of a few points, and the points of the frame that is shown."""
    sizes = [(image.shape[1], image.shape[0]) for image in images]
    lines = list(zip(BGR, matched_lines(calibration, sizes[0], sizes[1], frame, LINES), strict=False))
    for colour, line in lines:
        for (view, scale), segment in zip(views, line.segments, strict=True):
            _line(view, segment, scale, colour)
    for colour, line in lines:
        if line.points is not None:
            for (view, scale), point in zip(views, line.points, strict=True):
                _dot(view, point, scale, colour)


def _at(point: Any, scale: float) -> tuple[int, int]:
    """Pixel centres at integers, before and after scaling; in sixteenths of a pixel, for drawing."""
    x, y = (16 * ((np.asarray(point) + 0.5) * scale - 0.5)).round().astype(int)
    return int(x), int(y)


def _line(view: Image, segment: Array, scale: float, colour: tuple[int, int, int]) -> None:
    import cv2

    ends = _at(segment[0], scale), _at(segment[1], scale)
    cv2.line(view, *ends, (0, 0, 0), 4, cv2.LINE_AA, 4)
    cv2.line(view, *ends, colour, 2, cv2.LINE_AA, 4)


def _dot(view: Image, point: Array, scale: float, colour: tuple[int, int, int]) -> None:
    import cv2

    cv2.circle(view, _at(point, scale), 16 * 7, (0, 0, 0), -1, cv2.LINE_AA, 4)
    cv2.circle(view, _at(point, scale), 16 * 5, colour, -1, cv2.LINE_AA, 4)


def _text_band(width: int, texts: list[tuple[int, str]], heading: bool) -> Image:
    """White band with text: lines below each other in a heading, beside each other in a caption."""
    import cv2

    step = 26
    band = np.full((step * (len(texts) if heading else 1) + 14, width, 3), 255, np.uint8)
    for row, (x, text) in enumerate(texts):
        readable = text.encode("ascii", "replace").decode()  # OpenCV's letters are ASCII only
        baseline = 6 + step * (row + 1 if heading else 1)
        bold = 2 if heading and row == 0 else 1
        cv2.putText(
            band, readable, (x, baseline), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (20, 20, 20), bold, cv2.LINE_AA
        )
    return band
