"""Figures in the pixels of the cameras: epipolar lines, frontier points, motion, expected error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from .. import _core
from ..arguments import as_whole_number, check_choice
from ..calibration import Calibration
from ..clocks import nearest_frame, positions_in_b
from ..errors import EpibarError
from ..geometry.lines import clip_lines
from ..recording import Recording
from ..show.matched_lines import frames_to_show, matched_lines
from .canvas import (
    COLOURS,
    DARK,
    Image,
    bare,
    camera_name,
    error_bar,
    fundamental,
    one_axes,
    outline,
    show_view,
    two_axes,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["epipolar_lines", "expected_error_map", "frontier_points", "heat_map"]

Images = tuple[Image | None, Image | None]


def epipolar_lines(
    calibration: Calibration,
    rec_a: Recording,
    rec_b: Recording,
    frame: int | None = None,
    images: Images = (None, None),
    ax: Sequence[Axes] | None = None,
) -> tuple[Axes, Axes]:
    """Draw matched epipolar lines of both views in matching colours, with the frontier points of the frame.

    Parameters
    ----------
    calibration : Calibration
        With an F.
    rec_a, rec_b : Recording
        Of its two cameras.
    frame : int, optional
        Frame of A; by default the one with the most frontier points. B's is that of the same moment.
    images : two of ndarray, shape (H, W, 3) or (H, W), uint8, or None
        Frames to draw on: red, green, blue, or grey; undistorted where the recordings are. Without them the
        silhouettes are drawn.
    ax : two Axes, optional
        By default those of a new figure.

    Returns
    -------
    two Axes

    Raises
    ------
    EpibarError
        There is no F or no such frame, an image is of another size, or matplotlib is missing.
    """
    fundamental(calibration)
    recordings = rec_a, rec_b
    axes = two_axes(ax, recordings)
    shown = (
        frames_to_show(recordings, calibration) if frame is None else _moment(calibration, frame, recordings)
    )
    for index, (view, recording) in enumerate(zip(axes, recordings, strict=True)):
        show_view(view, recording, shown[index], images[index])
        view.set_title(f"{camera_name(recording, index)}, frame {shown[index]}")
    lines = matched_lines(calibration, rec_a.size, rec_b.size, shown[0], len(COLOURS))
    for colour, line in zip(COLOURS, lines, strict=False):
        for index, view in enumerate(axes):
            effects = outline(1.8)
            view.plot(*line.segments[index].T, color=colour, linewidth=1.8, path_effects=effects)
            if line.points is not None:
                x, y = line.points[index]
                view.plot(x, y, "o", color=colour, markersize=6.5, markeredgecolor=DARK, zorder=3)
    return axes


def _moment(calibration: Calibration, frame: int, recordings: tuple[Recording, Recording]) -> tuple[int, int]:
    """Frame of A, and B's of the same moment."""
    frame = as_whole_number("frame", frame, 0, recordings[0].frames - 1)
    position = positions_in_b(*recordings, calibration)[frame]
    if not np.isfinite(position):
        raise EpibarError(f"frame = {frame}: camera B has no frame of that moment")
    return frame, int(nearest_frame(position))


def frontier_points(
    calibration: Calibration,
    rec_a: Recording,
    rec_b: Recording,
    colour: Literal["frame", "residual"] = "frame",
    images: Images = (None, None),
    ax: Sequence[Axes] | None = None,
) -> tuple[Axes, Axes]:
    """Draw the frontier points of all frames in both views.

    Parameters
    ----------
    calibration : Calibration
    rec_a, rec_b : Recording
        Of its two cameras.
    colour : {"frame", "residual"}
        What the colour of a point says: its moment, so that corresponding points look alike; or how far it
        is from its epipolar line, pixels.
    images : two of ndarray or None
        To draw on, see :func:`epipolar_lines`; by default nothing.
    ax : two Axes, optional

    Returns
    -------
    two Axes

    Raises
    ------
    EpibarError
        An image is of another size, an argument is wrong, or matplotlib is missing.
    """
    points = calibration.frontier_points
    check_choice("colour", colour, ("frame", "residual"))
    axes = two_axes(ax, (rec_a, rec_b))
    value = points.frame if colour == "frame" else points.residual
    limits = (value.min(), value.max()) if len(points) else (0, 1)
    if colour == "residual" and len(points):
        limits = 0.0, float(np.percentile(value, 98))
    for index, (view, recording) in enumerate(zip(axes, (rec_a, rec_b), strict=True)):
        if images[index] is None:
            bare(view, recording)
        else:
            show_view(view, recording, 0, images[index])
        x, y = (points.a, points.b)[index].T
        dots = view.scatter(
            x,
            y,
            c=value,
            s=5,
            cmap="viridis" if colour == "frame" else "plasma",
            vmin=limits[0],
            vmax=limits[1],
            linewidths=0,
            rasterized=True,
        )
        view.set_title(f"{camera_name(recording, index)}, {len(points):,} frontier points")
    if len(points):
        label = "frame" if colour == "frame" else "symmetric epipolar distance, px"
        axes[0].figure.colorbar(dots, ax=list(axes), label=label, shrink=0.85, pad=0.01)
    return axes


def heat_map(recording: Recording, motion_lines: bool = True, ax: Axes | None = None) -> Axes:
    """Draw where and how often something moved, with the straight paths of heavy traffic.

    Parameters
    ----------
    recording : Recording
    motion_lines : bool
        Draw the paths: candidates along them on both sides are not used, for they match without being
        epipolar.
    ax : Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    EpibarError
        Matplotlib is missing.
    """
    width, height = recording.size
    ax = one_axes(ax, height=6.0 * height / width)
    from matplotlib.colors import PowerNorm

    share = recording.heat / max(1, recording.frames)
    norm = PowerNorm(0.5, 0, max(float(share.max()), 1e-9))
    picture = ax.imshow(share, cmap="inferno", norm=norm)
    ax.figure.colorbar(picture, ax=ax, label="share of frames with motion", shrink=0.85, pad=0.015)
    lines = _core.motion_lines(recording._core) if motion_lines else np.empty((0, 3))
    for segment in clip_lines(lines, recording.size)[0] if len(lines) else ():
        ax.plot(*segment.T, color="#56b4e9", linewidth=1.5, linestyle=(0, (5, 3)))
    bare(ax, recording)
    count = f", {len(lines) or 'no'} motion line{'' if len(lines) == 1 else 's'}" if motion_lines else ""
    ax.set_title(f"{recording.name or 'motion'}{count}")
    return ax


def expected_error_map(
    calibration: Calibration, rec_a: Recording, rec_b: Recording, ax: Sequence[Axes] | None = None
) -> tuple[Axes, Axes]:
    """Draw the expected error over both images: F is known well where things moved, and less so elsewhere.

    Parameters
    ----------
    calibration : Calibration
        With ``error_maps``.
    rec_a, rec_b : Recording
        Of its two cameras.
    ax : two Axes, optional

    Returns
    -------
    two Axes

    Raises
    ------
    EpibarError
        The calibration has no error maps, or matplotlib is missing.
    """
    maps = calibration.error_maps
    if maps is None:
        raise EpibarError(f"this calibration has no map of expected errors: {calibration.reason}")
    axes = two_axes(ax, (rec_a, rec_b))
    from matplotlib.colors import LogNorm

    known = np.concatenate([np.ravel(values)[np.isfinite(np.ravel(values))] for values in maps])
    known = known[known > 0]
    if not len(known):
        raise EpibarError("the map of expected errors holds no positive number")
    norm = LogNorm(*np.percentile(known, (1, 99)) * (0.999, 1.001))
    for index, (view, recording) in enumerate(zip(axes, (rec_a, rec_b), strict=True)):
        width, height = recording.size
        picture = view.imshow(
            maps[index], cmap="viridis_r", norm=norm, extent=(-0.5, width - 0.5, height - 0.5, -0.5)
        )
        bare(view, recording)
        view.set_title(camera_name(recording, index))
    error_bar(picture, axes, "expected error, px", pad=0.01, extend="both")
    return axes
