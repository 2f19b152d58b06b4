"""Ways of walkers that stand in a file of cameras."""

from __future__ import annotations

from dataclasses import dataclass

from ..arguments import Array

__all__ = ["AFTER", "Way"]

AFTER = 1e-3
"""Seconds after the last place at which a walker is not there any more."""


@dataclass(frozen=True, eq=False)
class Way:
    """One walker without gaps, n places in the order of time, in the world and unit of the cameras.

    Attributes
    ----------
    name : str
        Which walker.
    time : ndarray, shape (n,)
        Seconds of the network's first camera.
    foot, top : ndarray, shape (n, 3)
        The bottom and the top.
    """

    name: str
    time: Array
    foot: Array
    top: Array
