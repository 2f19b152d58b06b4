"""Whether the camera stood still and the light stayed on.

Corners found in the first frame are looked for again every few frames (Lucas-Kanade, forward and back, on an
image with its local contrast normalised, so that light matters little). A camera that moves moves every
corner, so it takes three quarters of them, three checks in a row; somebody who fills half of the picture is
not enough.

A flooded frame, more than 60 % foreground, tells nothing about what moves: it is blanked.
"""

from __future__ import annotations

import numpy as np

from .images import opencv

__all__ = ["FLOOD_SHARE", "CameraHealth"]

FLOOD_SHARE = 0.6
BRIGHTNESS_JUMP = 8
"""Grey levels by which half of the pixels change, or more, from one frame to the next."""
MANY_BLANKED = 0.05
WORKING_WIDTH = 640
CORNERS = 300
LEAST_CORNERS = 20
LOST_SHARE = 0.9
"""Of the corners; when so many are not found again the view is another one."""
TOLERANCE = 1.0
"""Pixels at the working width."""
CONFIRMATIONS = 3
STILL_QUARTILE = 25.0


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
    blanked : int
        Number of flooded frames.
    light_switches : list of int
        Frames at which the light jumped.
    moved_at : int or None
        First frame at which the camera was seen displaced.
    displacement : float
        By how many pixels, then; infinite where the view is another one.
    """

    def __init__(self, name: str = "camera", every: int = 10, ignore: np.ndarray | None = None) -> None:
        self.name = name
        self.every = max(1, every)
        self.frames = 0
        self.blanked = 0
        self.light_switches: list[int] = []
        self.moved_at: int | None = None
        self.displacement = 0.0
        self._counted = None if ignore is None else np.asarray(ignore) == 0
        self._first_blanked = -1
        self._sparse: np.ndarray | None = None
        self._reference: np.ndarray | None = None
        self._corners: np.ndarray | None = None
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
        share = _share(mask, self._counted)
        # Averaged over 8x8 pixels: noise from frame to frame must not look like a change of the light.
        cv2 = opencv()
        small = cv2.resize(frame[..., 1], None, fx=0.125, fy=0.125, interpolation=cv2.INTER_AREA)
        sparse = small.astype(np.int16)
        if self._sparse is not None and np.median(np.abs(sparse - self._sparse)) > BRIGHTNESS_JUMP:
            self.light_switches.append(index)
        self._sparse = sparse
        if (self.frames - 1) % self.every == 0 and self.moved_at is None:
            self._check_motion(index, frame)
        if share <= FLOOD_SHARE:
            return mask
        if self.blanked == 0:
            self._first_blanked = index
        self.blanked += 1
        return np.zeros_like(mask)

    def _check_motion(self, index: int, frame: np.ndarray) -> None:
        import cv2

        scale = min(1.0, WORKING_WIDTH / frame.shape[1])
        view = _even_contrast(frame, scale)
        if self._reference is None:
            self._reference = view
            counted = self._counted
            if counted is not None:
                counted = cv2.resize(
                    counted.astype(np.uint8), view.shape[::-1], interpolation=cv2.INTER_NEAREST
                )
            self._corners = cv2.goodFeaturesToTrack(view, CORNERS, 0.01, 8, mask=counted)
            return
        if self._corners is None or len(self._corners) < LEAST_CORNERS:
            return
        shift = _displacement(self._reference, view, self._corners)
        if shift <= TOLERANCE:
            self._suspicions.clear()
            return
        self._suspicions.append(index)
        if len(self._suspicions) == CONFIRMATIONS:
            self.moved_at, self.displacement = self._suspicions[0], shift / scale

    @property
    def warnings(self) -> list[str]:
        """Plain-English remarks about what was seen so far."""
        remarks = []
        if self.moved_at is not None:
            far = "by a lot" if np.isinf(self.displacement) else f"by about {self.displacement:.0f} pixels"
            remarks.append(
                f"{self.name}: the camera moved, {far}, at or shortly before frame {self.moved_at}; "
                "use only the frames before or only those after"
            )
        if self.light_switches:
            more = ", ..." if len(self.light_switches) > 5 else ""
            some = ", ".join(map(str, self.light_switches[:5])) + more
            remarks.append(f"{self.name}: the light changed suddenly at frame {some}")
        if self.blanked:
            remark = (
                f"{self.name}: {self.blanked} of {self.frames} frames, the first of them "
                f"{self._first_blanked}, were left out: more than {FLOOD_SHARE:.0%} of the image changed"
            )
            if self.blanked > MANY_BLANKED * self.frames:
                remark += (
                    "; did the camera move, does the light flicker, or is somebody right in front of it?"
                )
            remarks.append(remark)
        return remarks


def _share(mask: np.ndarray, counted: np.ndarray | None) -> float:
    """Share of the image that is foreground, where it counts."""
    if counted is None:
        return float(mask.mean())
    return float((mask * counted).sum() / max(1, np.count_nonzero(counted)))


def _even_contrast(frame: np.ndarray, scale: float) -> np.ndarray:
    """Shrink a BGR frame to grey and give it the same mean and contrast everywhere."""
    import cv2

    grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA).astype(np.float32)
    grey = cv2.GaussianBlur(grey, (0, 0), 1.0)
    centred = grey - cv2.GaussianBlur(grey, (0, 0), 10.0)
    spread = np.sqrt(cv2.GaussianBlur(centred * centred, (0, 0), 10.0))
    return np.clip(128.0 + 40.0 * centred / (spread + 4.0), 0, 255).astype(np.uint8)


def _displacement(reference: np.ndarray, view: np.ndarray, corners: np.ndarray) -> float:
    """Return by how many pixels three quarters of the corners moved at least; infinite if few are found."""
    cv2 = opencv()

    there, found, _ = cv2.calcOpticalFlowPyrLK(reference, view, corners, None)
    back, found_back, _ = cv2.calcOpticalFlowPyrLK(view, reference, there, None)
    again = np.linalg.norm((back - corners).reshape(-1, 2), axis=1) < 0.5
    again &= (found.ravel() == 1) & (found_back.ravel() == 1)
    if again.sum() < max(5.0, (1.0 - LOST_SHARE) * len(corners)):
        return float("inf")
    lengths = np.linalg.norm((there - corners).reshape(-1, 2)[again], axis=1)
    return float(np.percentile(lengths, STILL_QUARTILE))
