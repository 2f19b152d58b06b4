"""What two cameras of a network see alike, in raw pixels: ends of walkers, or frontier points of pairs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..arguments import Array
from ..camera_export.two_views import TwoViews
from ..errors import EpibarError
from ..geometry.correspondences import FrontierPoints
from ..lens.intrinsics import Intrinsics
from .parts import NetworkParts
from .walkers import WalkerTracks

__all__ = ["two_views"]


def two_views(
    network: NetworkParts,
    lenses: Mapping[str, Intrinsics],
    tracks: WalkerTracks | None,
    frontier_points: Mapping[tuple[str, str], FrontierPoints] | None,
) -> tuple[TwoViews, ...]:
    """Collect the points of each two accepted cameras; see :meth:`epibar.Network.export`.

    Tops and bottoms of walkers are frontier points too, and taken between frames where the clocks ask for it;
    so the pairs' own, of whole frames, go in only for cameras that share no walker.

    Raises
    ------
    EpibarError
        The tracks have no sightings, points are something else, or a pair is not of this network.
    """
    found: dict[tuple[str, str], TwoViews] = {}
    if tracks is not None:
        if tracks.sightings is None:
            raise EpibarError(
                "these tracks hold no sightings, which a table has no place for: make them anew"
            )
        found = {(one.a, one.b): one for one in tracks.two_views()}
    for (a, b), points in _by_pair(frontier_points).items():
        network.refuse_unknown((a, b))
        if (a, b) in found or (b, a) in found or (a, b) not in network.pairs:
            continue
        if network.pairs[a, b].accepted:
            order = points.frame.argsort(kind="stable")
            found[a, b] = TwoViews(a, b, points.a[order], points.b[order])
    return tuple(
        replace(
            one,
            pixels_a=_raw(network, lenses, one.a, one.pixels_a),
            pixels_b=_raw(network, lenses, one.b, one.pixels_b),
        )
        for one in found.values()
        if network.cameras[one.a].accepted and network.cameras[one.b].accepted and len(one)
    )


def _by_pair(given: Any) -> Mapping[tuple[str, str], FrontierPoints]:
    """Take no points as none, and refuse what is no mapping of two names each to points."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise EpibarError(
            f"frontier_points is a {type(given).__name__}, expected points by the names of two cameras"
        )
    for pair, points in given.items():
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(name, str) for name in pair)):
            raise EpibarError(f"frontier_points[{pair!r}]: expected the names of two cameras")
        if not isinstance(points, FrontierPoints):
            raise EpibarError(
                f"frontier_points[{pair!r}] is a {type(points).__name__}, expected FrontierPoints"
            )
    return given


def _raw(network: NetworkParts, lenses: Mapping[str, Intrinsics], name: str, pixels: Array) -> Array:
    """Put a lens back that was taken out of the recording."""
    lens = lenses.get(name)
    if lens is None or not lens.distorted:
        return pixels
    camera = network.cameras[name].intrinsics(lens)
    K = camera.matrix
    return camera.through_lens((pixels - K[:2, 2]) / K[[0, 1], [0, 1]])
