"""Is a camera any good: what is counted while its video streams by, and what that means in plain English.

:class:`CameraHealth` watches the frames of a video, and the recording keeps its numbers. :func:`inspect` says
what a recording is good for, before any pairing: a :class:`Diagnosis`, whose findings are what is wrong.
"""

from .camera_health import CameraHealth
from .diagnosis import Diagnosis
from .finding import Finding
from .inspection import cause_of_refusal, inspect

__all__ = ["CameraHealth", "Diagnosis", "Finding", "cause_of_refusal", "inspect"]
