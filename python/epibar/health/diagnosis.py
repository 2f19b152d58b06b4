"""All that :func:`epibar.inspect` says about one camera, as a value and as text.

How much moved and where, how many lines are left after each filter, whether the camera stood still and the
light stayed on, and, in plain English, what is wrong and what to do about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..arguments import Array
from ..files.json_values import plain
from .camera_findings import is_counted
from .finding import Finding

__all__ = ["Diagnosis"]

PLACES = (
    ("top left", "top", "top right"),
    ("left", "middle", "right"),
    ("bottom left", "bottom", "bottom right"),
)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is known about one camera.

    Attributes
    ----------
    name : str
        Of the camera.
    size : (int, int)
        Width and height, pixels.
    frames : int
        Number of frames.
    seconds : float
        From the first to the last.
    moving_frames : float
        Share of the frames in which something moves.
    flooded_frames : float
        Share of the frames left out, or of no use, because more than 60 % of the image changed.
    moving_area : float
        Share of the image that moves, the median over those frames.
    spread : float
        Least share of the image that holds 95 % of all motion.
    where : ndarray, shape (3, 3)
        Share of all motion in each ninth of the image, rows from the top.
    lines : dict of str to int
        Lines left after each filter, in order: ``drawn``; ``crossed`` by motion in at least 5 % of the
        frames; ``free`` of it in at least 5 %; ``informative``, changing often enough; ``off_paths``, not
        along a straight path with heavy traffic.
    paths : int
        Straight paths with heavy traffic.
    straightness : float
        How far what moves strays from one straight path, as a share of the image diagonal; NaN where too
        little moves to say.
    silhouettes : int
        Over all frames.
    cut : float
        Share of them that the border of the image cuts, or the edge of what is visible in it.
    health : dict of str to float
        What was counted while the video was watched; empty for ready masks.
    findings : tuple of Finding
        What is wrong and what to do, the serious first.
    """

    name: str
    size: tuple[int, int]
    frames: int
    seconds: float
    moving_frames: float
    flooded_frames: float
    moving_area: float
    spread: float
    where: Array
    lines: dict[str, int]
    paths: int
    straightness: float
    silhouettes: int
    cut: float
    health: dict[str, float]
    findings: tuple[Finding, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether nothing serious was found."""
        return not any(finding.serious for finding in self.findings)

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, lists and strings; what is not finite becomes None."""
        content: dict[str, Any] = plain({**asdict(self), "sound": self.sound})
        return content

    def __str__(self) -> str:
        """Describe the camera for a terminal."""
        width, height = self.size
        rate = (self.frames - 1) / self.seconds if self.seconds > 0 else 0.0
        rows = [
            f"{self.name or 'camera'}: {width}x{height}, {self.frames} frames, {self.seconds:.1f} s"
            + (f" at {rate:.4g} frames a second" if rate else ""),
            f"  motion    in {self.moving_frames:.0%} of the frames, over {_percent(self.moving_area)} of "
            f"the image at a time; 95 % of it on {_percent(self.spread)} of the image",
        ]
        if self.moving_frames > 0:
            row, column = np.unravel_index(int(self.where.argmax()), self.where.shape)
            cells = "\n".join(
                "            " + "".join(f"{100 * c:4.0f}" for c in line) for line in self.where
            )
            rows.append(f"  where     most in the {PLACES[row][column]}; per cent in each ninth:\n{cells}")
        rows.append(f"  objects   {self.silhouettes} silhouettes, {self.cut:.0%} cut by the border")
        kept = self.lines
        rows.append(
            f"  lines     {kept['drawn']} drawn, {kept['crossed']} crossed by motion often enough, "
            f"{kept['free']} free of it often enough,\n            {kept['informative']} informative"
            + (f", {kept['off_paths']} not along a straight path" if self.paths else "")
        )
        rows.append(f"  camera    {_camera(self.health)}")
        rows += [f"  {'PROBLEM' if f.serious else 'note   '}   {f.text}" for f in self.findings]
        if not self.findings:
            rows.append("  nothing wrong was found")
        return "\n".join(rows)


def _camera(health: Mapping[str, float]) -> str:
    """Say what was seen of the camera and the light."""
    if not is_counted(health):
        return "not known: masks or an older recording, no images were seen"
    if not health["motion_checks"]:
        stood = "its view has too little structure to tell whether it moved"
    elif health["moves"]:
        stood = "moved once" if health["moves"] == 1 else f"moved {health['moves']:.0f} times"
    else:
        stood = f"stood still, {health['motion_checks']:.0f} checks"
    return f"{stood}; the light flickers by {health['flicker']:.1f} of 255 grey levels"


def _percent(share: float) -> str:
    return f"{share:.1%}" if share < 0.1 else f"{share:.0%}"
