"""Did the camera stand still, and did the light stay on?

Every few frames the gradient image is compared with that of the start, tile by tile, by phase correlation: edges, so
that light does not matter; tiles, so that people do not. The camera moved when the median tile did, three checks in a
row. A flooded frame, where more than 60 % of the image is foreground, tells nothing about what moves: it is blanked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["FLOOD_SHARE", "CameraHealth"]

FLOOD_SHARE = 0.6
BRIGHTNESS_JUMP = 10.0  # grey levels of the mean from one frame to the next
SHARE_JUMP = 0.2
MANY_BLANKED = 0.05
WORKING_WIDTH = 640
TILE = 80
TOLERANCE = 1.0  # pixels at the working width
CONFIRMATIONS = 3
LEAST_RESPONSE = 0.1
LEAST_TEXTURE = 8.0


class CameraHealth:
    """Watch the frames and masks of one camera as they stream by.

    Parameters
    ----------
    name : str
        Put before every warning.
    every : int
        Frames between two checks for camera motion.
    ignore : ndarray, shape (H, W), bool, optional
        True where motion does not count.

    Attributes
    ----------
    blanked : int
        Number of flooded frames.
    light_switches : list of int
        Frames at which the light jumped.
    moved_at : int or None
        First frame at which the camera was seen displaced.
    displacement : float
        By how many pixels, then.
    """

    def __init__(self, name: str = "camera", every: int = 10, ignore: np.ndarray | None = None) -> None:
        self.name = name
        self.every = max(1, every)
        self.frames = 0
        self.blanked = 0
        self.light_switches: list[int] = []
        self.moved_at: int | None = None
        self.displacement = 0.0
        self._counted = None if ignore is None else ~ignore.astype(bool)
        self._first_blanked = -1
        self._brightness: float | None = None
        self._share = 0.0
        self._reference: np.ndarray | None = None
        self._suspicions: list[int] = []

    def update(self, index: int, frame: np.ndarray, mask: np.ndarray) -> np.ndarray:
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
        share = float(mask.mean() if self._counted is None else mask[self._counted].mean())
        brightness = float(frame[::4, ::4].mean())
        if self._brightness is not None:
            jumped = abs(brightness - self._brightness) > BRIGHTNESS_JUMP
            if jumped and (share - self._share > SHARE_JUMP or share > FLOOD_SHARE):
                self.light_switches.append(index)
        self._brightness, self._share = brightness, share
        if (self.frames - 1) % self.every == 0 and self.moved_at is None:
            self._check_motion(index, frame, mask, share)
        if share <= FLOOD_SHARE:
            return mask
        if self.blanked == 0:
            self._first_blanked = index
        self.blanked += 1
        return np.zeros_like(mask)

    def _check_motion(self, index: int, frame: np.ndarray, mask: np.ndarray, share: float) -> None:
        import cv2

        scale = min(1.0, WORKING_WIDTH / frame.shape[1])
        size = max(8, round(frame.shape[1] * scale)), max(8, round(frame.shape[0] * scale))
        grey = cv2.resize(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY), size, interpolation=cv2.INTER_AREA)
        grey = cv2.GaussianBlur(grey, (0, 0), 1.0).astype(np.float32)
        gradient = cv2.magnitude(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1))
        if self._reference is None:
            self._reference = gradient
            return
        # A camera that moved floods the mask; then the mask says nothing about which tiles hold people.
        busy = cv2.resize(mask, size, interpolation=cv2.INTER_NEAREST) if share < 0.3 else np.zeros_like(grey)
        shift = self._median_shift(cv2, self._reference, gradient, busy) / scale
        if shift * scale <= TOLERANCE:
            self._suspicions.clear()
            return
        self._suspicions.append(index)
        if len(self._suspicions) == CONFIRMATIONS:
            self.moved_at, self.displacement = self._suspicions[0], shift

    @staticmethod
    def _median_shift(cv2: Any, reference: np.ndarray, gradient: np.ndarray, busy: np.ndarray) -> float:
        """Median length of the tiles' displacements, working pixels; 0 where too few tiles have texture."""
        height, width = reference.shape
        tile = min(TILE, height, width)
        window = cv2.createHanningWindow((tile, tile), cv2.CV_32F)
        shifts = []
        for top in range(0, height - tile + 1, tile):
            for left in range(0, width - tile + 1, tile):
                where = np.s_[top : top + tile, left : left + tile]
                if reference[where].std() < LEAST_TEXTURE or busy[where].mean() > 0.1:
                    continue
                (dx, dy), response = cv2.phaseCorrelate(reference[where], gradient[where], window)
                if response > LEAST_RESPONSE:
                    shifts.append(float(np.hypot(dx, dy)))
        return float(np.median(shifts)) if len(shifts) >= 3 else 0.0

    @property
    def warnings(self) -> list[str]:
        """Plain-English remarks about what was seen so far."""
        remarks = []
        if self.moved_at is not None:
            remarks.append(
                f"{self.name}: the camera moved, by about {self.displacement:.0f} pixels, at or shortly before frame "
                f"{self.moved_at}; use only the frames before or only those after"
            )
        if self.light_switches:
            some = ", ".join(map(str, self.light_switches[:5])) + (
                ", ..." if len(self.light_switches) > 5 else ""
            )
            remarks.append(f"{self.name}: the light changed suddenly at frame {some}")
        if self.blanked:
            remark = (
                f"{self.name}: {self.blanked} of {self.frames} frames, the first of them {self._first_blanked}, "
                f"were left out because more than {FLOOD_SHARE:.0%} of the image changed"
            )
            if self.blanked > MANY_BLANKED * self.frames:
                remark += (
                    "; did the camera move, does the light flicker, or is somebody right in front of it?"
                )
            remarks.append(remark)
        return remarks
