"""Whether the camera itself moved.

Corners of a reference frame are looked for again every few frames (Lucas-Kanade, forward and back, on an
image with its local contrast normalised, so that light matters little). A camera that moves moves every
corner, so it takes three quarters of them, three checks in a row; somebody who fills half of the picture is
not enough.

After a move the view as it then is becomes the reference, so that what follows is judged for itself: the
camera may stay, go on moving, or come back to where it was.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arguments import AnyArray, Image, Mask
from ..sources.quiet_opencv import opencv

__all__ = ["CameraMotion", "Move"]

WORKING_WIDTH = 640
NEIGHBOURHOOD = 35
"""Pixels at the working width: the square whose contrast is evened out."""
CORNERS = 300
LEAST_CORNERS = 20
LOST_SHARE = 0.9
"""Of the corners; when so many are not found again the view is another one."""
TOLERANCE = 1.0
"""Pixels at the working width."""
CONFIRMATIONS = 3
STILL_QUARTILE = 25.0
GRADUAL = 0.5
"""Of the tolerance: what was already displaced by so much at the last still check did not move at once."""


@dataclass(frozen=True)
class Move:
    """One displacement of the camera.

    Attributes
    ----------
    frame : int
        First frame at which it was seen.
    still_until : int
        Last frame at which it was looked for and not seen.
    distance : float
        Pixels of the video; infinite where the view is another one.
    gradual : bool
        It came little by little.
    """

    frame: int
    still_until: int
    distance: float
    gradual: bool


class CameraMotion:
    """Follow the corners of one camera's view.

    Parameters
    ----------
    counted : ndarray, shape (H, W), bool, optional
        Where corners count.

    Attributes
    ----------
    checks : int
        How often the view was compared.
    shaken : int
        How often it was displaced and then back at once.
    moves : list of Move
    returned_at : int or None
        Frame from which on the view is the first one again.
    stretches : list of [int, int]
        First and last frame of each part in which the camera was seen to stand still.
    """

    def __init__(self, counted: Mask | None = None) -> None:
        self.checks = self.shaken = 0
        self.moves: list[Move] = []
        self.returned_at: int | None = None
        self.stretches: list[list[int]] = []
        self._counted = counted
        self._first: _Reference | None = None
        self._reference: _Reference | None = None
        self._suspicions: list[tuple[int, AnyArray]] = []
        self._back: list[int] = []
        self._last_shift = 0.0

    def look(self, index: int, frame: Image) -> None:
        """Compare one frame, (H, W, 3) uint8 BGR, with the reference."""
        scale = min(1.0, WORKING_WIDTH / frame.shape[1])
        view = _even_contrast(frame, scale)
        if self._reference is None:
            # A black or empty frame has nothing to follow: the next one may.
            self._reference = self._first = self._referenced(view)
            if self._reference is not None:
                self.stretches.append([index, index])
            return
        self.checks += 1
        shift = self._reference.displacement(view)
        if shift <= TOLERANCE:
            self.shaken += len(self._suspicions)
            self._suspicions.clear()
            self._last_shift = shift
            self.stretches[-1][1] = index
        else:
            self._suspicions.append((index, view))
            if len(self._suspicions) == CONFIRMATIONS:
                self._confirm(index, view, shift / scale)
        self._look_for_first(index, view)

    def _confirm(self, index: int, view: Image, distance: float) -> None:
        gradual = self._last_shift > GRADUAL * TOLERANCE and np.isfinite(distance)
        self.moves.append(Move(self._suspicions[0][0], self.stretches[-1][1], distance, bool(gradual)))
        self.returned_at = None
        settled = index
        reference = self._referenced(view)
        # Where the new view has nothing to follow, the old one stays the reference: it may come back.
        if reference is not None:
            self._reference = reference
            for earlier, seen in reversed(self._suspicions):
                if reference.displacement(seen) > TOLERANCE:
                    break
                settled = earlier
        self._suspicions.clear()
        self._last_shift = 0.0
        self.stretches.append([settled, index])

    def _look_for_first(self, index: int, view: Image) -> None:
        if not self.moves or self.returned_at is not None or self._first is None:
            return
        if self._first.displacement(view) > TOLERANCE:
            self._back.clear()
            return
        self._back.append(index)
        if len(self._back) == CONFIRMATIONS:
            self.returned_at = self._back[0]
            self._reference = self._first
            self._suspicions.clear()
            self._back.clear()
            self.stretches.append([self.returned_at, index])

    def _referenced(self, view: Image) -> _Reference | None:
        cv2 = opencv()
        counted = self._counted
        if counted is not None:
            counted = cv2.resize(counted.astype(np.uint8), view.shape[::-1], interpolation=cv2.INTER_NEAREST)
        corners = cv2.goodFeaturesToTrack(view, CORNERS, 0.01, 8, mask=counted)
        return None if corners is None or len(corners) < LEAST_CORNERS else _Reference(view, corners)


@dataclass(frozen=True)
class _Reference:
    """A view and its corners."""

    view: Image
    corners: AnyArray

    def displacement(self, view: Image) -> float:
        """By how many pixels three quarters of the corners moved at least; infinite if few are found."""
        cv2 = opencv()
        there, found, _ = cv2.calcOpticalFlowPyrLK(self.view, view, self.corners, None)
        back, found_back, _ = cv2.calcOpticalFlowPyrLK(view, self.view, there, None)
        again = np.linalg.norm((back - self.corners).reshape(-1, 2), axis=1) < 0.5
        again &= (found.ravel() == 1) & (found_back.ravel() == 1)
        if again.sum() < max(5.0, (1.0 - LOST_SHARE) * len(self.corners)):
            return float("inf")
        lengths = np.linalg.norm((there - self.corners).reshape(-1, 2)[again], axis=1)
        return float(np.percentile(lengths, STILL_QUARTILE))


def _even_contrast(frame: Image, scale: float) -> Image:
    """Shrink a BGR frame to grey and give it the same mean and contrast everywhere."""
    cv2 = opencv()
    grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA).astype(np.float32)
    grey = cv2.GaussianBlur(grey, (0, 0), 1.0)
    around = (NEIGHBOURHOOD, NEIGHBOURHOOD)
    centred = grey - cv2.blur(grey, around)
    # A running sum may end a trifle below nought where all is even.
    spread = np.sqrt(np.maximum(cv2.blur(centred * centred, around), 0.0))
    result: AnyArray = np.clip(128.0 + 40.0 * centred / (spread + 4.0), 0, 255).astype(np.uint8)
    return result
