"""Tables as CSV that are safe to open in a spreadsheet, whatever cameras and files are called."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Sequence

from ..errors import printable
from .atomic import write_text

__all__ = ["csv_text", "write_csv_table"]

FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
"""What a spreadsheet takes for the start of one."""


def csv_text(name: str) -> str:
    """Return a text for a cell, an apostrophe before what a spreadsheet would take for a formula."""
    name = printable(name)  # a bare carriage return would end the row
    return f"'{name}" if name[:1] in FORMULA else name


def write_csv_table(
    path: str | os.PathLike[str], columns: Sequence[str], rows: Iterable[Sequence[object]]
) -> None:
    """Write a table, whole or not at all; texts of strangers must have gone through :func:`csv_text`.

    Raises
    ------
    EpibarError
        The file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows(rows)
    write_text(path, text.getvalue())
