"""Whether the camera stood still, the light stayed on and every frame was a new one.

:mod:`epibar.health.camera_motion` follows the corners. The light is measured on the image averaged over 8x8
pixels, where noise must not look like a change: in horizontal bands, because a rolling shutter under
flickering light brightens some rows and darkens others, and by the middle half of the differences to the
first frame in each band, because that half is background unless a band is full of people.

A flooded frame, more than 60 % foreground, tells nothing about what moves: it is blanked.
"""

from __future__ import annotations

import numpy as np

from .. import _core
from ..arguments import AnyArray, Image, Mask, core_errors
from ..foreground.flooding import FLOOD_SHARE, moving_share
from ..sources.quiet_opencv import opencv
from .camera_findings import camera_findings
from .camera_motion import CameraMotion

__all__ = ["CameraHealth", "flicker"]

BRIGHTNESS_JUMP = 8
"""Grey levels by which half of the pixels change, or more, from one frame to the next."""
FLICKER_WINDOW = 15
"""Frames: what changes slower than this is daylight, not flicker."""
DARK_CONTRAST = 3.0
"""Standard deviation over the image, grey levels, below which there is nothing to be seen."""


class CameraHealth:
    """Watch the frames and masks of one camera as they stream by.

    Parameters
    ----------
    name : str
        Put before every warning.
    every : int
        Frames between two checks for camera motion.
    ignore : ndarray, shape (H, W), optional
        Non-zero where motion does not count.

    Attributes
    ----------
    frames : int
        Number of frames seen.
    blanked : int
        Number of flooded frames.
    light_switches : list of int
        Frames at which the light jumped.
    motion : CameraMotion
    """

    def __init__(self, name: str = "camera", every: int = 10, ignore: Mask | None = None) -> None:
        self.name = name
        self.every = max(1, every)
        self.frames = 0
        self.blanked = 0
        self.light_switches: list[int] = []
        self._counted = None if ignore is None else np.asarray(ignore) == 0
        self._counted_sparsely: Mask | None = None
        self.motion = CameraMotion(self._counted)
        self._first_blanked = -1
        self._first: Image | None = None
        self._sparse: Image | None = None
        self._levels: list[AnyArray] = []
        self._dark = 0
        self._repeated = 0
        self._longest_repeat = (0, -1)
        self._last_index = -1

    @property
    def moved_at(self) -> int | None:
        """First frame at which the camera was seen displaced."""
        return self.motion.moves[0].frame if self.motion.moves else None

    @property
    def displacement(self) -> float:
        """By how many pixels, then; infinite where the view is another one."""
        return self.motion.moves[0].distance if self.motion.moves else 0.0

    def update(self, index: int, frame: Image, mask: Mask) -> AnyArray:
        """Look at one frame.

        Parameters
        ----------
        index : int
            Frame number.
        frame : ndarray, shape (H, W, 3), uint8
            BGR, as decoded.
        mask : ndarray, shape (H, W), uint8
            Its foreground.

        Returns
        -------
        ndarray, shape (H, W), uint8
            The mask, or an empty one for a flooded frame.
        """
        self.frames += 1
        self._last_index = index
        is_dark = self._watch_light(index, frame)
        # Where nothing is to be seen nobody can say whether the camera stands.
        if (self.frames - 1) % self.every == 0 and not is_dark:
            self.motion.look(index, frame)
        if moving_share(mask, self._counted) <= FLOOD_SHARE:
            return mask
        if self.blanked == 0:
            self._first_blanked = index
        self.blanked += 1
        return np.zeros_like(mask)

    def count(self, counted: Mask | None) -> None:
        """Take some pixels, (H, W) bool, for those that a flood or another light changes; None is all."""
        self._counted, self._counted_sparsely = counted, None

    def _watch_light(self, index: int, frame: Image) -> bool:
        """Look at the light of a frame, and tell whether there is next to none."""
        sparse = _shrunk_green(frame)
        counted = self._counted_sparsely
        if self._counted is not None and counted is None:
            nearest = opencv().INTER_NEAREST
            every = self._counted.astype(np.uint8)
            counted = opencv().resize(every, sparse.shape[::-1], interpolation=nearest)
            self._counted_sparsely = counted
        is_first = self._first is None
        first = sparse if self._first is None else self._first
        before = sparse if self._sparse is None else self._sparse
        with core_errors():
            variance, changed, jumped, compared, levels = _core.compare_light(
                sparse, before, first, BRIGHTNESS_JUMP, counted
            )
        is_dark = variance < DARK_CONTRAST**2
        self._dark += is_dark
        if is_first:
            self._first = sparse
        else:
            self._repeated = 0 if changed else self._repeated + 1
            # Counting is quicker than the median, and mostly answers it.
            if compared and 2 * jumped >= compared:
                change = opencv().absdiff(sparse, before)
                if np.median(change if counted is None else change[counted > 0]) > BRIGHTNESS_JUMP:
                    self.light_switches.append(index)
            self._longest_repeat = max(
                self._longest_repeat, (self._repeated, index - self._repeated), key=lambda run: run[0]
            )
        self._levels.append(levels)
        self._sparse = sparse
        return is_dark

    @property
    def numbers(self) -> dict[str, float]:
        """What was found so far, as a :class:`~epibar.Recording` keeps it; see `camera_findings`."""
        if not self.frames:
            return {}
        motion = self.motion
        found: dict[str, float] = {
            "frames": self.frames,
            "last_frame": self._last_index,
            "blanked": self.blanked,
            "first_blanked": self._first_blanked,
            "light_switches": len(self.light_switches),
            "first_light_switch": self.light_switches[0] if self.light_switches else -1,
            "flicker": flicker(np.array(self._levels)),
            "dark": self._dark,
            "repeated": self._longest_repeat[0],
            "repeated_from": self._longest_repeat[1],
            "motion_checks": motion.checks,
            "shaken": motion.shaken,
            "moves": len(motion.moves),
        }
        if motion.moves:
            first = motion.moves[0]
            still = [*motion.stretches[-1]]
            if motion.checks and still[1] > self._last_index - self.every:
                still[1] = self._last_index
            longest = max([*motion.stretches[:-1], still], key=lambda part: part[1] - part[0])
            found |= {
                "moved_at": first.frame,
                "still_until": first.still_until,
                "moved_by": first.distance,
                "moved_in_all": sum(move.distance for move in motion.moves),
                "gradual": sum(move.gradual for move in motion.moves),
                "returned_at": -1 if motion.returned_at is None else motion.returned_at,
                "still_first": longest[0],
                "still_last": longest[1],
            }
        return {key: float(value) for key, value in found.items()}

    @property
    def warnings(self) -> list[str]:
        """Plain-English remarks about what was seen so far."""
        return [f"{self.name}: {finding.text}" for finding in camera_findings(self.numbers)]


def flicker(levels: AnyArray) -> float:
    """Measure by how much the light goes up and down from frame to frame.

    Parameters
    ----------
    levels : ndarray, shape (T, bands)
        Brightness of each band of the image over time.

    Returns
    -------
    float
        Robust standard deviation around the moving median, grey levels; the median over the bands.
    """
    if len(levels) < 2 * FLICKER_WINDOW:
        return 0.0
    slow = np.median(np.lib.stride_tricks.sliding_window_view(levels, FLICKER_WINDOW, axis=0), axis=-1)
    half = FLICKER_WINDOW // 2
    fast = levels[half : half + len(slow)] - slow
    return float(1.4826 * np.median(np.median(np.abs(fast), axis=0)))


def _shrunk_green(frame: Image) -> Image:
    """Mean green of each 8x8 pixels of a BGR frame, or of a little more where a side is no multiple of 8."""
    height, width = frame.shape[:2]
    if height % 8 == 0 and width % 8 == 0:
        with core_errors():
            return _core.shrunk_green(np.ascontiguousarray(frame))
    cv2 = opencv()
    size = max(1, width // 8), max(1, height // 8)
    small: Image = cv2.resize(cv2.extractChannel(frame, 1), size, interpolation=cv2.INTER_AREA)
    return small
