"""Which cameras have moved, as prose: a table, and what to know of it."""

from __future__ import annotations

import math

from ..files.text_table import aligned
from .checking import MOVED, SUSPECT, UNMOVED, CameraCheck, NetworkCheck
from .parts import BASELINE, NetworkParts

__all__ = ["check_notes", "check_table"]

HEADER = ("camera", "verdict", "turned by", "shifted by", "focal length", "since")

VERDICTS = {UNMOVED: "has not moved", MOVED: "HAS MOVED", SUSPECT: "MAY HAVE MOVED"}


def check_table(check: NetworkCheck) -> list[str]:
    """Lines of a table, a row for each camera; true errors are below those stated nine times in ten."""
    unit = "" if check.unit == BASELINE else " m"
    return aligned([HEADER, *(_row(camera, unit) for camera in check.cameras.values())])


def _row(camera: CameraCheck, unit: str) -> tuple[str, ...]:
    return (
        camera.name,
        VERDICTS.get(camera.status, "unsure"),
        _measured(camera.turned, camera.turned_error, "°"),
        _measured(camera.shifted, camera.shifted_error, unit),
        _zoomed(camera),
        "-" if camera.since is None else f"{camera.since:.1f} s",
    )


def _measured(value: float | None, error: float | None, unit: str) -> str:
    if value is None:
        return "-"
    known = error is not None and math.isfinite(error)
    return f"{value:.3g}{unit} ± " + (f"{error:.2g}{unit}" if known else "unknown")


def _zoomed(camera: CameraCheck) -> str:
    if camera.focal is None:
        return "-"
    known = camera.focal_error is not None and math.isfinite(camera.focal_error)
    return f"{100 * camera.focal:+.2f} %" + (f" ± {100 * (camera.focal_error or 0):.2g} %" if known else "")


def _shift_unseen(camera: CameraCheck) -> bool:
    """Whether nothing tells how far it was shifted."""
    error = camera.shifted_error
    return camera.shifted is not None and (error is None or not math.isfinite(error))


def check_notes(check: NetworkCheck, network: NetworkParts) -> list[str]:
    """Say what the table leaves open: why, which cameras were not looked at, and what the unit is."""
    cameras = check.cameras.items()
    notes = [f"{name}: {one.reason}" for name, one in cameras if one.status != UNMOVED or _shift_unseen(one)]
    notes += [f"{name} was not looked at: {why}" for name, why in check.left_out.items()]
    if check.unit == BASELINE and any(one.shifted is not None for one in check.cameras.values()):
        first, second = [name for name, camera in network.cameras.items() if camera.matrix is not None][:2]
        notes.append(f"the unit of length is the distance between {first} and {second} when calibrated")
    return notes
