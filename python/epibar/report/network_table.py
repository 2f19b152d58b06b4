"""The network as prose: its verdict, and the table of its cameras; both need no scripts."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ..network.parts import BASELINE, NetworkCamera, NetworkClock, NetworkParts
from ..network.prose import network_notes, stated_errors
from .camera_angles import field_of_view, focal_length, tilt
from .space_payload import grid_step, magnification
from .walker_lines import Track

__all__ = ["VERDICTS", "camera_table", "network_section", "no_network_note"]

VERDICTS = {
    "accepted": "Accepted",
    "nothing_in_common": "Left out: nothing in common with the others",
    "apart": "Left out: a group of its own",
    "knocked": "Left out: knocked",
    "focal_length": "Left out: focal length open",
    "rotation": "Left out: direction open",
    "position": "Left out: position open",
    "ambiguous": "Left out: ambiguous",
    "clock": "Left out: its clock is not told",
    "contradicted": "Left out: what was given contradicts what moves",
    "no_baseline": "Left out: no baseline",
    "one_plane": "Left out: all keeps to one plane",
    "pair_refused": "Left out: its one pair was refused",
    "too_few": "Left out: too few cameras",
}
"""Verdict on a camera in a few words."""

HEADER = ("Camera", "Verdict", "Focal length", "Height", "Tilt", "Clock", "Stated errors")

UNKNOWN = "unknown"

CROWDED = 8
"""Of more cameras than this some names lie over others from most sides."""


def no_network_note(reason: str | None) -> str:
    """Say why there is no network."""
    return "" if reason is None else f'<p class="note no-network">No network: {escape(reason)}.</p>'


def network_section(network: NetworkParts, tracks: Sequence[Track]) -> str:
    """Verdict, room for the view in space, table."""
    accepted, count = sum(camera.accepted for camera in network.cameras.values()), len(network.cameras)
    if accepted == count:
        look, word = "accepted", f"✓ {_sentence(network.reason).removesuffix('.')}"
    elif accepted:
        look, word = "partial", f"{accepted} of {count} cameras accepted, the others left out"
    else:
        look, word = "refused", "✕ Refused: no camera accepted"
    # Of a whole network the reason says no more than that it is one.
    reason = "" if accepted == count else f"<p>{escape(_sentence(network.reason))}</p>"
    notes = [note for note in network_notes(network) if not _is_of_a_camera(network, note)]
    items = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return (
        '<section class="network" aria-labelledby="network-title">'
        f'<h2 id="network-title" class="hidden">Network</h2><div class="verdict {look}"><div>'
        f'<p class="word">{escape(word)}</p>{reason}'
        f'<ul class="network-notes">{items}</ul></div></div>'
        f'<div class="card space-card"><div id="space" hidden></div>'
        f'<p class="caption">{escape(_caption(network, tracks))}</p></div>'
        f'<div class="card"><h3>Cameras</h3>{camera_table(network)}'
        '<p class="caption">True errors are below the stated ones nine times in ten. Tilt: how far it looks '
        "down. Clock: what is at t seconds in the first camera is at t + offset here.</p></div></section>"
    )


def _is_of_a_camera(network: NetworkParts, note: str) -> bool:
    """Whether a note is on one camera that is left out, which the table says."""
    return any(
        note == f"{name}: {camera.reason}" for name, camera in network.cameras.items() if not camera.accepted
    )


def _sentence(text: str) -> str:
    text = text[:1].upper() + text[1:]
    return text if text.endswith(".") else text + "."


def _caption(network: NetworkParts, tracks: Sequence[Track]) -> str:
    """Say what the view in space shows."""
    step, enlarged = f"{grid_step(network, tracks):g}", magnification(network)
    standing = [name for name, camera in network.cameras.items() if camera.position is not None]
    if network.unit != BASELINE:
        step += " m"
    elif len(standing) > 1:
        step += f" of the distance between {standing[0]} and {standing[1]}"
    sentences = [f"A cell of the grid is {step} wide."]
    if network.ground.source != "floor":
        sentences.append("No floor was found: the grid lies below all cameras.")
    sentences.append("The thick edge of a camera's image is its upper one.")
    sentences.append(
        "Ellipsoids: each holds the true position nine times in ten"
        + (f"; {enlarged:g} times enlarged." if enlarged > 1 else ".")
    )
    if tracks:
        sentences.append("Thin coloured lines: where people walked.")
    if len(standing) > CROWDED:
        sentences.append("Names that would lie over others are left out; the row of a camera shows its own.")
    return " ".join(sentences)


def camera_table(network: NetworkParts) -> str:
    """Write a row for each camera; on narrow screens each becomes a block."""
    head = "".join(f'<th scope="col">{text}</th>' for text in HEADER)
    unit = "" if network.unit == BASELINE else " m"
    floor = network.ground.source == "floor"
    rows = "".join(
        _row(camera, network.clocks[name], unit, floor) for name, camera in network.cameras.items()
    )
    return (
        '<div class="scroll"><table class="numbers network-cameras"><caption class="hidden">Cameras of the '
        f"network</caption><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _row(camera: NetworkCamera, clock: NetworkClock, unit: str, floor: bool) -> str:
    look, mark = ("accepted", "✓") if camera.accepted else ("refused", "✕")
    word = VERDICTS.get(camera.status, camera.status.replace("_", " ").capitalize())
    reason = "" if camera.accepted else f'<span class="why">{escape(_sentence(camera.reason))}</span>'
    cells = [f'<td class="{look}" data-label="Verdict"><strong>{mark} {escape(word)}</strong>{reason}</td>']
    expected = camera.expected
    values = [
        _focal(camera),
        _height(camera, unit, floor),
        _angle(tilt(camera)),
        _clock(clock),
        UNKNOWN if expected is None else " · ".join(stated_errors(expected, unit)),
    ]
    for name, value in zip(HEADER[2:], values, strict=True):
        cells.append(f'<td data-label="{name}">{escape(value)}</td>')
    name = escape(camera.name)
    return f'<tr data-camera="{name}"><th scope="row">{name}</th>{"".join(cells)}</tr>'


def _focal(camera: NetworkCamera) -> str:
    focal, view = focal_length(camera), field_of_view(camera)
    return UNKNOWN if focal is None or view is None else f"{focal:.0f} px, {view:.0f}°"


def _height(camera: NetworkCamera, unit: str, floor: bool) -> str:
    position = camera.position
    return UNKNOWN if position is None or not floor else f"{_signed(position[2], 2)}{unit}"


def _angle(value: float | None) -> str:
    return UNKNOWN if value is None else f"{_signed(value, 1)}°"


def _signed(value: float, digits: int) -> str:
    """Write a number with a true minus and without -0."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "\N{MINUS SIGN}")


def _clock(clock: NetworkClock) -> str:
    if clock.offset is None:
        return UNKNOWN
    error = "" if not clock.offset_error else f" ± {1000 * clock.offset_error:.1g} ms"
    text = f"{clock.offset:+.3f} s{error}"
    if abs(clock.drift or 0.0) >= 0.5:
        text += f", {clock.drift:+.0f} ppm"
    return text.replace("-", "\N{MINUS SIGN}")
