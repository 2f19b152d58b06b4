"""The whole job: recordings in, one network out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..arguments import MAX_SEED, as_positive, as_whole_number
from ..calibration import SEARCH_SECONDS, calibrate
from ..errors import EpibarError
from .joining import join_pairs
from .knowledge import KnownCamera, has_focal, knowledge_of
from .metres import NOT_IN_METRES, check_lengths
from .offsets import ClockOffsets, TimeOffset, find_offsets, given_offsets
from .pair_choice import pairs_to_search
from .pair_search import offsets_of_pair, search_pairs
from .recordings import Recordings, named_recordings
from .result import Network
from .stages import Progress, as_stage, of_pairs

__all__ = ["calibrate_network", "in_metres"]


def calibrate_network(
    recordings: Recordings,
    seed: int = 0,
    time_offset: TimeOffset = "auto",
    *,
    known: Mapping[str, KnownCamera] | None = None,
    person_height: Any = None,
    distances: Any = (),
    camera_heights: Any = (),
    search_seconds: float = SEARCH_SECONDS,
    upright: bool = True,
    progress: Progress | None = None,
) -> Network:
    """Calibrate all cameras together: focal lengths, lenses, rotations, positions and clocks.

    None of these has to be known of three cameras; of two the focal lengths have to. Refusing is a result,
    not an error: look at ``accepted``, of the network and of each camera.

    Parameters
    ----------
    recordings : mapping of str to Recording, or sequence of Recording
        By the names of the cameras, over the same time. One whose lens was taken out knows its camera matrix;
        of the others nothing need be known.
    seed : int
        Of every random draw of the search; how flat motion is judged does not depend on it. The result
        depends on it and the recordings, not on the number of threads.
    time_offset : "auto", float, or mapping of str to float
        "auto" (also "search") finds an offset for each clock, and whether all cameras started together. 0.0
        says that they did. Seconds by name: what is at t in the first camera is at t + seconds in this one;
        for two cameras one number is that of the second.
    known : mapping of str to KnownCamera, optional
        What is known of cameras whose lens was not taken out.
    person_height, distances, camera_heights : optional
        Metres, as ``person_height``, ``distance`` and ``camera_height`` of :meth:`Network.scaled`. Where they
        cannot be used the unit stays "baseline" and ``reason`` says why.
    search_seconds : float
        How far either way an offset is looked for.
    upright : bool
        All cameras are the right way up, see :func:`epibar.calibrate`.
    progress : callable, optional
        Called with the name of the stage, "clocks", "pairs" or "network", and the share of it that is done.

    Returns
    -------
    Network

    Raises
    ------
    EpibarError
        An argument is of the wrong kind or out of its range.

    Examples
    --------
    >>> import epibar
    >>> names = ["cam1", "cam2", "cam3"]
    >>> net = epibar.calibrate_network({name: epibar.Recording.load(f"{name}.npz") for name in names})
    >>> for name, camera in net.cameras.items():
    ...     if camera.accepted:
    ...         K, R, t = camera.matrix, camera.rotation, camera.translation
    """
    cameras = named_recordings(recordings)
    names, films = list(cameras), list(cameras.values())
    seed = as_whole_number("seed", seed, 0, MAX_SEED)
    as_positive("search_seconds", search_seconds, "seconds")
    knowledge = knowledge_of(cameras, known)
    check_lengths(names, distances, person_height, camera_heights)
    offsets = given_offsets(names, time_offset)
    if len(names) == 2 and not all(map(has_focal, knowledge)):
        # No search can help: the core says what is missing.
        return join_pairs(cameras, {}, offsets or ClockOffsets((0.0, 0.0)), known=known)
    if offsets is None and len(films) == 2:
        pair = calibrate(
            films[0],
            films[1],
            seed=seed,
            time_offset="auto",
            search_seconds=search_seconds,
            upright=upright,
            progress=of_pairs(progress, 0, 1),
        )
        if progress is not None:
            progress("pairs", 1.0)
        offsets, pairs = offsets_of_pair(films[1], pair), {(names[0], names[1]): pair}
    else:
        offsets = offsets or find_offsets(films, search_seconds, as_stage("clocks", progress))
        chosen = pairs_to_search(films, offsets)
        pairs = search_pairs(cameras, chosen, offsets, seed=seed, upright=upright, progress=progress)
    network = join_pairs(cameras, pairs, offsets, known=known, progress=as_stage("network", progress))
    return in_metres(network, distances, person_height, camera_heights)


def in_metres(
    network: Network, distance: Any = (), person_height: Any = None, camera_height: Any = ()
) -> Network:
    """Scale a network where that can be done; where not, its ``reason`` says why.

    The pairs of hours of work are not to be lost for a length that does not fit.
    """
    if not distance and not camera_height and person_height is None:
        return network
    try:
        return network.scaled(distance=distance, person_height=person_height, camera_height=camera_height)
    except EpibarError as error:
        return replace(network, reason=f"{network.reason}{NOT_IN_METRES}{error}")
