"""The folder of a run: one run at a time, no input in it written over, nothing deleted but what was written.

``DIR/.epibar/lock`` is held while a run works there, by the operating system: a run that is killed lets go of
it. ``DIR/.epibar/written.json`` names the files that runs have written, each before it is there.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from filelock import FileLock, Timeout

from ..errors import EpibarError, is_address
from ..files.atomic import sweep, write_text
from ..files.calibration_json import is_plain_name, read_json
from ..lens.cameras_toml import written_by_epibar
from .inputs import CAMERAS_FILE, CLOCKS_FILE, NETWORK_FILE, REPORT, RESULT

__all__ = ["Folder", "is_part_of_run"]

OWN = ".epibar"
FORMAT = 1
KEPT = ("recordings", "pictures", "pairs")
NAMED = 5
"""Files that an error names."""


def real(path: Path) -> Path:
    """Where a path leads; of links that go round in a circle, somewhere that is not there."""
    return Path(os.path.realpath(path))


def is_part_of_run(folder: Path, path: Path) -> bool:
    """Whether a run has written a file into its folder, or may yet: nobody else is to write there."""
    place, home = real(path), real(folder)
    if any(real(folder / name) in (place, *place.parents) for name in (OWN, *KEPT)):
        return True
    try:
        return any(place == home / name for name in Folder(folder).listed())
    except EpibarError:
        return False


class Folder:
    """The folder of the results of a run, held while this is entered.

    Parameters
    ----------
    path : Path
        Made if missing.

    Raises
    ------
    EpibarError
        Cannot be made or written, or another run is at work in it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._held = ExitStack()
        self._written: set[str] = set()

    def __enter__(self) -> Folder:
        own = self.path / OWN
        try:
            own.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise EpibarError(f"{self.path}: cannot be made ({error.strerror})") from error
        try:
            self._held.enter_context(FileLock(own / "lock", blocking=False))
        except Timeout:
            raise EpibarError(
                f"{self.path}: another run of epibar is at work in it; wait for its end, or give another "
                "folder"
            ) from None
        except (OSError, NotImplementedError) as error:
            reason = getattr(error, "strerror", None) or error
            raise EpibarError(f"{self.path}: cannot be locked for this run ({reason})") from error
        for folder in (self.path, own, *(self.path / name for name in KEPT)):
            sweep(folder)
        try:
            self._written = self.listed()
        except BaseException:
            self._held.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._held.close()

    @property
    def _list(self) -> Path:
        return self.path / OWN / "written.json"

    def listed(self) -> set[str]:
        """Read which files runs have written, below the folder.

        Raises
        ------
        EpibarError
            The list is damaged.
        """
        if not self._list.exists():
            return self._from_before()
        try:
            found = json.loads(self._list.read_text(encoding="utf-8"))
            names = found["files"]
            if found["format"] != FORMAT or not all(isinstance(name, str) for name in names):
                raise ValueError
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise EpibarError(
                f"{self._list}: damaged, so that nobody knows which files are epibar's; give another folder"
            ) from error
        return set(names)

    def _from_before(self) -> set[str]:
        """What a run wrote that kept no list of it."""
        try:
            result = read_json(self.path / RESULT)
        except EpibarError:
            return set()
        names = {RESULT, REPORT, CLOCKS_FILE}
        names |= {NETWORK_FILE} if isinstance(result.get("network"), dict) else set()
        names |= {CAMERAS_FILE} if written_by_epibar(self.path / CAMERAS_FILE) else set()
        for pair in result["pairs"]:
            entries = (
                [pair.get(key) for key in ("frontier_points", "picture")] if isinstance(pair, dict) else []
            )
            names |= {name for name in entries if isinstance(name, str) and is_plain_name(name)}
        return names | {f"{kept}/{file.name}" for kept in KEPT for file in (self.path / kept).glob("*.npz")}

    def refuse_inputs(self, paths: Iterable[str], written: Iterable[Path]) -> None:
        """Check that no input is where results go.

        Parameters
        ----------
        paths : iterable of str
            Every path that is read: files, folders of images, numbered patterns.
        written : iterable of Path
            Every file that may be written.

        Raises
        ------
        EpibarError
            Results would be taken for images, or would replace an input.
        """
        own = {real(self.path), *(real(self.path / name) for name in KEPT)}
        files = {real(path) for path in written}
        for path in paths:
            if is_address(path):
                continue
            place = Path(path)
            images = place.parent if re.search(r"%0?\d*d", place.name) else place
            images, place = real(images), real(place)
            if images in own:
                raise EpibarError(
                    f"{self.path}: the results would lie among the images of {path}, and be taken for some; "
                    "give another folder"
                )
            if place in files:
                raise EpibarError(f"{path}: the results would replace this input; give another folder")

    def refuse_foreign(self, written: Iterable[Path]) -> None:
        """Check that every file that may be written is not there, or was written by a run.

        Raises
        ------
        EpibarError
            Somebody else's file has the name of one.
        """
        foreign = [str(path) for path in written if os.path.lexists(path) and not self.owns(path)]
        if foreign:
            more = f" and {len(foreign) - NAMED} more" if len(foreign) > NAMED else ""
            raise EpibarError(
                f"{', '.join(foreign[:NAMED])}{more}: in the place of a result, but not written by epibar; "
                "move it away, or give another folder"
            )

    def owns(self, path: Path) -> bool:
        """Whether a run has written the file."""
        return self._name(path) in self._written

    def will_write(self, *paths: Path) -> None:
        """Note files that are about to be written.

        Raises
        ------
        EpibarError
            The list cannot be written.
        """
        written = self._written | {self._name(path) for path in paths}
        if written != self._written:
            write_text(self._list, json.dumps({"format": FORMAT, "files": sorted(written)}, indent=1))
            self._written = written  # only now: what was interrupted before is noted the next time

    def remove(self, *paths: Path) -> None:
        """Remove those of some files that a run has written; what is missing stays so.

        Raises
        ------
        EpibarError
            One cannot be removed.
        """
        for path in filter(self.owns, paths):
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise EpibarError(f"{path}: cannot be removed ({error.strerror or error})") from error

    def _name(self, path: Path) -> str:
        return path.relative_to(self.path).as_posix()
