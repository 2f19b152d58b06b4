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
from .inputs import NetworkReport, ReportCamera, ReportPair
from .network_table import network_section, no_network_note
from .overview import camera_cards, error_list, legend, matrix, summary
from .payload import camera_entry, pair_entries
from .pictures import data_url, heat_picture, pictures_within
from .prose import pairs_pixels
from .space_payload import space_entry

__all__ = ["SIZE_LIMIT", "write_report"]

SIZE_LIMIT = 15_000_000
"""Bytes. Pictures get what everything else leaves."""

LEAST_FOR_PICTURES = 2_000_000
"""Bytes, even where many cameras leave less below the limit."""

MOST_PER_PICTURE = 160_000
CARD_RESERVE = 80_000
PAIRS_NOTE = "That one is refused here does not speak against the network, which weighs all of them."

BESIDE = 3
"""Cameras that fit beside the matrix of their pairs."""

SCRIPTS = (
    *("geometry.js", "dom.js", "orbit.js", "space.js", "view.js", "viewer.js"),
    *("chart.js", "charts.js", "pair.js", "page.js"),
)


def write_report(
    path: str | os.PathLike[str],
    cameras: Sequence[ReportCamera],
    pairs: Sequence[ReportPair],
    errors: Sequence[str] = (),
    network: NetworkReport | None = None,
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
    network : NetworkReport, optional
        With which the report opens.

    Returns
    -------
    Path
        The file written: below 15 MB for up to a few dozen pairs, below 25 MB for the 190 of 20 cameras.

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
    shown = network or NetworkReport()
    data, pictures = _data(cameras, pairs, shown)
    page = _render(cameras, pairs, errors, shown, data, pictures)
    target = Path(path)
    write_atomically(target, lambda stream: stream.write(page.encode("utf-8", "backslashreplace")))
    return target


def _data(
    cameras: Sequence[ReportCamera], pairs: Sequence[ReportPair], shown: NetworkReport
) -> tuple[dict[str, Any], list[bytes]]:
    """Collect the payload of the scripts, frames included, and the picture of each camera's card."""
    entries, wanted = pair_entries(cameras, pairs)
    data: dict[str, Any] = {
        "colours": HEX,
        "cameras": [camera_entry(camera, wanted[camera.name]) for camera in cameras],
        "pairs": entries,
        "space": None if shown.network is None else space_entry(shown.network, pairs, shown.tracks),
    }
    rest = len(_render(cameras, pairs, (), shown, data, [b""] * len(cameras))) + CARD_RESERVE * (
        len(cameras) + 1
    )
    left = max(LEAST_FOR_PICTURES, SIZE_LIMIT - rest)
    budget = min(MOST_PER_PICTURE, left * 3 // 4 // max(1, sum(map(len, wanted.values()))))
    cards = []
    for camera, entry in zip(cameras, data["cameras"], strict=True):
        frames = pictures_within(camera.pictures, wanted[camera.name], budget)
        entry["images"] = {str(frame): data_url(jpeg) for frame, jpeg in frames.items()}
        cards.append(heat_picture(camera.recording, next(iter(frames.values()), None)))
    return data, cards


def _render(
    cameras: Sequence[ReportCamera],
    pairs: Sequence[ReportPair],
    errors: Sequence[str],
    shown: NetworkReport,
    data: dict[str, Any],
    cards: Sequence[bytes],
) -> str:
    from plotly.offline import get_plotlyjs

    text = json.dumps(plain(data), allow_nan=False, separators=(",", ":"))
    return Template(_asset("page.html")).substitute(
        title=escape("epibar: " + ", ".join(camera.name for camera in cameras)),
        style=_asset("style.css"),
        summary=escape(summary(cameras, pairs, errors, shown.network)),
        errors=error_list(errors),
        **_headings(shown, cameras),
        many=" many" if len(cameras) > BESIDE else "",
        cameras=camera_cards(cameras, cards),
        matrix=matrix(cameras, pairs),
        legend=legend(),
        data=text.replace("<", "\\u003c"),
        scripts="".join(_asset(name) for name in SCRIPTS),
        plotly=get_plotlyjs().replace("</script", "<\\/script"),
    )


def _headings(shown: NetworkReport, cameras: Sequence[ReportCamera]) -> dict[str, str]:
    """What the page says otherwise where there is a network."""
    network = shown.network
    if network is None:
        return {
            "heading": "Epipolar geometry",
            "network": no_network_note(shown.reason),
            "pairs_title": "Pairs",
            "pairs_note": "",
            "cameras_title": "Cameras",
            "scripted": "The views of each pair",
        }
    return {
        "heading": "Camera network",
        "network": network_section(network, shown.tracks),
        "pairs_title": "Pairs, each by itself",
        "pairs_note": f'<p class="caption">{escape(pairs_pixels(cameras))} {PAIRS_NOTE}</p>',
        "cameras_title": "What was filmed",
        "scripted": "The network in space and the views of each pair",
    }


def _asset(name: str) -> str:
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
