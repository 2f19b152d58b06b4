"""The one exception that epibar raises for what a user can put right."""

from __future__ import annotations


class EpibarError(ValueError):
    """A file, a value or an option is unusable; the message names it and says what to do about it."""
