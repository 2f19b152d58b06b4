"""A picture of a pair: both views with matched epipolar lines in matching colours."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Array, Image, Size
from ..calibration import Calibration
from ..errors import EpibarError
from ..files.atomic import write_atomically
from ..recording import Recording
from ..show.colours import RGB
from ..show.matched_lines import frames_to_show, matched_lines
from ..sources.pictures import Pictures, decoded

__all__ = ["draw_pair", "write_pair_picture"]

PANEL_HEIGHT = 600
LINES = 8
MARGIN = 12
BGR = [colour[::-1] for colour in RGB]


def write_pair_picture(
    path: Path,
    names: tuple[str, str],
    pictures: tuple[Pictures | None, Pictures | None],
    recordings: tuple[Recording, Recording],
    calibration: Calibration,
) -> Path:
    """Draw a pair over pictures of one moment and write it as PNG.

    Parameters
    ----------
    path : Path
        The file to write.
    names : two of str
        Of the cameras.
    pictures : two of Pictures or None
        Of some frames of each. Silhouettes over the motion heat map take the place of one that is not there,
        e.g. because the source is a saved recording.
    recordings : two of Recording
    calibration : Calibration
        Of the pair.
    """
    import cv2

    kept = pictures[0] or Pictures(), pictures[1] or Pictures()
    frames = frames_to_show(recordings, calibration, kept)
    images, captions = [], []
    for name, frame, recording, taken in zip(names, frames, recordings, kept, strict=True):
        image = decoded(taken[frame]) if frame in taken else None
        captions.append(f"{name}, frame {frame}" + (", silhouettes" if image is None else ""))
        images.append(_silhouettes(recording, frame) if image is None else image)
    picture = draw_pair(
        (images[0], images[1]),
        (captions[0], captions[1]),
        calibration,
        frames[0],
        (recordings[0].size, recordings[1].size),
    )
    ok, data = cv2.imencode(".png", picture)
    if not ok:
        raise EpibarError(f"{path}: the picture cannot be encoded")
    write_atomically(path, lambda stream: stream.write(data.tobytes()))
    return path


def draw_pair(
    images: tuple[Image, Image],
    captions: tuple[str, str],
    calibration: Calibration,
    frame: int,
    sizes: tuple[Size, Size],
) -> Image:
    """Put two views side by side, with the verdict above and matched epipolar lines in matching colours.

    Parameters
    ----------
    images : two of ndarray, shape (H, W, 3), uint8
        Blue, green, red; of any resolution.
    captions : two of str
        Below the views.
    calibration : Calibration
        Of the pair.
    frame : int
        Frame of A that is shown; its frontier points come first and are marked.
    sizes : two of (int, int)
        Width and height of the frames, whose pixels the calibration is in.
    """
    views = [_scaled(image, size) for image, size in zip(images, sizes, strict=True)]
    if calibration.F is not None:
        _draw_lines(views, sizes, calibration, frame)
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


def _silhouettes(recording: Recording, frame: int) -> Image:
    """Outlines of what moved in a frame over the motion heat map."""
    import cv2

    heat = np.sqrt(recording.heat / max(1, int(recording.heat.max())))
    image: Image = cv2.applyColorMap((255 * heat).astype(np.uint8), cv2.COLORMAP_INFERNO)  # type: ignore[assignment]
    thick = max(1, round(recording.height / 400))
    for hull in recording.hulls(frame):
        cv2.polylines(image, [hull.round().astype(np.int32)], True, (255, 255, 255), thick, cv2.LINE_AA)
    return image


def _scaled(image: Image, size: Size) -> tuple[Image, float]:
    """Scale the image of a frame of ``size`` to the height of a panel; also returns the frame's factor."""
    import cv2

    scale = PANEL_HEIGHT / size[1]
    panel = (max(1, round(size[0] * scale)), PANEL_HEIGHT)
    method = cv2.INTER_AREA if image.shape[0] > PANEL_HEIGHT else cv2.INTER_LINEAR
    return cv2.resize(image, panel, interpolation=method), scale  # type: ignore[return-value]


def _draw_lines(
    views: list[tuple[Image, float]], sizes: tuple[Size, Size], calibration: Calibration, frame: int
) -> None:
    """Draw the epipolar lines of a few points, and the points of the frame that is shown."""
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
