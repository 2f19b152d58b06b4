"""Exact results of pairs and networks, held against those of another build: for changes that change nothing.

Prints a line for each case. ``--save FILE`` keeps the results, ``--compare FILE`` holds them
against kept ones and exits with 1 where one differs in a single bit. Floats are kept as
hexadecimal, arrays as a hash of their bytes. Public names are used, and what ``epibar demo`` stages its scene
with, so that one file runs under both builds::

    old/.venv/bin/python benchmarks/same_results.py --save old.json
    new/.venv/bin/python benchmarks/same_results.py --compare old.json

The cases: the videos of ``epibar demo``, pairs of them and their network with every number that it holds; a
made-up network; pairs of the real recordings that `recordings.py` measures on, where they are there; more
than twenty made-up pairs, easy, hard and without an answer, by both methods, with given and searched offsets,
with and without camera matrices, upright or not; the matches of barcodes.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import epibar
from epibar import Network, Recording, synthetic
from epibar.cli import demo as demo_command
from epibar.synthetic import LOW_CAMERAS, Scene
from epibar.synthetic.figures import MEAN_HEIGHT
from epibar.synthetic.staging import stage

ROOT = Path(__file__).resolve().parents[1]

SHOWN = ("F", "expected_error", "reason", "kind", "accepted", "time_offset", "counts", "evidence", "source")
"""What is kept of a calibration as it is, to be read where it differs."""
HASHED = ("candidates", "frontier_points", "floor", "rivals", "shift_curve", "timing", "error_maps")


@dataclass(frozen=True)
class Case:
    """A pair: how it is recorded, and with which options it is calibrated."""

    name: str
    recordings: Callable[[], tuple[Recording, Recording]]
    options: dict[str, Any] = field(default_factory=dict)
    quick: bool = False


@dataclass(frozen=True)
class NetworkCase:
    """Cameras that are calibrated together: how they are recorded, and with which options."""

    name: str
    recordings: Callable[[], dict[str, Recording]]
    options: dict[str, Any] = field(default_factory=dict)
    quick: bool = False


# --- made-up pairs ---


def _made(
    scene: Scene, lines: int, pair: tuple[int, int] = (0, 1), late: int = 0
) -> tuple[Recording, Recording]:
    """Record two cameras of a scene, the first of them so many frames late."""
    masks = [scene.masks(camera) for camera in pair]
    first, second = masks[0][late:], masks[1]
    return (
        Recording.from_masks(first, fps=scene.fps, lines=lines, seed=1, name="a"),
        Recording.from_masks(second, fps=scene.fps, lines=lines, seed=2, name="b"),
    )


def _with_matrices(scene: Scene, lines: int) -> tuple[Recording, Recording]:
    """Record two cameras that know their focal lengths to 2 %, one too long and one too short."""
    recordings = []
    for camera, wrong in ((0, 1.02), (1, 0.98)):
        matrix = scene.cameras[camera].K.copy()
        matrix[[0, 1], [0, 1]] *= wrong
        masks = scene.masks(camera)
        recordings.append(Recording.from_masks(masks, fps=scene.fps, lines=lines, seed=camera, matrix=matrix))
    return recordings[0], recordings[1]


def _unrelated(lines: int) -> tuple[Recording, Recording]:
    scenes = [synthetic.people(5, frames=240, motion_seed=motion) for motion in (None, 99)]
    masks = [scene.masks(camera) for camera, scene in enumerate(scenes)]
    return Recording.from_masks(masks[0], lines=lines), Recording.from_masks(masks[1], lines=lines, seed=1)


def _still(lines: int) -> tuple[Recording, Recording]:
    scene = synthetic.cubes(1, frames=60)
    masks = scene.masks(0)
    return Recording.from_masks(masks, lines=lines), Recording.from_masks(np.zeros_like(masks), lines=lines)


def _other_rate(lines: int) -> tuple[Recording, Recording]:
    """Record the second camera at half the frame rate."""
    scene = synthetic.cubes(6, frames=400)
    a, b = scene.masks(0), scene.masks(1)[::2]
    return (
        Recording.from_masks(a, fps=25.0, lines=lines, seed=1),
        Recording.from_masks(b, fps=12.5, lines=lines, seed=2),
    )


def _three(lines: int) -> dict[str, Recording]:
    """Record three cameras of one crowd."""
    scene = synthetic.people(1, cameras=3, walkers=6, frames=300)
    return {
        name: Recording.from_masks(scene.masks(camera), fps=scene.fps, lines=lines, seed=camera, name=name)
        for camera, name in enumerate(("a", "b", "c"))
    }


def made_up() -> Iterator[Case | NetworkCase]:
    """A network, and twenty-nine pairs and the ways to calibrate them."""
    people, cubes = synthetic.people, synthetic.cubes

    def case(
        name: str, make: Callable[[], tuple[Recording, Recording]], quick: bool = False, **options: Any
    ) -> Case:
        return Case(f"made-up, {name}", make, options, quick)

    yield case("cubes", lambda: _made(cubes(1, frames=300), 8000), quick=True)
    yield case("cubes, lines", lambda: _made(cubes(2, frames=400), 10_000), method="lines", quick=True)
    yield case("thin cubes", lambda: _made(synthetic.thin_cubes(1, frames=300), 6000), seed=3)
    yield case("high", lambda: _made(people(1, frames=300), 8000), seed=1)
    yield case("high, lines", lambda: _made(people(2, frames=400), 8000), method="lines")
    yield case("low", lambda: _made(people(1, camera_height=LOW_CAMERAS, frames=300), 6000), seed=2)
    yield case("low, opposite", lambda: _made(people(2, camera_height=LOW_CAMERAS, frames=250), 6000, (0, 2)))
    yield case(
        "low, lines", lambda: _made(people(3, camera_height=LOW_CAMERAS, frames=300), 6000), method="lines"
    )
    two = {"walkers": 2, "camera_height": LOW_CAMERAS}
    yield case("two walkers", lambda: _made(people(1, frames=300, **two), 6000), quick=True)
    yield case("sixteen", lambda: _made(people(1, walkers=16, camera_height=LOW_CAMERAS, frames=150), 5000))
    yield case("dirty", lambda: _made(people(1, dirty=True, frames=250), 5000))
    yield case("occluders", lambda: _made(people(1, occluders=8, frames=250), 5000))
    yield case("asymmetric", lambda: _made(people(1, asymmetric=True, frames=250), 5000))
    yield case("facing", lambda: _made(people(1, cameras=2, facing=True, frames=250), 5000))
    yield case("one path", lambda: _made(people(1, one_path=True, frames=250), 5000))
    yield case("one camera only", lambda: _made(people(1, one_camera_only=4, frames=250), 5000))
    yield case(
        "searched offset", lambda: _made(cubes(3, frames=260, objects=8), 5000, late=7), time_offset="search"
    )
    searched = {"time_offset": "search", "search_seconds": 1.5}
    yield case(
        "searched, lines", lambda: _made(cubes(4, frames=300), 6000, late=11), method="lines", **searched
    )
    yield case("searched, people", lambda: _made(people(3, walkers=4, frames=240), 5000, late=5), **searched)
    yield case(
        "between frames", lambda: _made(cubes(5, frames=250, objects=8), 5000), time_offset=0.4, quick=True
    )
    yield case("other frame rate", lambda: _other_rate(5000), time_offset=0.0)
    yield case("not upright", lambda: _made(people(4, walkers=5, frames=250), 5000), upright=False)
    yield case(
        "cubes, not upright", lambda: _made(cubes(7, frames=200, objects=6), 4000), upright=False, quick=True
    )
    low = {"camera_height": LOW_CAMERAS, "walkers": 4}
    yield case("camera matrices", lambda: _with_matrices(people(6, frames=250, **low), 5000), quick=True)
    yield case("matrices unused", lambda: _with_matrices(people(6, frames=250, **low), 5000), essential=False)
    strict = {"max_expected_error": 0.05, "draws": 3000, "candidates": 300}
    yield case("strict", lambda: _made(cubes(8, frames=200, objects=8), 4000), **strict)
    yield case("unrelated", lambda: _unrelated(4000))
    yield case("still", lambda: _still(2000), quick=True)
    yield NetworkCase("made-up, network", lambda: _three(4000), {"time_offset": 0.0}, quick=True)
    yield case("too short", lambda: _made(cubes(1, frames=14), 2000), quick=True)


# --- the demo, and real recordings ---


@cache
def _demo(folder: Path) -> dict[str, Recording]:
    """Record the videos that ``epibar demo`` renders where nothing else is asked for, as it does."""
    staging = stage(
        0,
        cameras=demo_command.CAMERAS,
        walkers=demo_command.WALKERS,
        seconds=demo_command.SECONDS,
        size=demo_command.SIZE,
        barrel=True,
        unsynchronised=True,
        empty_frames=demo_command.EMPTY,
    )
    videos = {
        camera.name: staging.render(index, folder / f"{camera.name}.mp4")
        for index, camera in enumerate(staging.cameras)
    }
    return {name: epibar.record(video, seed=0, name=name, progress=False) for name, video in videos.items()}


def demo(folder: Path) -> Iterator[Case | NetworkCase]:
    """Three pairs of the demo, one of them by both methods, and its network in metres."""
    found = {"time_offset": "auto"}
    for a, b in (("cam1", "cam2"), ("cam1", "cam3"), ("cam2", "cam3")):
        yield Case(f"demo {a}-{b}", lambda a=a, b=b: (_demo(folder)[a], _demo(folder)[b]), found)
    lines = {"method": "lines", **found}
    yield Case("demo cam1-cam2, lines", lambda: (_demo(folder)["cam1"], _demo(folder)["cam2"]), lines)
    yield NetworkCase("demo, network", lambda: _demo(folder), {"person_height": MEAN_HEIGHT})


REAL: tuple[tuple[str, str, bool, tuple[tuple[str, str], ...]], ...] = (
    ("four_people", "cam{}.avi", True, (("1", "2"), ("1", "3"), ("2", "3"))),
    ("hand_over_desk", "cam{}.mp4", False, (("0", "1"),)),
    ("man_at_desk", "cam_{}.mp4", False, (("0", "2"), ("0", "3"))),
    ("room_of_people", "walking_cam{}.npz", True, (("1", "2"), ("1", "3"))),
    ("wildtrack", "cam{}.npz", True, (("1", "2"), ("4", "5"))),
    ("pets_cameras", "cam{}.npz", True, (("1", "2"), ("4", "8"))),
)
"""Folder, file of a camera, whether these are masks, pairs."""


@cache
def _real(path: Path, masks: bool, index: int) -> Recording:
    name = path.stem.removeprefix("walking_")
    camera = path.parent / "cameras.toml"
    return epibar.record(
        path, lines=20_000, seed=index, name=name, masks=masks, intrinsics=camera, progress=False
    )


def real(data: Path) -> Iterator[Case]:
    """Pairs of the real recordings that are there; one of each folder without matrices and by lines."""
    for folder, pattern, masks, pairs in REAL:
        first = data / folder / pattern.format(pairs[0][0])
        if not first.exists():
            print(f"{first}: not there, so {folder} is skipped")
            continue
        for number, (a, b) in enumerate(pairs):

            def recorded(
                a: str = a, b: str = b, folder: str = folder, pattern: str = pattern, masks: bool = masks
            ) -> Any:
                files = (data / folder / pattern.format(camera) for camera in (a, b))
                return tuple(_real(file, masks, index) for index, file in enumerate(files))

            yield Case(f"{folder} {a}-{b}", recorded, {}, folder == "four_people" and number == 0)
            if number == 0:
                yield Case(f"{folder} {a}-{b}, no matrices", recorded, {"essential": False})
                yield Case(f"{folder} {a}-{b}, lines", recorded, {"method": "lines"})


# --- exact values ---


def _exact(value: Any) -> Any:
    """A value as JSON that is equal where the value is the same in every bit."""
    if isinstance(value, np.ndarray):
        return value.tolist() if value.ndim == 0 else [_exact(part) for part in value]
    if isinstance(value, (float, np.floating)):
        return float(value).hex()
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, dict):
        return {key: _exact(value[key]) for key in sorted(value)}
    if isinstance(value, (list, tuple)):
        return [_exact(part) for part in value]
    if hasattr(value, "__dataclass_fields__"):
        return {name: _exact(getattr(value, name)) for name in sorted(value.__dataclass_fields__)}
    if value is None or isinstance(value, str):
        return value
    raise TypeError(f"{type(value).__name__} has no exact form")


def _hash(value: Any) -> str:
    return hashlib.sha256(json.dumps(_exact(value)).encode()).hexdigest()[:16]


def _hash_arrays(arrays: dict[str, np.ndarray]) -> str:
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype} {array.shape}".encode() + array.tobytes())
    return digest.hexdigest()[:16]


def results_of(case: Case | NetworkCase) -> dict[str, Any]:
    """Record and calibrate; everything that came out, exactly, and in a word what that is."""
    return network_results(case) if isinstance(case, NetworkCase) else pair_results(case)


def network_results(case: NetworkCase) -> dict[str, Any]:
    """Record and calibrate a network; every number that it holds, by camera and pair."""
    recordings = case.recordings()
    started = time.perf_counter()
    net = epibar.calibrate_network(recordings, **case.options)
    found: dict[str, Any] = {"seconds": time.perf_counter() - started}
    found["recordings"] = [_hash_arrays(recording.to_arrays()) for recording in recordings.values()]
    found |= _by_camera_and_pair(net)
    accepted = len(net.cameras) - len(net.left_out)
    return {**found, "told": f"{accepted} of {len(net.cameras)} cameras, {_hash(net.as_dict())}"}


def _by_camera_and_pair(net: Network) -> dict[str, Any]:
    content = net.as_dict()
    cameras, pairs = content.pop("cameras"), content.pop("pairs")
    found = {name: _exact(value) for name, value in content.items()}
    found |= {f"camera {one['name']}": _exact(one) for one in cameras}
    return found | {f"pair {one['a']} - {one['b']}": _exact(one) for one in pairs}


def pair_results(case: Case) -> dict[str, Any]:
    """Record and calibrate a pair; everything that came out, exactly."""
    recordings = case.recordings()
    started = time.perf_counter()
    cal = epibar.calibrate(*recordings, **case.options)
    found: dict[str, Any] = {"seconds": time.perf_counter() - started}
    found["recordings"] = [_hash_arrays(recording.to_arrays()) for recording in recordings]
    found |= {name: _exact(getattr(cal, name)) for name in SHOWN}
    found |= {name: _hash(getattr(cal, name)) for name in HASHED}
    frames = min(recording.frames for recording in recordings)
    if recordings[0].frames == recordings[1].frames:
        bits = [recording.barcodes[:3000] for recording in recordings]
        best = (
            epibar.match_barcodes(*bits, frames, mutual, limit) for mutual, limit in ((3, 200), (10, 10**6))
        )
        found["matches"] = [_hash(list(match)) for match in best]
    return {**found, "told": f"{cal.kind}, {_hash(cal.F)}"}


def cases(args: Any, folder: Path) -> Iterator[Case | NetworkCase]:
    """Those cases that were asked for."""
    for case in (*made_up(), *demo(folder), *real(args.data_dir)):
        if (case.quick or not args.quick) and (args.only is None or args.only in case.name):
            yield case


def differences(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """What differs between two results of one case, in words."""
    names = (old.keys() | new.keys()) - {"seconds"}
    return [
        f"{name}: {old.get(name)} -> {new.get(name)}"
        for name in sorted(names)
        if old.get(name) != new.get(name)
    ]


def main() -> None:
    parser = ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data_dir", nargs="?", type=Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--save", type=Path, metavar="FILE", help="keep the results there")
    parser.add_argument(
        "--compare", type=Path, metavar="FILE", help="hold the results against those kept there"
    )
    parser.add_argument("--quick", action="store_true", help="ten cases only")
    parser.add_argument("--only", metavar="TEXT", help="only cases with this in their name")
    args = parser.parse_args()
    kept = None if args.compare is None else json.loads(args.compare.read_text())
    results: dict[str, Any] = {}
    different = []
    with tempfile.TemporaryDirectory() as folder:
        for case in cases(args, Path(folder)):
            found = results[case.name] = results_of(case)
            line = f"{case.name}: {found['told']}, {found['seconds']:.1f} s"
            if kept is not None:
                if case.name not in kept:
                    wrong = ["no such case was kept"]
                else:
                    wrong = differences(kept[case.name], found)
                line += "; the same" if not wrong else "; DIFFERENT\n    " + "\n    ".join(wrong)
                different += [case.name] * bool(wrong)
            print(line, flush=True)
    seconds = sum(found["seconds"] for found in results.values())
    print(f"\n{len(results)} cases, {seconds:.0f} s of calibration")
    if args.save is not None:
        args.save.write_text(json.dumps(results, indent=1) + "\n")
    if kept is not None:
        before = sum(kept[name]["seconds"] for name in results if name in kept)
        print(
            f"{before:.0f} s when they were kept; {len(different)} different"
            + "".join(f"\n  {name}" for name in different)
        )
        sys.exit(bool(different))


if __name__ == "__main__":
    main()
