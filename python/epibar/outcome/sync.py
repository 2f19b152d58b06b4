"""Videos cut to a common start: what to keep of each, as a table, and a command line that does it."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import is_address, printable
from ..files.calibration_json import read_json
from ..files.csv_table import csv_text, write_csv_table
from ..network.result import Network
from ..network.start_times import StartTime
from ..sources.images import IMAGE_SUFFIXES
from ..sources.mask_array_file import ARRAY_SUFFIXES
from ..sources.source import is_pattern
from .recordings import recording_of
from .stored import entries

__all__ = ["CameraStart", "camera_starts", "cut_command", "starts_of_run", "write_starts"]

COLUMNS = (
    *("camera", "file", "offset_seconds", "offset_frames", "drift_ppm", "error_seconds", "fps"),
    *("first_frame", "first_second", "last_frame", "last_second", "command"),
)

MARGIN = 0.25
"""Of a frame: by so much the cut is wider than from the first frame to the last."""


@dataclass(frozen=True)
class CameraStart:
    """A row of the table.

    Attributes
    ----------
    name : str
    file : str
        As it was given, without passwords.
    time : StartTime
    command : str or None
        For a POSIX shell: cuts the video, into the folder where it is run. None where the source is no video
        file, or its name holds what no line can.
    absent : bool
        Whether there is none because the video is not where it was.
    """

    name: str
    file: str
    time: StartTime
    command: str | None
    absent: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return it as ``epibar sync --json`` prints it."""
        return {"name": self.name, "file": self.file, **asdict(self.time), "command": self.command}


def cut_command(source: str, output: str, time: StartTime) -> str | None:
    """Return the command that cuts a video to the common start and end, for a POSIX shell.

    It seeks a quarter of a frame ahead of the first frame to keep, so that rounding cannot lose it, and
    decodes: a copy of the stream could start at key frames only. None for what is no single video file, and
    for a path that holds control characters.
    """
    suffix = Path(source).suffix.lower()
    if is_address(source) or suffix in {*IMAGE_SUFFIXES, *ARRAY_SUFFIXES} or "%" in Path(source).name:
        return None
    if os.path.isdir(source) or is_pattern(source) or printable(source) != source or "\n" in source:
        return None
    margin = MARGIN / time.fps
    start = max(time.first_second - margin, 0.0)
    command = ["ffmpeg", "-nostdin", "-n", "-ss", f"{start:.6f}"]
    if time.last_second is not None:
        command += ["-t", f"{time.last_second + margin - start:.6f}"]
    # Without `file:` a colon in a path would make a protocol of what is before it.
    command += ["-i", f"file:{os.path.abspath(source)}"]
    return shlex.join([*command, "-c:v", "libx264", "-crf", "18", output])


def camera_starts(times: Mapping[str, StartTime], sources: Mapping[str, str]) -> list[CameraStart]:
    """Put start times and the videos of the cameras together."""
    outputs = _outputs(times)
    return [
        CameraStart(name, sources[name], time, cut_command(sources[name], outputs[name], time))
        for name, time in times.items()
    ]


def _outputs(names: Iterable[str]) -> dict[str, str]:
    """Name a file for each camera: plain names, no two alike, none that a program takes for an option."""
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"[^\w.-]+", "_", name).lstrip("-.") or "camera"
        taken = {one.casefold() for one in found.values()}
        number, output = 1, f"{plain}_sync.mp4"
        while output.casefold() in taken:
            number += 1
            output = f"{plain}_{number}_sync.mp4"
        found[name] = output
    return found


def write_starts(path: str | os.PathLike[str], starts: Iterable[CameraStart]) -> None:
    """Write the table as CSV; what a spreadsheet would take for a formula has an apostrophe before it.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """
    write_csv_table(path, COLUMNS, (_row(one) for one in starts))


def _row(one: CameraStart) -> list[object]:
    time = one.time
    return [
        csv_text(one.name),
        csv_text(one.file),
        f"{time.offset:.6f}",
        f"{time.offset_frames:.4f}",
        f"{time.drift:.3f}",
        "" if time.error is None else f"{time.error:.6f}",
        f"{time.fps:.6f}",
        time.first_frame,
        f"{time.first_second:.6f}",
        "" if time.last_frame is None else time.last_frame,
        "" if time.last_second is None else f"{time.last_second:.6f}",
        one.command or "",
    ]


def starts_of_run(folder: str | os.PathLike[str], network: Network) -> list[CameraStart]:
    """Return what to keep of each video of a run that is done.

    Raises
    ------
    EpibarError
        A file of the run is missing or damaged, or no moment is common to all cameras.
    """
    path = Path(folder) / "calibration.json"
    sources, recordings = {}, {}
    for entry in entries(path, read_json(path), "cameras"):
        name = entry.text("name")
        if name not in network.cameras or not network.cameras[name].accepted:
            continue
        sources[name] = entry.text("file")
        recordings[name] = recording_of(path.parent, entry)
    starts = camera_starts(network.start_times(recordings), sources)
    return [
        one if one.command is None or os.path.exists(one.file) else replace(one, command=None, absent=True)
        for one in starts
    ]
