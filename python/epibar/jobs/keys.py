"""Keys: two runs whose keys agree would compute the same thing, so the later one need not.

A recording's key is a hash of the absolute path, size and time of change of every file it is made of, of the
camera's intrinsics, of the options, and of the versions of epibar and OpenCV. A pair's key is a hash of the
keys of its two recordings, the options and the version of epibar. The contents of videos are not hashed: that
would read every video again, to protect from an edit that keeps both size and time.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ..errors import EpibarError, is_address
from ..sources.chapters import chapter_files, has_chapters
from ..sources.images import IMAGE_SUFFIXES
from .inputs import CameraInput, PairOptions, RecordOptions

__all__ = ["clocks_key", "fingerprint", "network_key", "pair_key", "recording_key"]


def fingerprint(path: str) -> str | None:
    """Hash name, size and time of change of a file, or of every image or chapter of a folder or pattern.

    Returns
    -------
    str or None
        None where nothing can be said: there is no such file, or it is a stream.
    """
    if is_address(path):
        return None
    place = Path(path)
    try:
        if place.is_file():
            found = [place]
        elif has_chapters(path):
            found = chapter_files(path)
        elif place.is_dir():
            found = [item for item in place.iterdir() if item.suffix.lower() in IMAGE_SUFFIXES]
        elif re.search(r"%0?\d*d", place.name):
            found = [item for item in place.parent.iterdir() if item.suffix == place.suffix]
        else:
            return None
        states = [(item.name, item.stat()) for item in sorted(found)]
    except (OSError, EpibarError):
        return None
    return _digest([(name, state.st_size, state.st_mtime_ns) for name, state in states])


def recording_key(
    camera: CameraInput, options: RecordOptions, seen: Callable[[str], str | None] = fingerprint
) -> str | None:
    """Key of a camera's recording, or None where its files cannot be known again.

    Parameters
    ----------
    camera : CameraInput
        With absolute paths.
    options : RecordOptions
    seen : callable
        Fingerprint of a path, where the recording will be made.
    """
    prints = [seen(path) for path in camera.files]
    if None in prints:
        return None
    content: dict[str, Any] = {"files": camera.files, "prints": prints, "epibar": _version("epibar")}
    if not camera.is_saved(options):
        content["opencv"] = _version("opencv-python-headless")
        content["options"] = asdict(options)
    known = camera.intrinsics
    if known is not None:
        numbers = known.matrix.tolist(), known.distortions.tolist()
        content["intrinsics"] = [known.size, *numbers, known.fisheye]
    return _digest(content)


def pair_key(a: str | None, b: str | None, options: PairOptions) -> str | None:
    """Key of a pair, given those of its recordings; None where one of them has none."""
    if a is None or b is None:
        return None
    return _digest({"a": a, "b": b, "options": asdict(options), "epibar": _version("epibar")})


def clocks_key(recordings: Sequence[str | None], search_seconds: float) -> str | None:
    """Key of the clocks of all cameras, given those of their recordings; None where one of them has none."""
    if None in recordings:
        return None
    return _digest({"clocks": recordings, "seconds": search_seconds, "epibar": _version("epibar")})


def network_key(
    pairs: Sequence[str | None], names: Sequence[str], offsets: Sequence[float], lengths: Mapping[str, Any]
) -> str | None:
    """Key of a network, given those of its pairs; None where one of them has none."""
    if None in pairs:
        return None
    content = {"pairs": pairs, "names": names, "offsets": list(map(repr, offsets)), "lengths": lengths}
    return _digest({**content, "epibar": _version("epibar")})


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
