"""Walkers as tracks on fresh networks of unknown cameras: who is followed, how far off, and who is nobody.

The seeds of a reported table come from the commit's own hash, as those of ``fresh.py``. A walker's place is
the middle of the body on the floor; a foot that steps is off it by up to 40 cm.
"""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any

import numpy as np
from fresh_seeds import networks_asked_for
from networks import start_worker
from options import add_networks
from tables import progress

NEAR = 0.5
"""Metres within which a place is a walker's; with none so near it is a ghost."""

ROUNDS = 4
"""Times that tops are laid over the heads that are nearest."""


def run(family: str, seed: int, lines: int) -> dict[str, Any]:
    """Draw a situation, calibrate its cameras, follow its walkers, hold them against the truth."""
    import epibar
    from epibar import synthetic

    situation = synthetic.situation(seed, family)
    recordings = {c.name: situation.recording(i, lines) for i, c in enumerate(situation.cameras)}
    network = epibar.calibrate_network(recordings, seed=seed % 2**32)
    return {"family": family, "seed": seed, **measured(situation, network, recordings)}


def measured(situation: Any, network: Any, recordings: Any) -> dict[str, Any]:
    """Measure the tracks of a network whose cameras are where they are."""
    import epibar

    found: dict[str, Any] = {"cameras": sum(c.accepted for c in network.cameras.values())}
    try:
        started = time.perf_counter()
        tracks = network.tracks(recordings)
        found["seconds"] = time.perf_counter() - started
    except epibar.EpibarError as error:
        return {**found, "why": str(error)}
    return {**found, **held_against(situation, network, tracks)}


def held_against(situation: Any, network: Any, tracks: Any) -> dict[str, Any]:
    """Compare tracks with the walkers that were there."""
    step = 1 / situation.clocks[0].fps
    moments = situation.clocks[0].moments
    times, row = np.unique(tracks.time, return_inverse=True)
    place, heads, present = walkers(situation, moments[0] + times / situation.clocks[0].rate)
    by_cameras = alignment(situation, network)
    as_placed, factor, turn, shift = on_walkers(tracks.top, heads[row], present[row], *by_cameras)
    foot, top = (factor * points @ turn.T + shift for points in (tracks.foot, tracks.top))
    apart = np.linalg.norm(place[row] - 0.5 * (foot[:, None, :2] + top[:, None, :2]), axis=2)
    apart[~present[row]] = np.inf
    nearest = apart.argmin(axis=1) if apart.shape[1] else np.zeros(len(foot), int)
    which = np.arange(len(foot))
    real = apart[which, nearest] < NEAR if len(foot) else np.zeros(0, bool)
    owner = {t: np.bincount(nearest[real & (tracks.track == t)]) for t in np.unique(tracks.track[real])}
    whose = np.array([owner[t].argmax() if t in owner else -1 for t in tracks.track], dtype=int)
    swapped = real & (nearest != whose)

    every = np.arange(moments[0], max(film.moments[-1] for film in situation.films), step)
    possible = in_two_views(situation, network, every)
    slot = np.round((moments[0] + tracks.time - every[0]) / step).astype(int)
    inside = real & (slot >= 0) & (slot < len(every))
    covered = np.zeros_like(possible)
    covered[slot[inside], nearest[inside]] = True
    mine = which[real], nearest[real]
    return {
        "tracks": len(np.unique(tracks.track)),
        "places": len(foot),
        "ghosts": int((~real).sum()),
        "swapped": int(swapped.sum()),
        "possible": int(possible.sum()),
        "covered": int((covered & possible).sum()),
        "by_many": int((tracks.cameras.sum(axis=1) > 2).sum()),
        "foot": np.linalg.norm(foot[real, :2] - place[row][mine], axis=1).tolist(),
        "head": np.linalg.norm(top[real] - heads[row][mine], axis=1).tolist(),
        "as_placed": as_placed,
        "residual": tracks.residual.tolist(),
    }


def on_walkers(top: Any, heads: Any, present: Any, factor: float, turn: Any, shift: Any) -> tuple[Any, ...]:
    """Lay tops over the heads near them: how far off they were, and factor, rotation and shift of the whole.

    A network is known up to a similarity. Where cameras stand in a row, centimetres between these are
    decimetres where people walk; what is left after tops are laid over heads is of the tracks themselves.
    """
    apart: list[float] = []
    for _ in range(ROUNDS if len(top) else 0):
        here = factor * top @ turn.T + shift
        off = np.linalg.norm(heads - here[:, None], axis=2)
        off[~present] = np.inf
        nearest, least = off.argmin(axis=1), off.min(axis=1)
        apart = apart or least[least < NEAR].tolist()
        near = least < min(NEAR, 3 * np.median(least) + 0.05)
        goal = heads[np.arange(len(top)), nearest][near]
        centre, aim = top[near].mean(axis=0), goal.mean(axis=0)
        offset, goal = top[near] - centre, goal - aim
        u, _, v = np.linalg.svd(goal.T @ offset)
        turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
        factor = float((goal * (offset @ turn.T)).sum() / (offset**2).sum())
        shift = aim - factor * turn @ centre
    return apart, factor, turn, shift


def alignment(situation: Any, network: Any) -> tuple[float, Any, Any]:
    """Similarity that takes the network to the world: factor, rotation, shift, from the accepted cameras."""
    known = {camera.name: camera for camera in situation.cameras}
    pairs = [(c, known[name]) for name, c in network.cameras.items() if c.accepted]
    found, true = (
        np.array(places) for places in zip(*((c.position, k.centre) for c, k in pairs), strict=True)
    )
    offset, goal = found - found.mean(axis=0), true - true.mean(axis=0)
    size = np.linalg.norm(offset) * np.linalg.norm(goal) / len(pairs)
    votes = goal.T @ offset / size + sum(k.R.T @ c.rotation for c, k in pairs)
    u, _, v = np.linalg.svd(votes)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    factor = float((goal * (offset @ turn.T)).sum() / (offset**2).sum())
    return factor, turn, true.mean(axis=0) - factor * turn @ found.mean(axis=0)


def walkers(situation: Any, seconds: Any) -> tuple[Any, Any, Any]:
    """Places on the floor (K, N, 2), tops (K, N, 3), and who is there (K, N), at seconds of the world."""
    from epibar.synthetic.figures import between, there_at

    world = situation.films[0].world
    place = [between(group.track.position, seconds) for group in world.movers]
    present = [there_at(group.track.present, seconds) for group in world.movers]
    tops = []
    for group in world.movers:
        pose = group.at(seconds)
        up = pose.axes[..., 2, :]
        reach = np.linalg.norm(up, axis=-1, keepdims=True)
        highest = pose.centres + np.einsum("kmij,kmj->kmi", pose.axes, up / reach)
        owners = range(int(group.owner.max()) + 1)
        of = [highest[:, group.owner == owner] for owner in owners]
        best = [points[..., 2].argmax(axis=1) for points in of]
        tops += [points[np.arange(len(points)), k] for points, k in zip(of, best, strict=True)]
    return np.concatenate(place, axis=1), np.stack(tops, axis=1), np.concatenate(present, axis=1)


def in_two_views(situation: Any, network: Any, seconds: Any) -> Any:
    """Whose head and place are in the images of two accepted cameras that film at the time, (K, N)."""
    place, heads, present = walkers(situation, seconds)
    feet = np.concatenate([place, np.zeros((*place.shape[:2], 1))], axis=2)
    count = np.zeros(present.shape, int)
    for k, camera in enumerate(situation.cameras):
        if not network.cameras[camera.name].accepted:
            continue
        filmed = situation.films[k].moments
        there = (seconds >= filmed[0]) & (seconds <= filmed[-1])
        seen = [situation.seen(k, points.reshape(-1, 3)).reshape(present.shape) for points in (heads, feet)]
        count += seen[0] & seen[1] & there[:, None]
    return present & (count > 1)


HEAD = (
    "| family | networks | with tracks | walkers' times covered % | by three cameras or more % | ghosts % "
    "| of another walker % | foot off the body, cm, median, 95 % | top off, cm | the same by the cameras "
    "| residual px | seconds |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


def table_row(outcomes: list[dict[str, Any]]) -> str:
    """One family in a row of the table."""
    with_tracks = [o for o in outcomes if "places" in o]
    cells = [outcomes[0]["family"], str(len(outcomes)), str(len(with_tracks))]
    total = {key: sum(o[key] for o in with_tracks) for key in ("covered", "possible", "places")}
    if total["places"]:
        cells.append(f"{100 * total['covered'] / max(total['possible'], 1):.1f}")
        for key in ("by_many", "ghosts", "swapped"):
            cells.append(f"{100 * sum(o[key] for o in with_tracks) / total['places']:.2f}")
        for key, unit in (("foot", 100), ("head", 100), ("as_placed", 100), ("residual", 1)):
            values = unit * np.concatenate([o[key] for o in with_tracks])
            cells.append(f"{np.median(values):.1f}, {np.quantile(values, 0.95):.1f}")
        cells.append(f"{np.median([o['seconds'] for o in with_tracks]):.1f}")
    return "| " + " | ".join(cells) + " |"


def main(arguments: Namespace) -> None:
    origin, jobs = networks_asked_for(arguments, "tracks ")
    outcomes = []
    workers = ProcessPoolExecutor(arguments.workers, get_context("spawn"), start_worker)
    with workers as pool:
        for done in as_completed([pool.submit(run, *job, arguments.lines) for job in jobs]):
            outcome = done.result()
            outcomes.append(outcome)
            progress(f"{len(outcomes)} of {len(jobs)}: {outcome['family']} {outcome['seed']}")
    print(f"commit {origin}" if origin else "seeds by hand: no table to report")
    print(HEAD)
    for family in arguments.families.split(","):
        print(table_row([o for o in outcomes if o["family"] == family]))


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    add_networks(parser, "network_plain,network", 3)
    main(parser.parse_args())
