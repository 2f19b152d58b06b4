"""Figures of many pairs: means, cells and tables in Markdown, and everything as JSON."""

from __future__ import annotations

import json
import math
import platform
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from epibar.files.json_values import plain


def mean(values: Iterable[float]) -> float:
    """Mean of what is not NaN; NaN of nothing."""
    kept = [value for value in values if not math.isnan(value)]
    return sum(kept) / len(kept) if kept else math.nan


def worst(values: Iterable[float]) -> float:
    """Largest of what is not NaN; NaN of nothing."""
    return max((value for value in values if not math.isnan(value)), default=math.nan)


def counted(words: Iterable[str]) -> str:
    """Words with how often each came, most frequent first."""
    return ", ".join(f"{word} {count}" for word, count in Counter(words).most_common())


def px(value: float, digits: int = 2) -> str:
    """Pixels for a table; three digits where two would hide a small error."""
    if math.isnan(value):
        return "-"
    return f"{value:.{3 if abs(value) < 0.1 else digits}f}" if math.isfinite(value) else "inf"


def percent(share: float, digits: int = 1) -> str:
    """A share for a table."""
    return "-" if math.isnan(share) else f"{100 * share:.{digits}f} %"


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Set a table in Markdown, its columns aligned; the first to the left, the others to the right."""
    cells = [list(header), *([str(cell) for cell in row] for row in rows)]
    widths = [max(3, *(len(row[column]) for row in cells)) for column in range(len(header))]

    def line(row: Sequence[str]) -> str:
        padded = [
            cell.ljust(width) if column == 0 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        return "| " + " | ".join(padded) + " |"

    rule = [("-" * width) if column == 0 else "-" * (width - 1) + ":" for column, width in enumerate(widths)]
    return "\n".join([line(cells[0]), line(rule), *map(line, cells[1:])])


def settings(args: Namespace) -> dict[str, Any]:
    """Everything that the figures depend on."""
    return {
        "command": " ".join(["python", *sys.argv]),
        "arguments": {
            key: str(value) if isinstance(value, Path) else value for key, value in vars(args).items()
        },
        "epibar": version("epibar"),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": platform.machine(),
    }


def write_json(path: Path | None, args: Namespace, outcomes: Iterable[object], summary: object) -> None:
    """Write settings, outcomes (dataclasses or dicts) and summary; NaN and infinity become null."""
    if path is None:
        return
    rows = [item if isinstance(item, dict) else asdict(item) for item in outcomes]  # type: ignore[call-overload]
    content = plain({**settings(args), "summary": summary, "outcomes": rows})
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def progress(text: str) -> None:
    """Say on stderr how far it is, so that stdout holds only results."""
    print(text, file=sys.stderr, flush=True)
