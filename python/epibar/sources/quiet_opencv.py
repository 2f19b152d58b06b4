"""OpenCV, imported late and kept quiet."""

from __future__ import annotations

import os
from typing import Any

__all__ = ["opencv"]


def opencv() -> Any:
    """OpenCV, imported late because it is slow, with its chatter on stderr switched off."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    import cv2

    logging = getattr(getattr(cv2, "utils", None), "logging", None)
    if logging is not None:
        logging.setLogLevel(logging.LOG_LEVEL_SILENT)
    return cv2
