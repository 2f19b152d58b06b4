"""Frames and ready-made masks, streamed from whatever a user has.

A source is a video file, a folder of images, a stream or numbered-image pattern that OpenCV opens
(:class:`ColourFrames`), or the same in black and white, or an ``.npz`` or ``.npy`` array of masks
(:class:`MaskFrames`). Every source is read from start to end in bounded memory and may be read again: each
``iter()`` starts at frame 0. Frames count from 0; times are seconds since frame 0.

What is wrong but bearable (a truncated file, no frame rate, dropped frames) goes to ``warnings``; what is not
raises :class:`~epibar.EpibarError`.
"""

from .colour_frames import ColourFrames
from .frame_range import FrameRange
from .mask_frames import MaskFrames
from .prefetch import prefetched
from .quiet_opencv import opencv
from .source import DEFAULT_FPS

__all__ = [
    "DEFAULT_FPS",
    "ColourFrames",
    "FrameRange",
    "MaskFrames",
    "opencv",
    "prefetched",
]
