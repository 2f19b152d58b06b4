"""What the cameras of a file stand in: the unit of length, what is up, and what else is to be said."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from .two_views import TwoViews
from .ways import Way

__all__ = ["BY_CAMERAS", "METRE", "ON_FLOOR", "SOFTWARE", "World"]

SOFTWARE = "epibar"
"""What a file says that it is of."""

METRE = "metre"

ON_FLOOR = "z is up", "the floor"
BY_CAMERAS = (
    "z is the mean of the cameras' own up, not the vertical where they look down",
    "the mean height of the cameras",
)
"""What z is, and what z = 0 is."""


@dataclass(frozen=True)
class World:
    """A world that cameras stand in.

    Attributes
    ----------
    unit : str
        "metre", or in words what a length of 1 is.
    zero : str or None
        What z = 0 is, where z is up: that of a network. None where the axes are those of the first camera.
    up : str
        What z is then.
    notes : tuple of str
        What a file says of itself besides.
    ways : tuple of Way
        Of walkers, where the format has a place for them.
    two_views : tuple of TwoViews
        Points that cameras share, where the format has a place for them.
    """

    unit: str
    zero: str | None = None
    up: str = ON_FLOOR[0]
    notes: tuple[str, ...] = ()
    ways: tuple[Way, ...] = ()
    two_views: tuple[TwoViews, ...] = ()

    @property
    def in_metres(self) -> bool:
        """Whether lengths are metres."""
        return self.unit == METRE

    def with_notes(self, notes: Iterable[str]) -> World:
        """Return it with more to say."""
        return replace(self, notes=(*self.notes, *notes))

    def metadata(self) -> dict[str, str | list[str]]:
        """Return what a camera file says of itself, beside its cameras."""
        found: dict[str, str | list[str]] = {"unit": self.unit, "notes": list(self.notes)}
        if self.zero is None:
            return found
        return {"software": SOFTWARE, "world": f"{self.up}; z = 0 is {self.zero}", **found}

    def lines(self) -> dict[str, str]:
        """Return :meth:`metadata` as one text each."""
        return {
            key: value if isinstance(value, str) else "; ".join(value)
            for key, value in self.metadata().items()
        }
