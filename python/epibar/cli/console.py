"""What the user sees: bars where somebody watches, lines where a log is written, nothing when asked."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Console"]


class Console:
    """Progress, notes and results.

    Parameters
    ----------
    quiet : bool
        Errors only.
    """

    def __init__(self, quiet: bool = False) -> None:
        self.quiet = quiet

    @property
    def interactive(self) -> bool:
        """Somebody watches a terminal and has not asked for silence."""
        return not self.quiet and sys.stderr.isatty()

    def result(self, text: str = "") -> None:
        """Print what the user asked for, on stdout."""
        if not self.quiet:
            print(text, flush=True)

    def note(self, text: str) -> None:
        """Print what is going on, on stderr."""
        if not self.quiet:
            print(text, file=sys.stderr, flush=True)

    def warning(self, text: str) -> None:
        """Print what may spoil the result, on stderr."""
        self.note(f"epibar: warning: {text}")

    def error(self, text: str) -> None:
        """Print what went wrong, on stderr, always."""
        print(f"epibar: error: {text}", file=sys.stderr, flush=True)

    @contextmanager
    def stages(self, title: str) -> Iterator[Callable[[str, float], None] | None]:
        """Show the progress of a job that reports (stage, share done)."""
        if not self.interactive:
            yield None
            return
        from tqdm import tqdm

        bar: Any = tqdm(
            total=100,
            desc=title,
            unit="%",
            file=sys.stderr,
            leave=False,
            bar_format="{l_bar}{bar}| {postfix}",
        )

        def report(stage: str, share: float) -> None:
            bar.n = round(100 * min(max(share, 0.0), 1.0))
            bar.set_postfix_str(stage)

        try:
            yield report
        finally:
            bar.close()
