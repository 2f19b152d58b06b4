"""``epibar inspect``: what each camera is good for, before any pairing."""

from __future__ import annotations

import json
from argparse import Namespace
from dataclasses import replace
from typing import Any

from ..errors import EpibarError
from ..health.inspection import inspect
from ..jobs.inputs import Camera, one_each, source_name
from ..jobs.tasks import record_camera
from ..lens.camera_file import find_camera, load_cameras
from .calibrate import record_options
from .console import Console

__all__ = ["run"]


def run(args: Namespace) -> int:
    """Run the command; every camera that can be read is inspected."""
    console = Console(args.quiet)
    count = len(args.videos)
    backgrounds = one_each("--background", args.background, count)
    ignored = one_each("--ignore", args.ignore, count)
    known = load_cameras(args.intrinsics) if args.intrinsics else None
    options = record_options(args)
    entries: list[dict[str, Any]] = []
    failed = False
    for index, video in enumerate(args.videos):
        camera = Camera(source_name(video), video, index, backgrounds[index], ignored[index])
        try:
            lens = find_camera(known, camera.name, index) if known is not None else None
            recording, _ = record_camera(replace(camera, intrinsics=lens), options, console.interactive)
        except EpibarError as error:
            console.error(str(error))
            failed = True
            continue
        diagnosis = inspect(recording)
        remarks = [text for text in recording.warnings if not _told(text, diagnosis.findings)]
        entries.append({**diagnosis.as_dict(), "file": video, "warnings": remarks})
        if not args.json:
            console.result("\n" * (len(entries) > 1) + str(diagnosis))
            for remark in remarks:
                console.result(f"  note      {remark}")
    if args.json:
        console.json(json.dumps(entries, indent=1, allow_nan=False))
    return 2 if failed else 0


def _told(warning: str, findings: tuple[Any, ...]) -> bool:
    """Whether a warning of the recording is one of the findings already."""
    return any(warning.endswith(finding.text) for finding in findings)
