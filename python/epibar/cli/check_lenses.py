"""Lenses that are taken out of new footage, before it is held against a network."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from ..jobs.inputs import CameraInput, RecordOptions
    from ..lens.intrinsics import Intrinsics
    from ..network.result import Network
    from ..outcome.run import Run
    from ..recording import Recording

__all__ = ["FootageLenses"]


@dataclass(frozen=True)
class FootageLenses:
    """What is done about the lenses of cameras that are in a network.

    Attributes
    ----------
    taken_out : mapping of str to Intrinsics
        Those of cameras that the network has in undistorted pixels: of the file that is given, or else those
        that were taken out when it was calibrated.
    unknown : collection of str
        Cameras that it has in undistorted pixels and whose lens nothing tells. Only a recording without that
        lens can be held against them.
    warnings : sequence of str
        What of the file is of no use.
    """

    taken_out: Mapping[str, Intrinsics]
    unknown: Collection[str] = ()
    warnings: Sequence[str] = ()

    @classmethod
    def of(
        cls, folder: Path, network: Network, given: str | None, names: Sequence[str], new: Sequence[str]
    ) -> FootageLenses:
        """Find the lenses of cameras of a network; ``new`` are those that it does not have.

        Raises
        ------
        EpibarError
            A file cannot be read, or the one that is given has none of the cameras.
        """
        import numpy as np

        from ..lens.cameras_toml import load_cameras
        from ..outcome.run import Run

        made = Run.load(folder) if (folder / "calibration.json").exists() else None
        of_run = {} if made is None else made.by_name
        straight = [
            name
            for name in names
            if network.cameras[name].undistorted or (name in of_run and of_run[name].matrix is not None)
        ]
        found: dict[str, Intrinsics] = {}
        warnings: list[str] = []
        if given is not None:
            found, warnings = _in_file(given, load_cameras(given), names, new, network)
            if made is not None:
                vain = [name for name in found if name not in straight]
                found = {name: lens for name, lens in found.items() if name in straight}
                if vain:
                    text = f"{given} is not used for {', '.join(vain)}: the network found their lenses itself"
                    warnings.append(text)
        known = {name: lens for name in straight if (lens := network.cameras[name].lens) is not None}
        found = {**known, **found}
        missing = [name for name in straight if name not in found]
        if made is not None and missing:
            of_file = _of_run(made, [name for name in of_run if name not in missing])
            found |= {name: of_file[name] for name in missing if name in of_file}
        # One with distortions of its own is in pixels of the video.
        unknown = [
            name for name in missing if name not in found and not np.any(network.cameras[name].distortions)
        ]
        return cls(found, unknown, warnings)

    def refuse_videos(self, cameras: Sequence[CameraInput], options: RecordOptions) -> None:
        """Check that no lens is missing that is to be taken out of a video.

        Raises
        ------
        EpibarError
            One is.
        """
        for camera in cameras:
            if camera.name in self.unknown and not camera.is_saved(options):
                _refuse(camera.name)

    def refuse_raw(self, name: str, recording: Recording) -> None:
        """Check that a recording without its lens is one.

        Raises
        ------
        EpibarError
            It is not.
        """
        if name in self.unknown and recording.matrix is None:
            _refuse(name)


def _refuse(name: str) -> None:
    from ..errors import EpibarError

    raise EpibarError(
        f"{name}: the network has it in undistorted pixels, and the lens that was taken out is not known "
        "here: footage through it would look as if the camera had moved; give --intrinsics FILE.toml with "
        "the lens, or a recording that was made with it"
    )


def _in_file(
    given: str, cameras: Sequence[Intrinsics], names: Sequence[str], new: Sequence[str], network: Network
) -> tuple[dict[str, Intrinsics], list[str]]:
    """Find cameras by their names; also returns what to say of names that nobody has."""
    from ..lens.cameras_toml import find_camera

    by_name = {camera.name.casefold() for camera in cameras}
    found = {name: find_camera(cameras, name, None) for name in names if name.casefold() in by_name}
    if not found and not by_name & {name.casefold() for name in new}:
        find_camera(cameras, names[0], None)
    anywhere = {name.casefold() for name in (*network.cameras, *new)}
    strange = [camera.name for camera in cameras if camera.name.casefold() not in anywhere]
    return found, [f"{given}: no camera is called {', '.join(strange)}"] if strange else []


def _of_run(made: Run, known: Collection[str]) -> dict[str, Intrinsics]:
    """Lenses in the camera file that the run was given."""
    from ..errors import EpibarError

    try:
        return made.lenses(known=known)
    except EpibarError as error:
        raise EpibarError(f"{error}; --intrinsics says where the lenses of these cameras are") from error
