"""The network of the demo against the known answer, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..network.parts import NetworkCamera
    from ..network.result import Network
    from ..synthetic.network_errors import CameraError, WorldError
    from ..synthetic.staging import Staging

__all__ = ["compared"]

PARTS = ("focal length", "rotation", "position")


def compared(network: Network, staging: Staging) -> list[str]:
    """Say of every accepted camera how wrong it is, and whether what was stated of it holds."""
    from ..files.text_table import aligned
    from ..network.parts import METRE
    from ..synthetic.network_errors import accepted_cameras, network_errors, world_error

    found = accepted_cameras(network)
    lines = [
        f"{name}: left out: {camera.why_left_out}"
        for name, camera in network.cameras.items()
        if not camera.accepted
    ]
    if len(found) < 2:
        return [*lines, "fewer than two cameras were accepted, so there is nothing to compare"]
    size, unit = _lengths(network, staging, list(found))
    below = held = 0
    rows: list[tuple[str, ...]] = [("camera", *PARTS, "clock")]
    for name, error in network_errors(staging, found).items():
        cells, good = _cells(network.cameras[name], error, size, unit)
        held, below = held + len(good), below + sum(good)
        rows.append((name, *cells, _clock(network, staging, name)))
    lines += aligned(rows) + _world(network, world_error(staging, found))
    length = "a metre" if network.unit == METRE else "the unit of length"
    lines.append(
        f"{below} of {held} errors are below what was stated; nine in ten are meant to be, over many scenes. "
        f"Positions are in true metres, what was stated of them too: {length} of the network is {unit:.3f} m"
    )
    return lines


def _world(network: Network, error: WorldError) -> list[str]:
    """How far the vertical and the metres are off, as far as the network has them."""
    said = []
    if (vertical := network.ground.vertical_error) is not None:
        said.append(f"z is {error.vertical:.2f}° from the vertical (standard error {vertical:.2f}°)")
    if network.scale is not None:
        wrong, stated = 100 * (1 / error.unit - 1), 100 * network.scale.error
        said.append(f"lengths in metres are off by {wrong:+.1f} % (stated {stated:.1f} %)")
    return [", ".join(said)] if said else []


def _lengths(network: Network, staging: Staging, names: list[str]) -> tuple[float, float]:
    """Metres: the largest distance between two of the true cameras, and the network's unit."""
    from itertools import combinations

    import numpy as np

    true = {camera.name: camera.centre for camera in staging.cameras}
    pairs = list(combinations(names, 2))
    size = max(float(np.linalg.norm(true[a] - true[b])) for a, b in pairs)
    scales = []
    for a, b in pairs:
        one, other = network.cameras[a].position, network.cameras[b].position
        assert one is not None
        assert other is not None
        scales.append(np.linalg.norm(true[a] - true[b]) / np.linalg.norm(one - other))
    return size, float(np.median(scales))


def _cells(
    camera: NetworkCamera, error: CameraError, size: float, unit: float
) -> tuple[list[str], list[bool]]:
    """What was found to be wrong beside what was stated, and which of them holds."""
    expected = camera.expected or {}
    values = (
        (100 * error.focal, 100 * expected["focal"], "{:+.2f} %", "{:.2f} %"),
        (error.rotation, expected["rotation"], "{:.2f}°", "{:.2f}°"),
        (100 * error.position * size, 100 * expected["position"] * unit, "{:.1f} cm", "{:.1f} cm"),
    )
    good = [abs(found) <= stated for found, stated, _, _ in values]
    cells = [
        f"{form.format(found)} (stated {plain.format(stated)})" + ("" if holds else " above it")
        for (found, stated, form, plain), holds in zip(values, good, strict=True)
    ]
    return cells, good


def _clock(network: Network, staging: Staging, name: str) -> str:
    """Difference of a clock, less that of the reference, which is the first camera."""
    offset = network.clocks[name].offset
    if offset is None:
        return "unknown"
    return f"{1000 * (offset - staging.offset(list(network.cameras).index(name))):+.0f} ms"
