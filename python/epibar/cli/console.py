"""What the user sees: bars where somebody watches, lines where a log is written, nothing when asked."""

from __future__ import annotations

import sys
from typing import IO, Any

from ..jobs.watch import Watch

__all__ = ["Console"]

BAR = "{desc} {bar} {n:.1f} of {total}, {elapsed} done, about {remaining} left"
WHOLE_BAR = "{desc} {bar} {percentage:.0f} %, {elapsed} done, about {remaining} left"


class Console(Watch):
    """Progress, notes and results. Its bars are taken away when it is left as a context manager.

    Parameters
    ----------
    quiet : bool
        Errors only.
    json : bool
        Stdout is for the JSON result alone: what would be printed there goes to stderr.
    """

    def __init__(self, quiet: bool = False, json: bool = False) -> None:
        self.quiet = quiet
        self._stdout_is_taken = json
        self._bars: dict[str, Any] = {}

    def __enter__(self) -> Console:
        return self

    def __exit__(self, *_: object) -> None:
        for bar in self._bars.values():
            bar.close()
        self._bars.clear()

    @property
    def interactive(self) -> bool:
        """Somebody watches a terminal and has not asked for silence."""
        return not self.quiet and sys.stderr.isatty()

    def result(self, text: str = "") -> None:
        """Print what the user asked for, on stdout."""
        if not self.quiet:
            self._print(text, sys.stderr if self._stdout_is_taken else sys.stdout)

    def verdict(self, text: str) -> None:
        """Print what came out of a pair."""
        self.result(text)

    def json(self, text: str) -> None:
        """Print a JSON result, on stdout, however quiet."""
        print(text, flush=True)

    def note(self, text: str) -> None:
        """Print what is going on, on stderr."""
        if not self.quiet:
            self._print(text, sys.stderr)

    def warning(self, text: str) -> None:
        """Print what may spoil the result, on stderr."""
        self.note(f"epibar: warning: {text}")

    def error(self, text: str) -> None:
        """Print what went wrong, on stderr, always."""
        self._print(f"epibar: error: {text}", sys.stderr)

    def progress(self, stage: str, done: float, total: int) -> None:
        """Show how far a stage is and how long it may still take; the bar goes when it is done."""
        if not self.interactive:
            return
        if stage not in self._bars:
            from tqdm import tqdm

            self._bars[stage] = tqdm(
                total=total,
                desc=stage,
                initial=done,
                file=sys.stderr,
                leave=False,
                dynamic_ncols=True,
                bar_format=BAR if total > 1 else WHOLE_BAR,
            )
        bar = self._bars[stage]
        bar.n = min(max(done, bar.n), total)
        bar.refresh()
        if done >= total:
            bar.close()

    def _print(self, text: str, stream: IO[str]) -> None:
        """Print a line above the bars."""
        if not self._bars:
            print(text, file=stream, flush=True)
            return
        from tqdm import tqdm

        tqdm.write(text, file=stream)
        stream.flush()
