"""``epibar calibrate``: record every camera once, calibrate every pair, write what was found."""

from __future__ import annotations

import time
from argparse import Namespace
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

from ..calibration import Calibration, calibrate
from ..errors import EpibarError
from ..intrinsics import Intrinsics, find_camera, load_cameras
from ..recorder import record
from ..recording import Recording
from ..report.files import camera_entry, pair_entry, run_entry, write_frontier_points, write_json
from ..report.picture import write_pair_picture
from .console import Console

__all__ = ["Camera", "record_camera", "run"]


@dataclass
class Camera:
    """One camera of the command line."""

    name: str
    source: str
    index: int
    background: str | None = None
    ignore: str | None = None
    intrinsics: Intrinsics | None = None
    recording: Recording | None = None


def run(args: Namespace) -> int:
    """Run the command; every pair whose two cameras are usable is written."""
    console = Console(args.quiet)
    cameras = _cameras(args)
    out = Path(args.out)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EpibarError(f"--out {out}: cannot be made ({error.strerror})") from error
    result = run_entry(args)
    errors: list[dict[str, Any]] = result["errors"]

    def failed(error: EpibarError, **where: str) -> None:
        console.error(str(error))
        errors.append({**where, "message": str(error)})

    for camera in cameras:
        try:
            camera.recording = record_camera(camera, args, console)
            result["cameras"].append(camera_entry(camera.name, camera.source, camera.index, camera.recording))
        except EpibarError as error:
            failed(error, camera=camera.name, file=camera.source)

    usable = [camera for camera in cameras if camera.recording is not None]
    for a, b in combinations(usable, 2):
        try:
            result["pairs"].append(_calibrate_pair(a, b, args, out, console))
        except EpibarError as error:
            failed(EpibarError(f"{a.name} - {b.name}: {error}"), a=a.name, b=b.name)
        write_json(
            out / "calibration.json", result
        )  # after each pair, so that an interrupted run keeps its work
    write_json(out / "calibration.json", result)
    console.note(f"written: {out / 'calibration.json'}")
    return 2 if errors else 0


def _cameras(args: Namespace) -> list[Camera]:
    """Turn the arguments into cameras; what is wrong with them is found before any work."""
    count = len(args.videos)
    if count < 2:
        raise EpibarError("VIDEO: at least two cameras are needed")
    for option in ("background", "ignore"):
        given = getattr(args, option)
        if given is not None and len(given) != count:
            raise EpibarError(
                f"--{option}: {len(given)} given for {count} cameras; give one per camera, in their order"
            )
    if count > 2 and args.time_offset not in (0.0, "search"):
        raise EpibarError(
            f"--time-offset {args.time_offset:g} with {count} cameras does not say which pair it is for; "
            "use 'search', or calibrate the pairs one by one"
        )
    resolved = [str(Path(video).resolve()) for video in args.videos]
    for video, path in zip(args.videos, resolved, strict=True):
        if resolved.count(path) > 1:
            raise EpibarError(f"{video}: given twice; a camera has no epipolar geometry with itself")
    known = load_cameras(args.intrinsics) if args.intrinsics else None
    cameras = []
    for index, (stem, video) in enumerate(zip(_names(args.videos), args.videos, strict=True)):
        cameras.append(
            Camera(
                name=stem,
                source=video,
                index=index,
                background=args.background[index] if args.background else None,
                ignore=args.ignore[index] if args.ignore else None,
                intrinsics=find_camera(known, stem, index) if known is not None else None,
            )
        )
    return cameras


def _names(videos: list[str]) -> list[str]:
    """File stems, with the folder's name before them where two are the same, then a number."""
    paths = [Path(video) for video in videos]
    names = [path.resolve().name if path.is_dir() else path.stem for path in paths]
    if len(set(names)) < len(names):
        names = [f"{path.resolve().parent.name}_{name}" for path, name in zip(paths, names, strict=True)]
    if len(set(names)) < len(names):
        names = [f"{name}_{index}" for index, name in enumerate(names)]
    return names


def record_camera(camera: Camera, args: Namespace, console: Console) -> Recording:
    """Record one camera, or load it where it was recorded before."""
    started = time.perf_counter()
    if camera.source.lower().endswith(".npz") and not args.masks:
        recording = Recording.load(camera.source)
        recording.name = camera.name
    else:
        recording = record(
            camera.source,
            lines=args.lines,
            seed=args.seed,
            name=camera.name,
            masks=args.masks,
            background=camera.background,
            foreground=args.foreground,
            intrinsics=camera.intrinsics,
            ignore=camera.ignore,
            progress=console.interactive,
        )
    for warning in recording.warnings:
        console.warning(warning if camera.name in warning else f"{camera.name}: {warning}")
    console.note(
        f"{camera.name}: {recording.frames} frames of {recording.width}x{recording.height}, "
        f"{recording.informative} of {len(recording.segments)} lines informative "
        f"({time.perf_counter() - started:.1f} s)"
    )
    return recording


def _calibrate_pair(a: Camera, b: Camera, args: Namespace, out: Path, console: Console) -> dict[str, Any]:
    """Calibrate one pair and write its picture and points; returns its entry in calibration.json."""
    assert a.recording is not None
    assert b.recording is not None
    started = time.perf_counter()
    with console.stages(f"{a.name} - {b.name}") as progress:
        calibration = calibrate(
            a.recording,
            b.recording,
            method=args.method,
            seed=args.seed,
            time_offset=args.time_offset,
            upright=not args.any_way_up,
            progress=progress,
        )
    seconds = time.perf_counter() - started
    console.result(f"{a.name} - {b.name}: {summary(calibration)} ({seconds:.1f} s)")
    points = write_frontier_points(out / f"{a.name}_{b.name}_frontier.csv", calibration)
    picture = write_pair_picture(
        out / f"{a.name}_{b.name}.png",
        (a.name, b.name),
        (a.source, b.source),
        (a.recording, b.recording),
        calibration,
        (a.intrinsics, b.intrinsics),
    )
    entry = pair_entry(a.name, b.name, calibration, seconds)
    return {**entry, "frontier_points": points.name, "picture": picture.name}


def summary(calibration: Calibration) -> str:
    """Say in one line what came out of a pair."""
    verdict = "accepted" if calibration.accepted else f"refused ({calibration.kind})"
    offset = f", time offset {calibration.time_offset:+.2f} frames" if calibration.time_offset else ""
    return f"{verdict}{offset}. {calibration.reason}"
