"""Many cameras at once: from recordings to one network of cameras, with a verdict on each.

:func:`calibrate_network` is the whole job; :func:`join_pairs` makes a network of pairs that were calibrated
before, by hand with :func:`find_offsets`, :func:`pairs_to_search` and :func:`search_pairs`, the stages of the
whole; a :class:`Network` is saved, scaled to metres, exported, and checked against new footage.
"""

from .calibrating import calibrate_network
from .checking import CameraCheck, NetworkCheck, NewPlace
from .joining import join_pairs
from .knowledge import KnownCamera
from .offsets import ClockOffsets, find_offsets
from .pair_choice import pairs_to_search
from .pair_search import search_pairs
from .parts import Ground, KnownLength, NetworkCamera, NetworkClock, NetworkPair, Scale
from .result import Network
from .sightings import WalkerSightings
from .start_times import StartTime
from .walkers import WalkerTracks

__all__ = [
    "CameraCheck",
    "ClockOffsets",
    "Ground",
    "KnownCamera",
    "KnownLength",
    "Network",
    "NetworkCamera",
    "NetworkCheck",
    "NetworkClock",
    "NetworkPair",
    "NewPlace",
    "Scale",
    "StartTime",
    "WalkerSightings",
    "WalkerTracks",
    "calibrate_network",
    "find_offsets",
    "join_pairs",
    "pairs_to_search",
    "search_pairs",
]
