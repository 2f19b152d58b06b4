"""Options that commands have in common, and how their values are read. Standard library only."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from ..errors import printable, without_secrets
from .exit_codes import EXPLANATION

__all__ = [
    "CommandParser",
    "add_output_options",
    "add_run_folder",
    "any_number",
    "frame_numbers",
    "frame_rate",
    "positive",
    "positive_pixels",
    "scheduler_address",
    "seconds",
    "seed_number",
    "time_offset",
]

VIDEOS = "videos"

NAME = "\0"
"""Before a name that begins with a dash, which argparse takes for an option. No word of a shell holds it."""


class CommandParser(argparse.ArgumentParser):
    """A parser of videos and of options with one value for each, which are not told apart by a guess.

    Such an option takes all that stands behind it. Where no video is left, all the same
    ``--background e1 --background e2 a b`` can be read in one way alone. Which of ``--background e1 a b c``
    are videos cannot be told, and is refused.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **{"epilog": EXPLANATION, **options})
        # argparse of before Python 3.14 takes -1e3 for an option.
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$", re.IGNORECASE)
        self._takes_videos = False
        self._each: dict[str, str] = {}
        self._words: Sequence[str] = ()

    def add_videos(self, purpose: str) -> None:
        """Add the argument ``VIDEO ...``."""
        self._takes_videos = True
        self.add_argument(VIDEOS, nargs="*", metavar="VIDEO", help=purpose)

    def add_for_each_video(self, group: argparse._ArgumentGroup, option: str, **options: Any) -> None:
        """Add an option that takes one value for each video, at once or one by one."""
        action = group.add_argument(option, nargs="+", action="append", **options)
        self._each[action.dest] = option

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, and give back the videos that an option took where it is certain which these are."""
        words = self._words = sys.argv[1:] if args is None else args
        found, rest = super().parse_known_args(self._with_names(words), namespace)
        if self._takes_videos:
            # What stands between and after options is a video as well.
            found.videos += [word for word in rest if not word.startswith("-")]
            rest = [word for word in rest if word.startswith("-")]
            self._give_back(found)
            if not found.videos:
                self.error("the following arguments are required: VIDEO")
        return found, rest

    def _with_names(self, words: Sequence[str]) -> list[str]:
        """Mark the names that an option takes before its last value, where they begin with a dash."""
        marked = list(words)
        for place, word in enumerate(words):
            action = self._option_string_actions.get(word)
            names = action.nargs - 1 if action is not None and isinstance(action.nargs, int) else 0
            for k in range(place + 1, min(place + 1 + names, len(words))):
                if words[k].startswith("-") and words[k] not in ("--", *self._option_string_actions):
                    marked[k] = NAME + words[k]
        return marked

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the arguments, of which some may be addresses with passwords, and exit."""
        given = [option for option in self._each.values() if option in self._words]
        if given and "arguments are required" in message:
            message += (
                f". {given[-1]} takes all that stands behind it: put it last, or end its values with --"
            )
        super().error(printable(without_secrets(message)))

    def _give_back(self, found: argparse.Namespace) -> None:
        """Make one list of what each such option took; videos that it took are given back, or refused.

        The first value behind each naming of an option is its own, and no option has more values than there
        are videos. So where as many others are left as each option was named times, those are the videos.
        """
        named = {name: groups for name in self._each if (groups := getattr(found, name))}
        behind = {name: [value for group in groups for value in group[1:]] for name, groups in named.items()}
        for name, groups in named.items():
            setattr(found, name, [value for group in groups for value in group])
        left = [name for name, values in behind.items() if values]
        if found.videos or not left:
            return
        if len(left) == 1 and all(len(groups) == len(behind[left[0]]) for groups in named.values()):
            found.videos = behind[left[0]]
            setattr(found, left[0], [group[0] for group in named[left[0]]])
            return
        took = "; ".join(f"{self._each[name]} took {', '.join(getattr(found, name))}" for name in left)
        option = self._each[left[-1]]
        others = [str(one.metavar) for one in self._get_positional_actions() if one.dest != VIDEOS]
        videos_first = " ".join([self.prog, *others, "a.mp4 b.mp4", option, "..."])
        self.error(
            f"argument VIDEO: none is left: {took}, and which of them are videos cannot be told. "
            f"Put the videos first, as in '{videos_first}', or end the values of {option} with --"
        )


def add_output_options(command: argparse.ArgumentParser, json: str | None = None) -> None:
    """Add ``-q`` and ``-v``, and ``--json`` where there is something to print."""
    group = command.add_argument_group("what is printed")
    if json is not None:
        group.add_argument("--json", action="store_true", help=json)
    how_much = group.add_mutually_exclusive_group()
    how_much.add_argument(
        "-q", "--quiet", action="store_true", help="errors only; for scripts and scheduled jobs"
    )
    how_much.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="also versions, and what results rest on; for a question or a bug report",
    )


def add_run_folder(command: argparse.ArgumentParser) -> None:
    """Add the folder of a run, which a file in it stands for."""
    command.add_argument(
        "folder", metavar="DIR", type=_run_folder, help="what was --out of 'epibar calibrate'"
    )


def _run_folder(text: str) -> str:
    if not os.path.isfile(text):
        return text
    from ..jobs.inputs import NETWORK_FILE, RESULT

    return os.path.dirname(text) or "." if os.path.basename(text) in (NETWORK_FILE, RESULT) else text


def whole(text: str) -> int:
    """Read a whole number."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None


def positive(text: str) -> int:
    """Read a whole number from 1."""
    number = whole(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{number} is too small: it must be at least 1")
    return number


def seed_number(text: str) -> int:
    """Read a seed."""
    number = whole(text)
    if not 0 <= number < 2**64:
        raise argparse.ArgumentTypeError(f"{number} is out of range: it must be between 0 and 2^64 - 1")
    return number


def frame_numbers(text: str) -> tuple[int | None, int | None]:
    """Read ``FIRST:LAST``, either of which may be left out."""
    first, colon, last = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"{text!r} is not FIRST:LAST, such as 250:1000")
    return whole(first) if first else None, whole(last) if last else None


def scheduler_address(text: str) -> str:
    """Read the address of a Dask scheduler."""
    if text == "local" or re.fullmatch(r"(tcp|tls)://[^\s/]+:\d+", text):
        return text
    raise argparse.ArgumentTypeError(f"{text!r} is neither 'local' nor an address like tcp://10.0.0.5:8786")


def seconds(text: str) -> float:
    """Read a positive number of seconds."""
    return _positive_number(text, "seconds")


def frame_rate(text: str) -> float:
    """Read a positive number of frames per second."""
    return _positive_number(text, "frames per second")


def positive_pixels(text: str) -> float:
    """Read a positive number of pixels."""
    return _positive_number(text, "pixels")


def time_offset(text: str) -> float | str:
    """Read a time offset."""
    if text in ("auto", "search"):
        return text
    value = any_number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number of frames nor 'auto' or 'search'")
    return value


def _positive_number(text: str, unit: str) -> float:
    value = any_number(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number of {unit}")
    return value


def any_number(text: str) -> float:
    """Read any number; NaN of what is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
