"""What one recording is good for, before any pairing: :func:`inspect`.

How much moved and where, how many lines are left after each filter, whether the camera stood still and the
light stayed on, and, in plain English, what is wrong and what to do about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .camera_health import FLOOD_SHARE
from .errors import EpibarError
from .evaluation import area_between_lines
from .findings import Finding, camera_findings, motion_findings
from .recording import Recording

__all__ = ["Diagnosis", "cause_of_refusal", "inspect"]

Array = NDArray[np.float64]

INFORMATIVE_SHARE = 0.05
INFORMATIVE_CHANGES, FRAMES_PER_CHANGE = 8, 25
"""What the compiled matcher asks of a line: motion in 5 % of the frames, none in 5 %, eight changes, or one
in 25 frames where the recording is short."""
PATH_OVERLAP = 3.0
"""Image widths: an area between two lines below this means that one runs along the other (paper, 3.2)."""
MOST_MOTION = 0.95
ROWS_AT_ONCE = 2000
LEAST_SILHOUETTES = 50
SHORTEST_PATH = 0.2
"""Of the image diagonal; on a shorter way nothing can be said."""
PATH_TRIMMED = 0.9
HEADS_SLACK = 3.0
"""People differ in height, so heads on one path stray more than feet do."""
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
        content = {**asdict(self), "where": self.where.tolist(), "sound": self.sound}
        return {key: _plain(value) for key, value in content.items()}

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


def inspect(recording: Recording) -> Diagnosis:
    """Tell what a recording is good for, before it is paired with another.

    Parameters
    ----------
    recording : Recording
        From :func:`epibar.record`, a file or masks. Without images, as for masks, nothing can be said about
        the camera and the light.

    Returns
    -------
    Diagnosis
        ``print`` it, or read ``findings``.

    Raises
    ------
    EpibarError
        The argument is no recording.

    Examples
    --------
    >>> import epibar
    >>> print(epibar.inspect(epibar.Recording.load("cam1.npz")))  # doctest: +SKIP
    """
    if not isinstance(recording, Recording):
        raise EpibarError(
            f"recording is a {type(recording).__name__}, expected a Recording, e.g. from epibar.record"
        )
    width, height = recording.size
    moving = recording.moving_pixels.astype(np.int64)
    heat = recording.heat.astype(np.float64)
    arrays = recording._core.to_arrays()
    lines, paths = _lines(recording, arrays)
    blanked = recording.health.get("blanked", 0.0)
    flooded = blanked + np.count_nonzero(moving > FLOOD_SHARE * width * height)
    diagnosis = Diagnosis(
        name=recording.name,
        size=recording.size,
        frames=recording.frames,
        seconds=float(recording.times[-1] - recording.times[0]),
        moving_frames=float(np.mean(moving > 0)),
        flooded_frames=float(flooded / recording.frames),
        moving_area=float(np.median(moving[moving > 0]) / (width * height)) if moving.any() else 0.0,
        spread=_spread(heat),
        where=_where(heat),
        lines=lines,
        paths=paths,
        straightness=_straightness(arrays, (width, height)),
        silhouettes=len(arrays["hull_area"]),
        cut=float(arrays["hull_border"].mean()) if len(arrays["hull_border"]) else 0.0,
        health=recording.health,
    )
    found = [*camera_findings(recording.health), *motion_findings(diagnosis)]
    found.sort(key=lambda finding: not finding.serious)
    return replace(diagnosis, findings=tuple(found))


def cause_of_refusal(kind: str, rec_a: Recording, rec_b: Recording) -> str | None:
    """Say what in either camera may be why a pair was refused.

    Parameters
    ----------
    kind : str
        The verdict's.
    rec_a, rec_b : Recording
        Of the two cameras.

    Returns
    -------
    str or None
        One sentence that names the camera; None where the pair was accepted or both cameras are sound.
    """
    if kind == "accepted":
        return None
    told = []
    for recording, side in ((rec_a, "camera A"), (rec_b, "camera B")):
        serious = [finding for finding in inspect(recording).findings if finding.serious]
        if serious:
            told.append(f"in {recording.name or side} {serious[0].text}")
    return f"A possible cause: {'. And '.join(told)}." if told else None


def _lines(recording: Recording, arrays: Mapping[str, NDArray[Any]]) -> tuple[dict[str, int], int]:
    """Count the lines left after each filter, and the straight paths."""
    frames = recording.frames
    least = max(1, int(np.ceil(INFORMATIVE_SHARE * frames)))
    changes_asked = min(INFORMATIVE_CHANGES, max(frames // FRAMES_PER_CHANGE, 1))
    packed = arrays["barcodes"]
    ones, changes = np.empty(len(packed), np.int64), np.empty(len(packed), np.int64)
    for start in range(0, len(packed), ROWS_AT_ONCE):
        rows = np.ascontiguousarray(packed[start : start + ROWS_AT_ONCE]).astype("<u8").view(np.uint8)
        bits = np.unpackbits(rows, axis=1, count=frames, bitorder="little")
        ones[start : start + len(bits)] = bits.sum(axis=1, dtype=np.int64)
        changes[start : start + len(bits)] = np.count_nonzero(bits[:, 1:] != bits[:, :-1], axis=1)
    crossed = ones >= least
    free = crossed & (frames - ones >= least)
    informative = free & (changes >= changes_asked)
    paths = _core.motion_lines(recording._core)
    off = informative.copy()
    for path in paths:
        lines = _through(arrays["segments"][off])
        apart = area_between_lines(lines, np.broadcast_to(path, lines.shape), recording.size)
        off[off] = np.asarray(apart) >= PATH_OVERLAP * recording.width
    counts = {"crossed": crossed, "free": free, "informative": informative, "off_paths": off}
    return {
        "drawn": len(packed),
        **{name: int(np.count_nonzero(kept)) for name, kept in counts.items()},
    }, len(paths)


def _through(segments: Array) -> Array:
    """Lines (a, b, c), a² + b² = 1, through segments (x0, y0, x1, y1)."""
    x0, y0, x1, y1 = segments.T
    lines = np.stack([y0 - y1, x1 - x0, x0 * y1 - x1 * y0], axis=1)
    lengths: Array = np.hypot(lines[:, 0], lines[:, 1])
    return lines / np.maximum(lengths, 1e-12)[:, None]


def _spread(heat: Array) -> float:
    """Least share of the pixels that hold most of the motion."""
    hottest = np.cumsum(np.sort(heat, axis=None)[::-1])
    if hottest[-1] == 0:
        return 0.0
    return float((np.searchsorted(hottest, MOST_MOTION * hottest[-1]) + 1) / heat.size)


def _where(heat: Array) -> Array:
    """Share of all motion in each ninth of the image."""
    ninths = [
        [part.sum() for part in np.array_split(rows, 3, axis=1)] for rows in np.array_split(heat, 3, axis=0)
    ]
    sums = np.array(ninths)
    shares: Array = sums / max(sums.sum(), 1.0)
    return shares


def _straightness(arrays: Mapping[str, NDArray[Any]], size: tuple[int, int]) -> float:
    """How far the lowest and highest points of the silhouettes stray from a straight line each, the larger.

    Feet on one path are on one line in the image, and so are heads. Heads alone are not enough: under a low
    camera they are on the horizon wherever people walk.
    """
    whole = ~np.asarray(arrays["hull_border"], dtype=bool)
    starts = arrays["hull_start"].astype(np.int64)
    if np.count_nonzero(whole) < LEAST_SILHOUETTES:
        return float("nan")
    points = arrays["hull_points"].astype(np.float64)
    diagonal = float(np.hypot(*size))
    strays = []
    for sign, slack in ((1.0, 1.0), (-1.0, HEADS_SLACK)):
        ends = _extremes(points, starts, sign)[whole]
        width, length = _band(ends)
        if length < SHORTEST_PATH * diagonal:
            return float("nan")
        strays.append(width / diagonal / slack)
    return max(strays)


def _extremes(points: Array, starts: NDArray[np.int64], sign: float) -> Array:
    """Lowest (sign 1) or highest (sign −1) vertex of each hull, (n, 2)."""
    hull = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    order = np.lexsort((-sign * points[:, 1], hull))
    return points[order[starts[:-1]]]


def _band(points: Array) -> tuple[float, float]:
    """Half width and length of the straight band that holds most of the points, (n, 2)."""
    kept = points
    for _ in range(6):
        centre = kept.mean(axis=0)
        axes = np.linalg.svd(kept - centre, full_matrices=False)[2]
        across = np.abs((points - centre) @ axes[1])
        width = float(np.quantile(across, PATH_TRIMMED))
        kept = points[across <= width]
    along = (points - centre) @ axes[0]
    return width, float(np.quantile(along, 0.95) - np.quantile(along, 0.05))


def _camera(health: Mapping[str, float]) -> str:
    """Say what was seen of the camera and the light."""
    if not health:
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


def _plain(value: Any) -> Any:
    """A value as JSON can hold it."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
