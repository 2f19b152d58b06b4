"""Many cameras at once: from recordings to one network of cameras, with a verdict on each.

:func:`calibrate_network` is the whole job; :func:`join_pairs` makes a network of pairs that were calibrated
before; a :class:`Network` is saved, scaled to metres and exported.
"""

from .calibrating import calibrate_network
from .joining import join_pairs
from .knowledge import KnownCamera
from .offsets import ClockOffsets, find_offsets
from .parts import Ground, NetworkCamera, NetworkClock, NetworkPair, Scale
from .result import Network

__all__ = [
    "ClockOffsets",
    "Ground",
    "KnownCamera",
    "Network",
    "NetworkCamera",
    "NetworkClock",
    "NetworkPair",
    "Scale",
    "calibrate_network",
    "find_offsets",
    "join_pairs",
]
