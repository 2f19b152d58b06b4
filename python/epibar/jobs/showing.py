"""How far a job is, before the eyes of somebody: bars on a terminal or in a notebook, lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any

from ..errors import printable
from .pace import JobProgress, Row

__all__ = ["Bars", "LogLines", "in_notebook", "on_terminal"]

EVERY = 30.0
"""Seconds between two lines in a log."""

MOST_ROWS = 8
"""Cameras that have a row of their own at a time: more would scroll the terminal."""

WIDEST_NAME = 24


class LogLines:
    """Which progress is worth a line in a log: one every half a minute, none of what is done before."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._written_at = clock()

    def due(self, progress: JobProgress) -> str | None:
        """Return the line that is to be written now, None where none is."""
        now = self._clock()
        if progress.share >= 1.0:
            self._written_at = now
        if now - self._written_at < EVERY:
            return None
        self._written_at = now
        return str(progress)


class Bars:
    """One bar for the whole and below it a row for each camera that is being recorded, made by tqdm.

    Parameters
    ----------
    stream : text stream, optional
        Of the terminal; stderr by default. A notebook has widgets instead, where it can show them.
    """

    def __init__(self, stream: IO[str] | None = None) -> None:
        self._stream = stream
        self._bars: list[Any] = []
        self._rows = MOST_ROWS
        self._make: Callable[..., Any] | None = None

    def __bool__(self) -> bool:
        """Whether anything is shown."""
        return bool(self._bars)

    def show(self, progress: JobProgress) -> None:
        """Show how far it is; all goes when it is done."""
        if progress.share >= 1.0:
            self.close()
            return
        if not self._bars and in_notebook():
            self._make = _widget()
            self._rows = 0 if self._make is None else MOST_ROWS  # rows need a cursor that goes up
        _, _, numbers = str(progress).removeprefix(progress.doing).partition(", ")
        lines = [(printable(progress.doing), progress.share, numbers)]
        rows = progress.rows[: self._rows]
        width = min(max((len(row.name) for row in rows), default=0), WIDEST_NAME)
        lines += [(f"  {printable(row.name):<{width}}", row.share, _rate(row)) for row in rows]
        while len(self._bars) > len(lines):
            self._bars.pop().close()
        for place, (before, share, after) in enumerate(lines):
            drawn = f"{_plain(before)} {{bar}} {_plain(after)}"
            if place == len(self._bars):
                self._bars.append(self._bar(place, share, drawn))
                continue
            bar = self._bars[place]
            bar.bar_format, bar.n = drawn, share
            bar.refresh()

    def close(self) -> None:
        """Take all away."""
        while self._bars:
            self._bars.pop().close()

    def write(self, text: str, stream: IO[str]) -> None:
        """Print a line above the bars."""
        if self._bars and self._make is None:
            from tqdm import tqdm

            tqdm.write(text, file=stream)
        else:
            print(text, file=stream)
        stream.flush()

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Take the bars away while somebody else writes to their terminal."""
        if not self._bars or self._make is not None:
            yield
            return
        from tqdm import tqdm

        with tqdm.external_write_mode(file=self._stream or sys.stderr):
            yield

    def _bar(self, place: int, share: float, drawn: str) -> Any:
        usual: dict[str, Any] = {"total": 1.0, "initial": share, "bar_format": drawn, "leave": False}
        if self._make is not None:
            return self._make(**usual)
        from tqdm import tqdm

        return tqdm(**usual, file=self._stream or sys.stderr, dynamic_ncols=True, position=place)


def on_terminal() -> bool:
    """Whether stderr is a terminal; programs without a console have none."""
    return sys.stderr is not None and sys.stderr.isatty()


def in_notebook() -> bool:
    """Whether this runs in a kernel of Jupyter."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def _widget() -> Callable[..., Any] | None:
    """The bar of notebooks, None where ipywidgets is not installed."""
    from tqdm import notebook

    return None if getattr(notebook, "IProgress", None) is None else notebook.tqdm


def _plain(text: str) -> str:
    """Text in which a format finds no fields."""
    return text.replace("{", "{{").replace("}", "}}")


def _rate(row: Row) -> str:
    rate = "" if row.frames_per_second is None else f", {row.frames_per_second:.0f} frames/s"
    return f"{100 * row.share:3.0f} %{rate}" if row.share else rate.removeprefix(", ")
