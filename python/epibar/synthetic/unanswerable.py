"""Families of pairs that have no answer."""

from __future__ import annotations

from collections.abc import Callable

from .situations import Situation

WITHOUT_ANSWER: dict[str, Callable[[int, str], Situation]] = {}
