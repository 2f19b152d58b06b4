"""What a command's exit code says."""

__all__ = [
    "BUG",
    "DONE",
    "EXPLANATION",
    "INTERRUPTED",
    "MOVED",
    "PARTLY",
    "UNUSABLE",
    "exit_code",
    "explanation",
]

DONE = 0
"""Also where a pair was refused: that is a result, not a failure."""
BUG = 1
"""What Python exits with after a traceback."""
UNUSABLE = 2
"""Nothing came of it: an argument, or every input, is unusable."""
PARTLY = 3
"""Some cameras or pairs could not be done, or the network not be made or written; the others are."""
MOVED = 4
"""A camera has moved, cannot be judged, or is none of the network's.

Not 1, with which Python ends on a bug: no news of a camera."""
INTERRUPTED = 130


def explanation(done: str = "done", partly: str = "", moved: str = "", more: str = "") -> str:
    """Say what the exit codes of a command mean; those of which nothing is said are none of it."""
    meanings = [
        (DONE, done),
        (UNUSABLE, "unusable input, nothing came of it"),
        (PARTLY, partly),
        (MOVED, moved),
        (INTERRUPTED, "interrupted"),
    ]
    codes = "; ".join(f"{code} {meaning}" for code, meaning in meanings if meaning)
    return f"Exit codes: {codes}. {more}".rstrip()


EXPLANATION = explanation()
"""Of a command that does one thing."""


def exit_code(done: int, failed: int) -> int:
    """Exit code of a command that did so many things, and failed at so many."""
    if not failed:
        return DONE
    return PARTLY if done else UNUSABLE
