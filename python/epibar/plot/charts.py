"""Figures of what a pair rests on: barcodes, the time-shift curve, residuals; and the matrix of all pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from ..arguments import Array, check_choice
from ..calibration import Calibration
from ..clocks import common_frames
from ..errors import EpibarError
from ..recording import Recording
from ..show.line_barcodes import WINDOW, LineSet, line_sets
from ..show.moments import busiest_window, points_per_frame
from .canvas import DARK, camera_name, error_bar, one_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["barcode_strips", "pair_matrix", "residual_histogram", "time_shift_curve"]

BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#9a9a9a"
STRIP, GAP = 0.42, 0.26
"""Heights of one barcode and of the space between two pairs of them."""
ERROR_RANGE = (0.05, 5.0)
"""Pixels, over which the shades of accepted pairs go."""
READABLE = 0.6
"""Pixels: the shades above are light."""


class Judged(Protocol):
    """What the matrix of pairs needs to know: a Calibration and an exported pair have it."""

    @property
    def accepted(self) -> bool:
        """Whether F passed every test."""

    @property
    def kind(self) -> str:
        """The verdict as one word."""

    @property
    def expected_error(self) -> float | None:
        """Pixels."""


def barcode_strips(
    calibration: Calibration,
    rec_a: Recording,
    rec_b: Recording,
    kind: Literal["epipolar", "matched"] = "matched",
    ax: Axes | None = None,
) -> Axes:
    """Draw the motion barcodes of matched lines below each other: the picture that explains the method.

    Parameters
    ----------
    calibration : Calibration
    rec_a, rec_b : Recording
        Of its two cameras.
    kind : {"epipolar", "matched"}
        Epipolar lines of F, or candidate pairs of lines as they were matched (those that F agrees with).
    ax : Axes, optional

    Returns
    -------
    Axes
        The 600 frames in which most happens. Lines are chosen by their barcodes in A alone.

    Raises
    ------
    EpibarError
        There are no such lines, or matplotlib is missing.
    """
    check_choice("kind", kind, ("epipolar", "matched"))
    common = common_frames(rec_a, rec_b, calibration)
    common = common[busiest_window(points_per_frame(common, rec_a, rec_b, calibration), WINDOW)]
    found = [
        lines
        for lines in line_sets(rec_a, rec_b, calibration, common)
        if (lines.kind == "epipolar") == (kind == "epipolar")
    ]
    if not found:
        raise EpibarError(f"there are no {kind} lines to draw: {calibration.reason}")
    lines = found[0]
    count = len(lines.bits_a)
    ax = one_axes(ax, width=9.0, height=0.8 + 0.42 * count)
    _draw_strips(ax, lines, int(common[0, 0]), int(common[-1, 0]) + 1)
    names = [camera_name(recording, index) for index, recording in enumerate((rec_a, rec_b))]
    title = "Epipolar lines" if kind == "epipolar" else "Matched lines"
    ax.set_title(f"{title}: is something moving on the line?", loc="left")
    for place, name, colour in ((0.86, names[0], BLUE), (0.99, names[1], ORANGE)):
        ax.annotate(
            name,
            (place, 1.0),
            (0, 5),
            "axes fraction",
            "offset points",
            color=colour,
            ha="right",
            va="bottom",
        )
    return ax


def _draw_strips(ax: Axes, lines: LineSet, first: int, last: int) -> None:
    """Draw each pair of barcodes, A above B, with its correlation at the end."""
    from matplotlib.colors import ListedColormap

    step = 2 * STRIP + GAP
    for row, pair in enumerate(zip(lines.bits_a, lines.bits_b, strict=True)):
        for below, (bits, colour) in enumerate(zip(pair, (BLUE, ORANGE), strict=True)):
            top = row * step + below * STRIP
            ax.imshow(
                bits[None],
                cmap=ListedColormap(["#f0f0f0", colour]),
                vmin=0,
                vmax=1,
                extent=(first - 0.5, last - 0.5, top + STRIP, top),
                aspect="auto",
                interpolation="nearest",
            )
        correlation = lines.correlation[row]
        text = f"r = {correlation:.2f}" if np.isfinite(correlation) else "r = –"
        ax.annotate(
            text,
            (1.0, row * step + STRIP),
            (6, 0),
            ("axes fraction", "data"),
            "offset points",
            va="center",
        )
    count = len(lines.bits_a)
    ax.set(
        xlim=(first - 0.5, last - 0.5),
        ylim=(count * step - GAP, 0),
        yticks=[row * step + STRIP for row in range(count)],
        yticklabels=[str(row + 1) for row in range(count)],
        xlabel="frame",
        ylabel="pair of lines",
    )
    ax.tick_params(left=False)
    ax.spines[:].set_visible(False)


def time_shift_curve(calibration: Calibration, ax: Axes | None = None) -> Axes:
    """Draw the score of F with B's frames shifted: a true F has a sharp peak at no shift.

    Parameters
    ----------
    calibration : Calibration
    ax : Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    EpibarError
        The calibration has no such curve, or matplotlib is missing.
    """
    shifts, scores = calibration.shift_curve
    if not len(shifts):
        raise EpibarError(f"this calibration has no time-shift curve: {calibration.reason}")
    ax = one_axes(ax)
    own = int(np.argmin(np.abs(shifts)))
    ax.axhline(0, color=GREY, linewidth=0.8)
    ax.plot(np.delete(shifts, own), np.delete(scores, own), ".-", color=BLUE, linewidth=1, label="shifted")
    ax.vlines(shifts[own], 0, scores[own], color=ORANGE, linewidth=1.6)
    ax.plot(shifts[own], scores[own], "o", color=ORANGE, markersize=7, label="not shifted")
    ax.set(xlabel="shift of B, frames", ylabel="score of F", title="Score with the clocks shifted")
    return _with_legend(ax)


def residual_histogram(calibration: Calibration, ax: Axes | None = None) -> Axes:
    """Draw how far the frontier points lie from their epipolar lines, pixels.

    Parameters
    ----------
    calibration : Calibration
    ax : Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    EpibarError
        There are no frontier points, or matplotlib is missing.
    """
    residual = calibration.frontier_points.residual
    if not len(residual):
        raise EpibarError(f"this calibration has no frontier points: {calibration.reason}")
    ax = one_axes(ax)
    ax.hist(
        residual, bins=min(60, max(10, len(residual) // 25)), color=BLUE, edgecolor="white", linewidth=0.4
    )
    middle = float(np.median(residual))
    ax.axvline(middle, color=ORANGE, linewidth=1.6, label=f"median {middle:.2g} px")
    ax.set(
        xlabel="symmetric epipolar distance, px",
        ylabel="frontier points",
        title=f"Residuals of {len(residual):,} frontier points",
        xlim=(0, None),
    )
    return _with_legend(ax)


def _with_legend(ax: Axes) -> Axes:
    """Finish a chart of curves: a legend, and axes at the left and below only."""
    ax.legend(frameon=False)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def pair_matrix(
    names: Sequence[str], pairs: Mapping[tuple[str, str], Judged], ax: Axes | None = None
) -> Axes:
    """Draw all pairs of cameras, coloured by verdict and expected error.

    Parameters
    ----------
    names : sequence of str
        Of the cameras, in order.
    pairs : mapping of (str, str) to Calibration
        What was found for two cameras; whatever has ``accepted``, ``kind`` and ``expected_error``.
    ax : Axes, optional

    Returns
    -------
    Axes

    Raises
    ------
    EpibarError
        A pair of a camera that is not in ``names``, or matplotlib is missing.
    """
    places = {name: place for place, name in enumerate(names)}
    for pair in pairs:
        if len(pair) != 2 or not set(pair) <= places.keys():
            raise EpibarError(f"pairs have key {pair!r}: expected two of {', '.join(names)}")
    count = len(names)
    ax = one_axes(ax, width=1.8 + 1.1 * count, height=1.2 + 0.95 * count)
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Rectangle

    errors: Array = np.full((count, count), np.nan)
    for (a, b), judged in pairs.items():
        row, column = sorted((places[a], places[b]))
        if judged.accepted:
            errors[row, column] = max(judged.expected_error or 0.0, 1e-9)
            text = "accepted" if judged.expected_error is None else f"{judged.expected_error:.2g} px"
        else:
            ax.add_patch(
                Rectangle(
                    (column - 0.5, row - 0.5), 1, 1, facecolor="#f6dfd0", hatch="///", edgecolor="#e3b899"
                )
            )
            text = judged.kind.replace("_", "\n")
        dim = judged.accepted and not errors[row, column] > READABLE
        size, colour = (10 if judged.accepted else 8), ("white" if dim else DARK)
        ax.text(column, row, text, ha="center", va="center", size=size, color=colour)
    picture = ax.imshow(errors, cmap="viridis", norm=LogNorm(*ERROR_RANGE), aspect="auto")
    error_bar(picture, [ax], "expected error of accepted pairs, px", extend="both")
    ax.set(
        xticks=range(1, count),
        yticks=range(count - 1),
        xticklabels=names[1:],
        yticklabels=names[:-1],
        xlim=(0.5, count - 0.5),
        ylim=(count - 1.5, -0.5),
    )
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    return ax
