"""What the property tests share: how many inputs they try, and what may come of reading one."""

import os

from hypothesis import HealthCheck, settings

import epibar
from epibar import EpibarError

MOST = int(os.environ.get("EPIBAR_FUZZ", "0"))
"""Inputs of each kind, where a long run is asked for."""


def tried(usual):
    """Settings of a test; the same inputs in every short run."""
    return settings(
        max_examples=MOST or usual,
        derandomize=not MOST,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


def load(kind, path):
    """Read a file; anything but a result and an EpibarError is a failure."""
    try:
        return kind(path)
    except EpibarError as error:
        told = str(error)
    assert 0 < len(told) < 20_000
    return None


def look(recording):
    """Use what was read, in every way that a report or a user does."""
    if recording is not None:
        assert recording.segments.shape[1] == 4
        assert str(epibar.inspect(recording))
        recording.hulls(recording.frames - 1)
        assert repr(recording)
