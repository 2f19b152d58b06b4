"""Real recordings as networks: errors of what is found with little or nothing known, beside those stated.

The recordings are no part of the project; without them this prints a message and does nothing. Masks are
taken raw, as the camera filmed. Pairs are calibrated once for each recording, and joined with each kind of
knowledge.
"""

from __future__ import annotations

import time
from argparse import ArgumentParser
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from options import add_names, natural
from recordings_floor import METRES, PERSON, feet, floor
from recordings_views import DATA, Data
from tables import progress

import epibar
from epibar import Recording
from epibar.lens.cameras_toml import find_camera, load_cameras
from epibar.network import ClockOffsets, join_pairs, search_pairs
from epibar.network.metres import NINE_IN_TEN

COARSE = ("nothing", "lens, focal, principal")
KNOWLEDGE = {
    "four_people": ("nothing", "lens", "lens, principal", "lens, focal", "lens, focal, principal"),
    "pets_cameras": ("nothing", "principal, aspect"),
    "wildtrack": ("nothing", "principal"),
    "walking": COARSE,
    "jumping": COARSE,
    "man_at_desk": COARSE,
}
"""By the names that ``recordings.py`` has for them."""
HEAD = (
    "| recording | known | accepted | focal %, median, worst | rotation °, of two cameras to each other "
    "| position, % of the rig | within what is stated (f R C) | vertical °, stated "
    "| floor cm, stated | metres from people, %, stated | s |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


@dataclass(frozen=True)
class Truth:
    """A camera as it is known."""

    K: Any
    distortions: Any
    R: Any
    centre: Any


def true_cameras(folder: Path, files: Iterable[str]) -> dict[str, Truth]:
    """Known cameras, by the names of the files that they filmed."""
    known = load_cameras(folder / "cameras.toml")
    found = {}
    for index, name in enumerate(files):
        camera = find_camera(known, name, index)
        posed = camera.posed()
        found[name] = Truth(camera.matrix, camera.distortions, posed.R, -posed.R.T @ posed.t)
    return found


def recorded(folder: Path, data: Data, lines: int) -> dict[str, Recording]:
    """What the cameras filmed, raw, by name."""
    return {
        name: epibar.record(folder / file, masks=data.masks, lines=lines, progress=False)
        for name, file in data.files.items()
    }


def knowledge(camera: Truth, words: str) -> epibar.KnownCamera:
    """What one of the rows of `KNOWLEDGE` says of a camera."""
    K = camera.K
    return epibar.KnownCamera(
        distortions=np.resize(camera.distortions, 5) * [1, 1, 0, 0, 1] if "lens" in words else None,
        focal=K[0, 0] if "focal" in words else None,
        focal_error=0.001,
        principal_point=K[:2, 2] if "principal" in words else None,
        aspect=K[1, 1] / K[0, 0] if "aspect" in words else None,
    )


def angle(turn: Any) -> float:
    """Angle of a rotation matrix, degrees."""
    return float(np.degrees(2 * np.arcsin(min(1.0, np.linalg.norm(turn - np.eye(3)) / np.sqrt(8)))))


def row(name: str, words: str, true: dict[str, Truth], network: Any, walked: Any, seconds: float) -> str:
    """Hold a network against the truth, all cameras that stand, accepted or not.

    ``walked`` is where people stand by the known cameras, metres, where these have a floor.
    """
    stand = {n: c for n, c in network.cameras.items() if c.matrix is not None}
    accepted = sum(camera.accepted for camera in network.cameras.values())
    start = f"| {name} | {words} | {accepted} of {len(true)} |"
    if len(stand) < 2:
        return f"{start} no camera stands |  |  |  |  |  |  | {seconds:.0f} |"
    ours = np.array([-c.rotation.T @ c.translation for c in stand.values()])
    theirs = np.array([true[n].centre for n in stand])
    turns = [c.rotation.T @ true[n].R for n, c in stand.items()]
    u, _, vt = np.linalg.svd(sum(turns))
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    moved = (ours - ours.mean(axis=0)) @ turn
    there = theirs - theirs.mean(axis=0)
    scale = (moved * there).sum() / (moved**2).sum()
    rig = max(np.linalg.norm(p - q) for p, q in combinations(theirs, 2))
    errors = np.array(
        [
            (
                abs(c.matrix[0, 0] / true[n].K[0, 0] - 1),
                angle(c.rotation @ turn @ true[n].R.T),
                np.linalg.norm(scale * moved[i] - there[i]) / rig,
            )
            for i, (n, c) in enumerate(stand.items())
        ]
    )
    stated = np.array(
        [
            (c.expected["focal"], c.expected["rotation"], c.expected["position"] * scale / rig)
            for c in stand.values()
        ]
    )
    relative = [
        angle((stand[p].rotation @ stand[q].rotation.T) @ (true[p].R @ true[q].R.T).T)
        for p, q in combinations(stand, 2)
    ]
    up = np.median([angle_between(c.rotation[:, 2], true[n].R[:, 2]) for n, c in stand.items()])
    within = " ".join(str(int(count)) for count in (errors <= stated + 1e-12).sum(axis=0))
    in_metres = ["-", "-"]
    if name in METRES:
        unit = METRES[name]
        middles = ours.mean(axis=0), unit * theirs.mean(axis=0)
        in_metres = [
            floor(network, walked, turn, scale * unit, middles),
            metres(network, scale * unit),
        ]
    cells = [
        f"{100 * np.median(errors[:, 0]):.2f}, {100 * errors[:, 0].max():.2f}",
        f"{np.median(relative):.2f}, {max(relative):.2f}",
        f"{100 * np.median(errors[:, 2]):.2f}, {100 * errors[:, 2].max():.2f}",
        f"{within} of {len(stand)}",
        f"{up:.2f}, {NINE_IN_TEN * network.ground.vertical_error:.2f}"
        if network.ground.source == "floor"
        else "no floor",
        *in_metres,
        f"{seconds:.0f}",
    ]
    return f"{start} " + " | ".join(cells) + " |"


def metres(network: Any, unit: float) -> str:
    """How far metres from people are off where a unit of the network measures so many, and what is stated."""
    try:
        scaled = network.scaled(person_height=PERSON)
    except epibar.EpibarError as error:
        return "refused: " + (
            "not people" if "says nothing: what moves" in str(error) else "no floor, or no camera"
        )
    found = scaled.ground.height / network.ground.height
    return f"{100 * abs(found / unit - 1):.1f}, {100 * scaled.scale.error:.1f}"


def angle_between(one: Any, other: Any) -> float:
    """Angle between two unit vectors, degrees."""
    return float(np.degrees(np.arccos(np.clip(one @ other, -1, 1))))


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="holds a folder for each recording")
    usual = [name for name in KNOWLEDGE if KNOWLEDGE[name] != COARSE]
    add_names(parser, "--recordings", KNOWLEDGE, usual, "default: all but the last three; ")
    parser.add_argument("--lines", type=natural, default=20_000)
    arguments = parser.parse_args()
    if not arguments.folder.is_dir():
        print(f"{arguments.folder}: no such folder, so nothing is measured")
        return
    print(HEAD)
    for name in arguments.recordings:
        data = DATA[name]
        folder = arguments.folder / data.folder
        if not folder.is_dir():
            progress(f"{folder}: not there, left out")
            continue
        true = true_cameras(folder, data.files)
        recordings = recorded(folder, data, arguments.lines)
        walked = None
        if name in METRES:
            walked = feet(true, recordings, METRES[name])
            above = 100 * np.percentile(walked[:, 2], [5, 50, 95])
            heights = " ".join(f"{z:.1f}" for z in above)
            progress(
                f"{name}: {len(walked)} feet by the known cameras, 5, 50 and 95 % of heights, cm: {heights}"
            )
        offsets = ClockOffsets((0.0,) * len(recordings), given=True)
        progress(f"{name}: pairs")
        pairs = search_pairs(recordings, list(combinations(range(len(recordings)), 2)), offsets)
        for words in KNOWLEDGE[name]:
            known = {n: knowledge(camera, words) for n, camera in true.items()}
            started = time.perf_counter()
            network = join_pairs(recordings, pairs, offsets, known=known)
            print(row(name, words, true, network, walked, time.perf_counter() - started), flush=True)


if __name__ == "__main__":
    main()
