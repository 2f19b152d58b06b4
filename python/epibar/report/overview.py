"""The part of the page that needs no scripts: summary, errors, cameras, the matrix of pairs."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import pairwise
from pathlib import PurePath

from .. import _core
from ..errors import address_without_secrets, is_address
from ..geometry.lines import clip_lines
from ..network.parts import NetworkParts
from .inputs import ReportCamera, ReportPair
from .pictures import data_url
from .prose import verdict_prose

__all__ = ["camera_cards", "error_list", "legend", "matrix", "summary"]

LEVELS = (0.5, 1.0, 2.0)
"""Pixels: borders between the shades of accepted pairs."""


def summary(
    cameras: Sequence[ReportCamera],
    pairs: Sequence[ReportPair],
    errors: Sequence[str],
    network: NetworkParts | None = None,
) -> str:
    """Say in one line what is in the report."""
    accepted = sum(pair.calibration.accepted for pair in pairs)
    if network is None:
        parts = [
            _count(len(cameras), "camera"),
            _count(len(pairs), "pair"),
            f"{accepted} accepted",
            f"{len(pairs) - accepted} refused",
        ]
    else:
        standing = sum(camera.accepted for camera in network.cameras.values())
        parts = [
            f"{standing} of {_count(len(network.cameras), 'camera')} accepted",
            f"{accepted} of {_count(len(pairs), 'pair')} also each by itself",
        ]
    if errors:
        parts.append(_count(len(errors), "error"))
    return " · ".join(parts)


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


def error_list(errors: Sequence[str]) -> str:
    """List what could not be done."""
    if not errors:
        return ""
    items = "".join(f"<li>{escape(error)}</li>" for error in errors)
    heading = "<h2>Not everything could be done</h2>"
    return f'<section class="errors" role="alert">{heading}<ul>{items}</ul></section>'


def camera_cards(cameras: Sequence[ReportCamera], pictures: Sequence[bytes]) -> str:
    """Show each camera: heat map with motion lines, what was read, warnings."""
    cards = (_card(camera, picture) for camera, picture in zip(cameras, pictures, strict=True))
    return f'<ul class="cameras">{"".join(cards)}</ul>'


def _card(camera: ReportCamera, picture: bytes) -> str:
    recording = camera.recording
    width, height = recording.size
    lines = _core.motion_lines(recording._core)
    segments = clip_lines(lines, recording.size)[0].tolist() if len(lines) else []
    drawn = "".join(
        f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"/>' for (x0, y0), (x1, y1) in segments
    )
    label = f"Motion heat map of {camera.name}, {_count(len(lines), 'motion line')}"
    total = len(recording.segments)
    informative = (
        f"{recording.informative:,} of {total:,} lines ({recording.informative / max(1, total):.0%})"
    )
    length = float(recording.times[-1]) if recording.frames else 0.0
    source = "" if camera.source is None else address_without_secrets(camera.source)
    source = source if is_address(source) else PurePath(source).name
    facts = [
        ("frames", f"{recording.frames:,} ({length:.0f} s)"),
        ("size", f"{width} × {height}" + (", undistorted" if recording.matrix is not None else "")),
        ("informative", informative),
        *([("from", source + (" (masks)" if camera.masks else ""))] if source else []),
    ]
    rows = "".join(f"<dt>{escape(key)}</dt><dd>{escape(value)}</dd>" for key, value in facts)
    warnings = "".join(f"<li>{escape(text)}</li>" for text in recording.warnings)
    return (
        f'<li class="camera"><svg viewBox="-0.5 -0.5 {width} {height}" role="img" '
        f'aria-label="{escape(label)}"><image x="-0.5" y="-0.5" width="{width}" height="{height}" '
        f'preserveAspectRatio="none" href="{data_url(picture)}"/><g class="motion">{drawn}</g></svg>'
        f"<h3>{escape(camera.name)}</h3><dl>{rows}</dl>"
        + (f'<ul class="warnings" aria-label="Warnings">{warnings}</ul>' if warnings else "")
        + "</li>"
    )


def matrix(cameras: Sequence[ReportCamera], pairs: Sequence[ReportPair]) -> str:
    """Draw the table of pairs: row A, column B, each cell a link to its pair."""
    known = {(pair.a, pair.b): index for index, pair in enumerate(pairs)}
    names = [camera.name for camera in cameras]
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in names[1:])
    rows = []
    for row, a in enumerate(names[:-1]):
        cells = []
        for column, b in enumerate(names[1:], 1):
            index = known.get((a, b), known.get((b, a)))
            if column <= row:
                cells.append("<td></td>")
            elif index is None:
                cells.append('<td class="missing"><span>not done</span></td>')
            else:
                cells.append(f"<td>{_cell(pairs[index], index)}</td>")
        rows.append(f'<tr><th scope="row">{escape(a)}</th>{"".join(cells)}</tr>')
    return (
        '<div class="scroll"><table class="matrix"><caption class="hidden">Verdict of each pair</caption>'
        f"<thead><tr><td></td>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _cell(pair: ReportPair, index: int) -> str:
    calibration = pair.calibration
    verdict, error = verdict_prose(calibration), calibration.expected_error
    shown = "" if error is None else f"{error:.2f} px"
    if calibration.accepted:
        look, lines = f"accepted level{_level(error)}", ("✓ " + (shown or "accepted"), "accepted")
    else:
        look, lines = "refused", ("✕ refused", verdict.lower())
    label = f"{pair.a} and {pair.b}: {verdict}" + (f", expected error {shown}" if shown else "")
    return (
        f'<a class="cell {look}" href="#pair-{index + 1}" aria-label="{escape(label)}">'
        f"<strong>{escape(lines[0])}</strong><small>{escape(lines[1])}</small></a>"
    )


def _level(error: float | None) -> int:
    return sum(error >= border for border in LEVELS) if error is not None else len(LEVELS)


def legend() -> str:
    """Explain the colours of the matrix."""
    labels = [
        f"< {LEVELS[0]:g}",
        *(f"{low:g}–{high:g}" for low, high in pairwise(LEVELS)),
    ]
    labels.append(f"≥ {LEVELS[-1]:g}")
    items = "".join(
        f'<li><i class="accepted level{level}"></i>{escape(text)}</li>' for level, text in enumerate(labels)
    )
    return (
        f'<ul class="legend"><li>Expected error, px:</li>{items}<li><i class="refused"></i>refused</li></ul>'
    )
