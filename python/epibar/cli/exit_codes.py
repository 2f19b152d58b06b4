"""What a command's exit code says."""

__all__ = [
    "BUG",
    "CHECK_EXPLANATION",
    "DONE",
    "EXPLANATION",
    "INTERRUPTED",
    "MOVED",
    "PARTLY",
    "UNUSABLE",
    "exit_code",
]

DONE = 0
"""Also where a pair was refused: that is a result, not a failure."""
BUG = 1
"""What Python exits with after a traceback."""
UNUSABLE = 2
"""Nothing was done: an argument, or every input, is unusable."""
PARTLY = 3
"""Some cameras or pairs could not be done; the others are written."""
MOVED = 4
"""A camera has moved, cannot be judged, or is none of the network's.

Not 1, with which Python ends on a bug: no news of a camera."""
INTERRUPTED = 130

EXPLANATION = (
    "Exit codes: 0 done (a refused pair is a result too: read its verdict); 2 unusable input, nothing was "
    "done; 3 a camera or a pair could not be done, the others are written; 130 interrupted."
)

CHECK_EXPLANATION = (
    "Exit codes: 0 done, and no camera has moved; 4 a camera has moved, cannot be judged, or is none of the "
    "network's; 2 unusable input, nothing was checked; 3 a video could not be read, and no other camera has "
    "moved; 130 interrupted. With --update a camera that was updated counts as one that has not moved, and "
    "one that was added as one of the network's. A scheduled job should tell of anything but 0."
)


def exit_code(done: int, failed: int) -> int:
    """Exit code of a command that did so many things, and failed at so many."""
    if not failed:
        return DONE
    return PARTLY if done else UNUSABLE
