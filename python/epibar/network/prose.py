"""A network as prose: a table of its cameras, and what to know of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

import numpy as np

from ..files.text_table import aligned
from .parts import BASELINE, NetworkCamera, NetworkClock, NetworkParts

__all__ = ["network_notes", "network_table", "pixels_note", "stated_errors"]

GIVEN = "given"
"""For the error of a focal length that is not solved for."""

HEADER = ("camera", "verdict", "focal length", "position", "errors: focal, rotation, position", "clock")


def network_table(network: NetworkParts) -> list[str]:
    """Lines of a table, a row for each camera; true errors are below those stated nine times in ten."""
    unit = " m" if network.unit != BASELINE else ""
    rows: list[tuple[str, ...]] = [HEADER]
    rows += [_row(camera, network.clocks[name], unit) for name, camera in network.cameras.items()]
    return aligned(rows)


def _row(camera: NetworkCamera, clock: NetworkClock, unit: str) -> tuple[str, ...]:
    verdict = "accepted" if camera.accepted else f"refused ({camera.status})"
    if camera.matrix is None or camera.position is None or camera.expected is None:
        return camera.name, verdict, "-", "-", "-", "-"
    place = ", ".join(f"{round(value, 2) + 0.0:.2f}" for value in camera.position)
    errors = stated_errors(camera.expected, unit)
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    return camera.name, verdict, f"{focal:.0f} px", f"({place}){unit}", ", ".join(errors), _clock(clock)


def stated_errors(expected: Mapping[str, float], unit: str) -> tuple[str, str, str]:
    """Say below what the errors of focal length, rotation and position are, nine times in ten."""
    return (
        _number(100 * expected["focal"], lambda v: f"{v:.2g} %" if v > 0 else GIVEN),
        _number(expected["rotation"], lambda v: f"{v:.2g}°"),
        _number(expected["position"], lambda v: f"{v:.2g}{unit}"),
    )


def _number(value: float | None, text: Callable[[float], str]) -> str:
    return text(value) if value is not None and math.isfinite(value) else "unknown"


def _clock(clock: NetworkClock) -> str:
    if clock.offset is None:
        return "-"
    return f"{clock.offset:+.3f} s" + (f", {clock.drift:+.0f} ppm" if abs(clock.drift or 0.0) >= 0.5 else "")


def _level(network: NetworkParts) -> str:
    """How well the floor's level is known, in metres where there are metres."""
    error = network.ground.level_error
    if error is None or network.unit == BASELINE:
        return ""
    return f", to {100 * error:.2g} cm (standard error)"


def pixels_note(network: NetworkParts, lenses: Collection[str] = ()) -> list[str]:
    """Say of which cameras pixels are not those of the video; ``lenses`` are names of known ones."""
    cameras = [one for one in network.cameras.values() if one.accepted and one.undistorted]
    names = [one.name for one in cameras if one.lens is None and one.name not in lenses]
    if not names:
        return []
    return [
        f"{', '.join(names)}: in undistorted pixels, not in those of the video: the recording knows its "
        "camera matrix, and not the lens that was taken out; give its intrinsics too"
    ]


def network_notes(network: NetworkParts) -> list[str]:
    """Say what the table leaves open: why cameras are refused, what up and the unit are."""
    notes = [f"{name}: {camera.reason}" for name, camera in network.cameras.items() if not camera.accepted]
    notes += pixels_note(network)
    standing = [name for name, camera in network.cameras.items() if camera.matrix is not None]
    if len(standing) < 2:
        return notes
    ground = network.ground
    if ground.source == "floor":
        notes.append(
            f"z is up, from the floor that {ground.figures} figures stand on (standard error "
            f"{_number(ground.vertical_error, lambda v: f'{v:.2g}°')}), and z = 0 is that floor"
            + _level(network)
        )
    else:
        notes.append(
            "no floor was found: z is the mean of the cameras' own up, which is the vertical of cameras that "
            "are mounted level; of those that look down from a ceiling it is not"
        )
    if network.unit == BASELINE:
        people = ground.source == "floor" and ground.not_people is None
        notes.append(
            f"the unit of length is the distance between {standing[0]} and {standing[1]}; for metres give "
            + ("--person-height or --distance" if people else "--distance")
        )
        if ground.source == "floor" and ground.not_people is not None:
            notes.append(f"what moves gives no metres by its height: {ground.not_people}")
    elif network.scale is not None:
        notes.append(
            f"metres to {100 * network.scale.error:.2g} % nine times in ten, by "
            + " and ".join(network.scale.sources)
        )
    return notes
