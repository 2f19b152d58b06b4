"""The whole: record two videos and calibrate the pair, beside decoding them and a background model."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
from data import LINES, SIZE, Pair
from machine import Machine
from table import Stage
from timing import in_turn

import epibar
from epibar import synthetic


def whole_stages(pair: Pair, machine: Machine) -> list[Stage]:
    """Render both videos, record them, calibrate the pair."""
    with tempfile.TemporaryDirectory() as folder:
        videos = [
            synthetic.render_video(pair.scene, camera, Path(folder) / f"cam{camera + 1}.mp4", seed=1)
            for camera in range(2)
        ]
        recordings = [epibar.record(video, lines=LINES, seed=i) for i, video in enumerate(videos)]
        frames = sum(rec.frames for rec in recordings)
        busy: list[float] = []

        def record() -> None:
            cpu, started = time.process_time(), time.perf_counter()
            for video in videos:
                epibar.record(video, lines=LINES, progress=False)
            busy.append((time.process_time() - cpu) / (time.perf_counter() - started) / machine.threads)

        ways: dict[str, Callable[[], Any]] = {
            "record": record,
            "decode": lambda: [decode(video, False) for video in videos],
            "decode and MOG2": lambda: [decode(video, True) for video in videos],
            "calibrate": lambda: epibar.calibrate(*recordings),
            "lines": lambda: epibar.calibrate(*recordings, method="lines"),
        }
        seconds = in_turn(ways, rounds=2, budget=240)
        cal = epibar.calibrate(*recordings)
    both = {"decoding and MOG2 of both videos": seconds["decode and MOG2"]}
    size = f"{SIZE[0]}x{SIZE[1]}x{recordings[0].frames}"
    return [
        Stage(
            f"record, two videos {size}",
            "frames",
            frames,
            seconds["record"],
            "decoding alone",
            seconds["decode"],
            both,
            {"cores at work": f"{100 * max(busy):.0f} %"},
        ),
        Stage(
            f"calibrate, {LINES:,} lines each, method frontier",
            "pairs",
            1,
            seconds["calibrate"],
            peers=both,
            notes={
                "outcome": f"{cal.kind}, expected error {cal.expected_error}",
                "share of decoding and MOG2": f"{seconds['calibrate'] / seconds['decode and MOG2']:.2f}",
            },
        ),
        Stage(f"calibrate, {LINES:,} lines each, method lines", "pairs", 1, seconds["lines"], peers=both),
    ]


def decode(video: Path, with_model: bool) -> None:
    """What anybody needs who wants to know what moves."""
    capture = cv2.VideoCapture(str(video))
    model: Any = cv2.createBackgroundSubtractorMOG2(500, 25.0, True)
    while True:
        ok, frame = capture.read()
        if not ok:
            break
        if with_model:
            model.apply(frame)
    capture.release()
