"""Axes to draw on, and what lies under a drawing: a frame, or the silhouettes of one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array, Image
from ..calibration import Calibration
from ..errors import EpibarError
from ..recording import Recording
from ..show.colours import HEX

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "COLOURS",
    "DARK",
    "Image",
    "bare",
    "camera_name",
    "error_bar",
    "fundamental",
    "one_axes",
    "outline",
    "show_view",
    "two_axes",
]

DARK = "#222222"
# White, the last of them, does not show on paper.
COLOURS = [*HEX[:-1], "#9a9a9a"]
TICKS = [factor * 10.0**power for power in range(-4, 5) for factor in (1, 2, 5)]
WIDTH = 6.0
"""Inches of one view."""


def pyplot() -> Any:
    """Matplotlib's pyplot, imported late because it is slow and not everybody has it."""
    try:
        from matplotlib import pyplot as found
    except ImportError as error:
        raise EpibarError("matplotlib is missing, which draws figures: pip install 'epibar[plot]'") from error
    return found


def one_axes(ax: Axes | None, width: float = WIDTH, height: float = 0.6 * WIDTH) -> Axes:
    """Return the given Axes, or those of a new figure of a size in inches."""
    plt = pyplot()
    if ax is not None:
        return ax
    made: Axes = plt.subplots(figsize=(width, height), layout="constrained")[1]
    return made


def two_axes(ax: Sequence[Axes] | None, recordings: tuple[Recording, Recording]) -> tuple[Axes, Axes]:
    """Return the two given Axes, or those of a new figure with both views at one height."""
    plt = pyplot()
    if ax is not None:
        if len(ax) != 2:
            raise EpibarError(f"ax holds {len(ax)} Axes, expected two: one for each camera")
        return ax[0], ax[1]
    ratios = [recording.width / recording.height for recording in recordings]
    size = (2 * WIDTH, 2 * WIDTH / sum(ratios) + 0.4)
    made = plt.subplots(1, 2, figsize=size, layout="constrained", width_ratios=ratios)[1]
    return made[0], made[1]


def fundamental(calibration: Calibration) -> Array:
    """Return F of a calibration that has one."""
    if calibration.F is None:
        raise EpibarError(f"there is no F to draw: {calibration.reason}")
    return calibration.F


def camera_name(recording: Recording, index: int) -> str:
    """Return the name of a camera, for a title."""
    return recording.name or f"camera {'AB'[index]}"


def outline(width: float) -> list[Any]:
    """Make lines of a width stand out from whatever is below."""
    from matplotlib import patheffects

    return [patheffects.withStroke(linewidth=width + 1.4, foreground=DARK)]


def show_view(ax: Axes, recording: Recording, frame: int, image: Image | None = None) -> None:
    """Show an image of a camera, or else the silhouettes of a frame, in pixels of the recording.

    Raises
    ------
    EpibarError
        The image is not of the size of the recording.
    """
    width, height = recording.size
    if image is None:
        from matplotlib.collections import PolyCollection

        ax.set_facecolor("white")
        silhouettes = PolyCollection(
            recording.hulls(frame), facecolors="0.85", edgecolors="0.6", linewidths=0.8
        )
        ax.add_collection(silhouettes)
    else:
        if np.shape(image)[:2] != (height, width):
            found = "x".join(map(str, np.shape(image)[1::-1]))
            raise EpibarError(
                f"the image for {recording.name or 'a camera'} has {found} pixels, "
                f"but the recording {width}x{height}"
            )
        ax.imshow(image, cmap="gray" if np.ndim(image) == 2 else None)
    bare(ax, recording)


def error_bar(picture: Any, axes: Sequence[Axes], label: str, **options: Any) -> None:
    """Put a colour bar of errors in pixels, on a logarithmic scale, beside Axes."""
    low, high = picture.get_clim()
    bar = axes[0].figure.colorbar(picture, ax=list(axes), label=label, shrink=0.85, **options)
    bar.set_ticks([tick for tick in TICKS if low <= tick <= high])
    bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.minorticks_off()


def bare(ax: Axes, recording: Recording) -> None:
    """Set the limits to the image, y down, without ticks."""
    width, height = recording.size
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[], aspect="equal")
