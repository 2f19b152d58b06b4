"""``epibar inspect``: what each camera is good for, before any pairing."""

from __future__ import annotations

import json
from argparse import Namespace
from pathlib import Path
from typing import Any

from ..diagnosis import inspect
from ..errors import EpibarError
from ..intrinsics import find_camera, load_cameras
from ..recorder import record
from ..recording import Recording
from .console import Console

__all__ = ["run"]


def run(args: Namespace) -> int:
    """Run the command; every camera that can be read is inspected."""
    console = Console(args.quiet)
    for option in ("background", "ignore"):
        given = getattr(args, option)
        if given is not None and len(given) != len(args.videos):
            raise EpibarError(
                f"--{option}: {len(given)} given for {len(args.videos)} cameras; give one per camera, in "
                "their order"
            )
    known = load_cameras(args.intrinsics) if args.intrinsics else None
    entries: list[dict[str, Any]] = []
    failed = False
    for index, video in enumerate(args.videos):
        try:
            recording = _recording(index, video, known, args, console)
        except EpibarError as error:
            console.error(str(error))
            failed = True
            continue
        diagnosis = inspect(recording)
        remarks = [text for text in recording.warnings if not _told(text, diagnosis.findings)]
        entries.append({**diagnosis.as_dict(), "file": video, "warnings": remarks})
        if not args.json:
            print("\n" * (len(entries) > 1) + str(diagnosis), flush=True)
            for remark in remarks:
                print(f"  note      {remark}", flush=True)
    if args.json:
        print(json.dumps(entries, indent=1, allow_nan=False), flush=True)
    return 2 if failed else 0


def _recording(index: int, video: str, known: Any, args: Namespace, console: Console) -> Recording:
    """Record one camera, or load it where it was recorded before."""
    path = Path(video)
    name = path.resolve().name if path.is_dir() else path.stem
    if path.suffix.lower() == ".npz" and not args.masks:
        if args.frames is not None:
            raise EpibarError(f"{video}: --frames is for videos; this is recorded already")
        return Recording.load(path)
    return record(
        video,
        lines=args.lines,
        seed=args.seed,
        name=name,
        masks=args.masks,
        background=args.background[index] if args.background else None,
        foreground=args.foreground,
        intrinsics=find_camera(known, name, index) if known is not None else None,
        ignore=args.ignore[index] if args.ignore else None,
        frames=args.frames,
        progress=console.interactive,
    )


def _told(warning: str, findings: tuple[Any, ...]) -> bool:
    """Whether a warning of the recording is one of the findings already."""
    return any(warning.endswith(finding.text) for finding in findings)
