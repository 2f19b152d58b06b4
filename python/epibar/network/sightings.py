"""What each two cameras saw of walkers that are tracked."""

from __future__ import annotations

from dataclasses import dataclass

from ..arguments import Array, Index

__all__ = ["WalkerSightings"]


@dataclass(frozen=True, eq=False)
class WalkerSightings:
    """Tops and bottoms of walkers in the images, k times in two cameras each.

    A top in two cameras is a frontier point: one point of the head, where a plane through both cameras
    touches it. Two other cameras see another point of the same head, so that no point is seen by three.

    Attributes
    ----------
    place : ndarray of int, shape (k,)
        Which place of the tracks, in their order. Places of 1000 moments at most, spread over the time, have
        sightings.
    cameras : ndarray of int, shape (k, 2)
        Which two cameras, by their places in ``names``.
    top, foot : ndarray, shape (k, 2, 2)
        Pixels (x, y) in the first and in the second, as their recordings have them; where a moment falls
        between two frames of a camera, between what these show.
    """

    place: Index
    cameras: Index
    top: Array
    foot: Array

    def __len__(self) -> int:
        return len(self.place)
