"""What all opponents are given: recordings of a network, its clocks and its pairs, each made once and kept.

Clocks and pairs are those of ``calibrate_network``, whose stages are called one by one.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from networks_recordings import recorded
from tables import progress

from epibar import Calibration, Recording, synthetic
from epibar.calibration import SEARCH_SECONDS
from epibar.lens.cameras_toml import load_cameras
from epibar.network import ClockOffsets, find_offsets, pairs_to_search, search_pairs
from epibar.synthetic import Camera


@dataclass(frozen=True)
class Rig:
    """Cameras with what is known of them, and what their pairs brought."""

    name: str
    true: dict[str, Camera]
    recordings: dict[str, Recording]
    offsets: ClockOffsets
    pairs: dict[tuple[str, str], Calibration]


def _kept(path: Path, make: Callable[[], Recording]) -> Recording:
    """Load a recording, or make and save it."""
    if not path.exists():
        made = make()
        path.parent.mkdir(parents=True, exist_ok=True)
        made.save(path)
        progress(f"{path.parent.name}: {path.stem} recorded")
    return Recording.load(path)


def _clocks(path: Path, films: list[Recording]) -> ClockOffsets:
    """Find the offsets of the clocks, or read what was found."""
    if not path.exists():
        path.write_text(json.dumps(asdict(find_offsets(films, SEARCH_SECONDS))))
    found = json.loads(path.read_text())
    return ClockOffsets(tuple(found["seconds"]), found["together"], found["given"])


def _pairs(
    folder: Path, recordings: dict[str, Recording], offsets: ClockOffsets, seed: int
) -> dict[tuple[str, str], Calibration]:
    """Calibrate the pairs that are worth a search, or load what was found of them."""
    names = list(recordings)
    chosen = pairs_to_search(recordings, offsets)
    found = {}
    for done, (a, b) in enumerate(chosen):
        path = folder / f"{names[a]}-{names[b]}.npz"
        if not path.exists():
            progress(f"{folder.name}: {path.stem}, {done + 1} of {len(chosen)}")
            search_pairs(recordings, [(a, b)], offsets, seed=seed)[names[a], names[b]].save(path)
        found[names[a], names[b]] = Calibration.load(path)
    return found


def made_up(family: str, seed: int, lines: int, cache: Path) -> Rig:
    """Draw a network, record it and calibrate its pairs; nothing is known, clocks are found."""
    situation = synthetic.situation(seed, family)
    folder = cache / f"{family}-{seed}-{lines}"
    recordings = {
        camera.name: _kept(folder / f"{camera.name}.npz", lambda i=index: situation.recording(i, lines))
        for index, camera in enumerate(situation.cameras)
    }
    offsets = _clocks(folder / "clocks.json", list(recordings.values()))
    pairs = _pairs(folder, recordings, offsets, seed % 2**32)
    short = f"{seed:x}"[:6] if seed >> 32 else str(seed)
    return Rig(f"{family} {short}", {c.name: c for c in situation.cameras}, recordings, offsets, pairs)


def filmed(data: Path, lines: int, cache: Path) -> Rig:
    """Take a real recording whose cameras started together, raw as they filmed."""
    true = {}
    for known in load_cameras(data / "cameras.toml"):
        pose = known.posed()
        true[known.name] = Camera(
            known.matrix, pose.R, pose.t, known.size, known.name, tuple(known.distortions)
        )
    folder = cache / f"{data.name}-{lines}"
    recordings = {
        name: _kept(folder / f"{name}.npz", lambda name=name: recorded(data, [name], lines)[name])
        for name in true
    }
    offsets = ClockOffsets((0.0,) * len(recordings), given=True)
    return Rig(data.name, true, recordings, offsets, _pairs(folder, recordings, offsets, 0))
