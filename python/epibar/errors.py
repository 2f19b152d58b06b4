"""The one exception that epibar raises for what a user can put right, and what no text for people holds.

Addresses of cameras hold user names and passwords, and names of files may hold what a terminal obeys. Every
message goes through :func:`without_secrets`, and what is printed through :func:`printable`.
"""

from __future__ import annotations

import re

__all__ = ["EpibarError", "is_address", "printable", "without_secrets"]

HIDDEN = "***"
ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*://[^\s'\"<>]+")
HARMLESS = {"camera", "channel", "fps", "profile", "proto", "resolution", "stream", "subtype", "unicast"}
"""Parts of a query that tell streams of one camera apart; values of all others are hidden."""

UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Controls of terminals, marks that turn the direction of writing, and halves of characters."""


def is_address(source: str) -> bool:
    """Whether a source is an address, not a path."""
    return "://" in source


def without_secrets(text: str) -> str:
    """Return a text with user names, passwords and keys hidden in every address in it.

    Examples
    --------
    >>> without_secrets("rtsp://admin:1234@10.0.0.5/live?channel=1&token=abc: no answer")
    'rtsp://***@10.0.0.5/live?channel=1&token=***: no answer'
    """
    return ADDRESS.sub(lambda found: _hidden(found[0]), text) if "://" in text else text


def address_without_secrets(address: str) -> str:
    """Return what is one address as a whole, even where its password holds a space; a path as it is."""
    if not is_address(address):
        return address
    scheme, _, rest = address.partition("://")
    before, at, after = rest.rpartition("@")
    return _hidden(f"{scheme}://{HIDDEN if before else ''}{at}{after}")


def _hidden(address: str) -> str:
    # What ends a sentence is not part of an address.
    end = len(address.rstrip(".,;:!?)]}"))
    address, tail = address[:end], address[end:]
    scheme, _, rest = address.partition("://")
    # A password may hold what belongs encoded: all up to the last @ is hidden.
    user, at, place = rest.rpartition("@")
    place, _, query = place.partition("#")[0].partition("?")
    # Some cameras take user=..._password=... as a path.
    place = re.sub(r"=.*", f"={HIDDEN}", place)
    kept = (_value(*part.partition("=")) for part in re.split("[&;]", query)) if query else ()
    return f"{scheme}://{HIDDEN if user else ''}{at}{place}{'?' if query else ''}{'&'.join(kept)}{tail}"


def _value(key: str, sign: str, value: str) -> str:
    if not sign:
        return HIDDEN
    harmless = key.lower() in HARMLESS and re.fullmatch(r"\w{1,16}", value)
    return f"{key}={value if harmless else HIDDEN}"


def printable(text: str) -> str:
    """Return a text that no terminal obeys: control characters are spelt out, line ends are as they were."""
    return UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


class EpibarError(ValueError):
    """A file, a value or an option is unusable; the message names it and says what to do about it.

    Secrets in addresses are hidden in the message, whoever writes it.
    """

    def __init__(self, *arguments: object) -> None:
        super().__init__(*(without_secrets(part) if isinstance(part, str) else part for part in arguments))
