"""Put the page together, within its size."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from ..errors import EpibarError
from ..files.atomic import write_atomically
from ..files.json_values import plain
from ..show.colours import HEX
from .inputs import ReportCamera, ReportPair
from .overview import camera_cards, error_list, legend, matrix, summary
from .payload import camera_entry, pair_entries
from .pictures import data_url, heat_picture, read_frames

__all__ = ["SIZE_LIMIT", "write_report"]

SIZE_LIMIT = 15_000_000
"""Bytes. Pictures get what everything else leaves."""

LEAST_FOR_PICTURES = 2_000_000
"""Bytes, even where many cameras leave less below the limit."""

MOST_PER_PICTURE = 160_000
CARD_RESERVE = 80_000
BESIDE = 3
"""Cameras that fit beside the matrix of their pairs."""

SCRIPTS = ("geometry.js", "dom.js", "view.js", "viewer.js", "chart.js", "charts.js", "pair.js", "page.js")


def write_report(
    path: str | os.PathLike[str],
    cameras: Sequence[ReportCamera],
    pairs: Sequence[ReportPair],
    errors: Sequence[str] = (),
) -> Path:
    """Write the report of a calibration as one HTML file.

    Parameters
    ----------
    path : str or path
        The file to write.
    cameras : sequence of ReportCamera
        Their names differ.
    pairs : sequence of ReportPair
        Of those cameras, refused ones too.
    errors : sequence of str
        What could not be done, in plain English.

    Returns
    -------
    Path
        The file written: below 15 MB for up to a few dozen pairs.

    Raises
    ------
    EpibarError
        Two cameras of one name, a pair of an unknown camera, or the file cannot be written.
    """
    names = [camera.name for camera in cameras]
    for name in names:
        if names.count(name) > 1:
            raise EpibarError(f"report: two cameras are called {name!r}")
    for pair in pairs:
        for name in (pair.a, pair.b):
            if name not in names:
                raise EpibarError(f"report: the pair {pair.a} - {pair.b} is of an unknown camera, {name!r}")
    data, pictures = _data(cameras, pairs)
    page = _render(cameras, pairs, errors, data, pictures)
    target = Path(path)
    write_atomically(target, lambda stream: stream.write(page.encode("utf-8", "backslashreplace")))
    return target


def _data(cameras: Sequence[ReportCamera], pairs: Sequence[ReportPair]) -> tuple[dict[str, Any], list[bytes]]:
    """Collect the payload of the scripts, frames included, and the picture of each camera's card."""
    entries, wanted = pair_entries(cameras, pairs)
    data: dict[str, Any] = {
        "colours": HEX,
        "cameras": [camera_entry(camera, wanted[camera.name]) for camera in cameras],
        "pairs": entries,
    }
    rest = len(_render(cameras, pairs, (), data, [b""] * len(cameras))) + CARD_RESERVE * (len(cameras) + 1)
    left = max(LEAST_FOR_PICTURES, SIZE_LIMIT - rest)
    budget = min(MOST_PER_PICTURE, left * 3 // 4 // max(1, sum(map(len, wanted.values()))))
    cards = []
    for camera, entry in zip(cameras, data["cameras"], strict=True):
        frames = read_frames(camera, wanted[camera.name], budget)
        entry["images"] = {str(frame): data_url(jpeg) for frame, jpeg in frames.items()}
        cards.append(heat_picture(camera.recording, next(iter(frames.values()), None)))
    return data, cards


def _render(
    cameras: Sequence[ReportCamera],
    pairs: Sequence[ReportPair],
    errors: Sequence[str],
    data: dict[str, Any],
    cards: Sequence[bytes],
) -> str:
    from plotly.offline import get_plotlyjs

    text = json.dumps(plain(data), allow_nan=False, separators=(",", ":"))
    return Template(_asset("page.html")).substitute(
        title=escape("epibar: " + ", ".join(camera.name for camera in cameras)),
        style=_asset("style.css"),
        summary=escape(summary(cameras, pairs, errors)),
        errors=error_list(errors),
        many=" many" if len(cameras) > BESIDE else "",
        cameras=camera_cards(cameras, cards),
        matrix=matrix(cameras, pairs),
        legend=legend(),
        data=text.replace("<", "\\u003c"),
        scripts="".join(_asset(name) for name in SCRIPTS),
        plotly=get_plotlyjs().replace("</script", "<\\/script"),
    )


def _asset(name: str) -> str:
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
