"""A world of movers: every solid at any moment, with shadows, and what only some cameras see."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arguments import Array, Bits, Index
from .figures import Movers, Posture

ALL = -1
"""Of a mover or an occluder that every camera sees."""


@dataclass(frozen=True, eq=False)
class Furniture:
    """Static boxes that hide what is behind them: (n, 3) centres, (n, 3, 3) half-axes, and who sees them."""

    centres: Array = field(default_factory=lambda: np.empty((0, 3)))
    axes: Array = field(default_factory=lambda: np.empty((0, 3, 3)))
    only: Index = field(default_factory=lambda: np.empty(0, np.int64))


@dataclass(frozen=True, eq=False)
class Shapes:
    """Solids of K moments in one flat list, those that are there and seen by one camera.

    Attributes
    ----------
    frame : (m,) int array
        Moment 0 … K − 1.
    centres, axes : (m, 3) and (m, 3, 3) array
    box : (m,) bool array
    owner : (m,) int array
        Which mover; −1 for furniture and shadows.
    moving : (m,) bool array
        False for furniture.
    """

    frame: Index
    centres: Array
    axes: Array
    box: Bits
    owner: Index
    moving: Bits


def shadow_map(light: Array) -> Array:
    """Return the (3, 3) map that casts points on the floor z = 0, along the way of the light, downwards.

    Linear, so it takes an ellipsoid to exactly the ellipse of its shadow, a flat one.
    """
    return np.eye(3) - np.outer(light / light[2], [0.0, 0.0, 1.0])


def _nobody(moments: int) -> Posture:
    return Posture(np.empty((moments, 0, 3)), np.empty((moments, 0, 3, 3)), np.empty((moments, 0), bool))


class MadeUpWorld:
    """Movers, furniture and light.

    Parameters
    ----------
    movers : sequence of Movers
    only : sequence of int, optional
        For every mover, in order, the camera that alone sees it, or `ALL`.
    furniture : Furniture, optional
    light : (3,) array, optional
        The way the light falls, downwards; shadows then count as moving.
    """

    def __init__(
        self,
        movers: list[Movers],
        only: Index | None = None,
        furniture: Furniture | None = None,
        light: Array | None = None,
    ) -> None:
        self.movers, self.light = movers, light
        self.furniture = furniture or Furniture()
        firsts = np.cumsum([0, *(int(group.owner.max(initial=-1)) + 1 for group in movers)])
        self.count = int(firsts[-1])
        self.box = np.concatenate([np.empty(0, bool), *(group.box for group in movers)])
        owners = [group.owner + first for group, first in zip(movers, firsts[:-1], strict=True)]
        self.owner = np.concatenate([np.empty(0, np.int64), *owners])
        self.only = np.full(self.count, ALL) if only is None else np.asarray(only)

    def at(self, seconds: Array) -> Posture:
        """Return the solids of all movers at K moments."""
        postures = [_nobody(len(seconds)), *(group.at(seconds) for group in self.movers)]
        return Posture(
            np.concatenate([posture.centres for posture in postures], axis=1),
            np.concatenate([posture.axes for posture in postures], axis=1),
            np.concatenate([posture.present for posture in postures], axis=1),
        )

    def shapes(self, seconds: Array, camera: int) -> Shapes:
        """List what one camera sees at K moments."""
        posture = self.at(seconds)
        seen = np.isin(self.only[self.owner], (ALL, camera))
        frame, solid = np.nonzero(posture.present & seen)
        centres, axes = posture.centres[frame, solid], posture.axes[frame, solid]
        box, owner = self.box[solid], self.owner[solid]
        moving = np.ones(len(frame), bool)
        if self.light is not None:
            cast = shadow_map(self.light)
            frame, box, moving = np.tile(frame, 2), np.tile(box, 2), np.tile(moving, 2)
            owner = np.concatenate([owner, np.full(len(owner), -1)])
            centres = np.concatenate([centres, centres @ cast.T])
            axes = np.concatenate([axes, cast @ axes])
        still = np.flatnonzero(np.isin(self.furniture.only, (ALL, camera)))
        if len(still):
            every = np.repeat(np.arange(len(seconds)), len(still))
            frame = np.concatenate([frame, every])
            centres = np.concatenate([centres, np.tile(self.furniture.centres[still], (len(seconds), 1))])
            axes = np.concatenate([axes, np.tile(self.furniture.axes[still], (len(seconds), 1, 1))])
            box = np.concatenate([box, np.ones(len(every), bool)])
            owner = np.concatenate([owner, np.full(len(every), -1)])
            moving = np.concatenate([moving, np.zeros(len(every), bool)])
        return Shapes(frame, centres, axes, box, owner, moving)

    def random_points(self, rng: np.random.Generator, length: float, count: int, moments: int = 150) -> Array:
        """Draw points in moving solids that all cameras may see, (count, 3), at moments up to ``length``."""
        posture = self.at(np.sort(rng.uniform(0, length, moments)))
        time, solid = np.nonzero(posture.present & (self.only[self.owner] == ALL))
        if not len(time):
            return np.empty((0, 3))
        pick = rng.integers(len(time), size=count)
        direction = rng.normal(size=(count, 3))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        within = direction * np.cbrt(rng.uniform(0, 1, (count, 1)))
        time, solid = time[pick], solid[pick]
        points: Array = posture.centres[time, solid] + np.einsum(
            "nij,nj->ni", posture.axes[time, solid], within
        )
        return points
