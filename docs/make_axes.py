"""Draw ``docs/axes.svg``: the axes of the world, of a camera of OpenCV and of one of OpenGL.

Run ``.venv/bin/python docs/make_axes.py`` from the root of the repository, after ``make build``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from epibar.camera_export.shapes import frustum
from epibar.geometry.cameras import opengl_pose
from epibar.lens import Intrinsics

TARGET = Path(__file__).parent / "axes.svg"
COLOURS = {"x": "#d1403f", "y": "#2f9e58", "z": "#3f7fd1"}
GREY = "#8a8a8a"
"""Legible on white and on black."""
WIDTH, HEIGHT, SCALE = 780, 320, 62
TURN, TILT = np.radians((-18, 22))
VIEW = np.array(
    [
        [np.cos(TURN), -np.sin(TURN), 0.0],
        [-np.sin(TILT) * np.sin(TURN), -np.sin(TILT) * np.cos(TURN), -np.cos(TILT)],
    ]
)
"""World to picture: x to the right, y away, z up; from above."""
PLACES = {"OpenCV": (3.0, 0.9, 1.7), "OpenGL, glTF": (8.0, 0.9, 1.7)}
AFTER_HEAD, BASELINE = 14, 5
"""Pixels from the head of an arrow to the middle of its name, and from there down to its baseline."""
LOOKS_ALONG = np.array([0.9, 0.6, -0.35])


def picture(points: object) -> np.ndarray:
    """Project world points to the picture, (n, 2)."""
    return np.atleast_2d(np.asarray(points, float)) @ VIEW.T * SCALE + (95, 215)


def camera(place: tuple[float, float, float]) -> Intrinsics:
    """Return a camera that stands there."""
    import cv2

    ahead = LOOKS_ALONG / np.linalg.norm(LOOKS_ALONG)
    right = np.cross(ahead, (0, 0, 1))
    right /= np.linalg.norm(right)
    R = np.array([right, np.cross(ahead, right), ahead])
    K = [[500.0, 0, 319.5], [0, 500.0, 239.5], [0, 0, 1]]
    return Intrinsics("", (640, 480), K, rotation=cv2.Rodrigues(R)[0].ravel(), translation=-R @ place)


def line(start: object, end: object, colour: str, width: float, arrow: str = "") -> str:
    """One segment between world points."""
    (x0, y0), (x1, y1) = picture([start, end])
    head = f' marker-end="url(#{arrow})"' if arrow else ""
    return f'<path d="M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}" stroke="{colour}" stroke-width="{width}"{head}/>'


def text(place: object, words: str, colour: str = GREY, size: int = 15) -> str:
    """Words at a world point."""
    x, y = picture(place)[0]
    look = f'fill="{colour}" font-size="{size}" text-anchor="middle"'
    return f'<text x="{x:.1f}" y="{y:.1f}" {look}>{words}</text>'


def beyond(start: object, end: object, words: str, colour: str) -> str:
    """Words behind the head of an arrow between world points, on the side that it points to."""
    (x0, y0), (x1, y1) = picture([start, end])
    along = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
    x, y = (x1, y1) + AFTER_HEAD * along + (0, BASELINE)
    anchor = "middle" if abs(along[0]) < 0.6 else "start" if along[0] > 0 else "end"
    look = f'fill="{colour}" font-size="15" text-anchor="{anchor}"'
    return f'<text x="{x:.1f}" y="{y:.1f}" {look}>{words}</text>'


def axes(place: np.ndarray, columns: np.ndarray, names: tuple[str, str, str]) -> list[str]:
    """Draw three arrows with their names."""
    parts = []
    for axis, name, direction in zip("xyz", names, columns.T, strict=True):
        parts.append(line(place, place + direction, COLOURS[axis], 3, axis))
        parts.append(beyond(place, place + direction, name, COLOURS[axis]))
    return parts


def main() -> None:
    """Write the picture."""
    parts = []
    for k in range(-1, 11):
        parts.append(line((k, -1, 0), (k, 3, 0), GREY, 0.5))
    parts += [line((-1, k, 0), (10, k, 0), GREY, 0.5) for k in range(-1, 4)]
    parts += axes(np.zeros(3), 1.3 * np.eye(3), ("x", "y", "z up"))
    parts.append(text((1.0, -0.7, -0.75), "world: z = 0 is the floor"))
    for name, names in (
        ("OpenCV", ("x right", "y down", "z forward")),
        ("OpenGL, glTF", ("x right", "y up", "z back")),
    ):
        place = np.array(PLACES[name])
        one = camera(PLACES[name])
        pose = one.posed()
        for start, end in frustum(one, 1.6) @ pose.R + place:
            parts.append(line(start, end, GREY, 1))
        parts.append(line(place, place * (1, 1, 0), GREY, 1))
        columns = pose.R.T if name == "OpenCV" else opengl_pose(pose)[0]
        parts += axes(place, 1.1 * columns, names)
        parts.append(text((place[0], place[1], -0.75), f"camera: {name}"))
    heads = "".join(
        f'<marker id="{axis}" viewBox="0 0 8 8" refX="5" refY="4" markerWidth="4" markerHeight="4" '
        f'orient="auto"><path d="M0 0L8 4L0 8z" fill="{colour}"/></marker>'
        for axis, colour in COLOURS.items()
    )
    body = "\n".join(parts)
    TARGET.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif">\n'
        f"<title>Axes of the world and of cameras</title>\n<defs>{heads}</defs>\n{body}\n</svg>\n"
    )


if __name__ == "__main__":
    main()
