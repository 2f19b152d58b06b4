"""Made-up scenes with known cameras: masks exact to sub-pixel, videos, and dirt on demand.

>>> from epibar import synthetic
>>> scene = synthetic.people(seed=1, walkers=2, frames=3)
>>> scene.masks(0).shape
(3, 480, 640)
>>> scene.fundamental(0, 1).shape
(3, 3)
"""

from .camera import Camera, true_fundamental
from .dirt import Dirt, noisy
from .families import FAMILIES, WITH_ANSWER, situation
from .figures import Walkers
from .film import Clock
from .generators import HIGH_CAMERAS, LOW_CAMERAS, cubes, people, thin_cubes
from .information import error_bound
from .network_errors import (
    CameraError,
    WorldError,
    accepted_cameras,
    network_errors,
    pair_error,
    position_errors,
    world_error,
)
from .rigs import field_of_view
from .scene import Scene, Solids
from .situations import Answer, Fault, Situation
from .unanswerable import WITHOUT_ANSWER
from .video import render_frames, render_video

__all__ = [
    "FAMILIES",
    "HIGH_CAMERAS",
    "LOW_CAMERAS",
    "WITHOUT_ANSWER",
    "WITH_ANSWER",
    "Answer",
    "Camera",
    "CameraError",
    "Clock",
    "Dirt",
    "Fault",
    "Scene",
    "Situation",
    "Solids",
    "Walkers",
    "WorldError",
    "accepted_cameras",
    "cubes",
    "error_bound",
    "field_of_view",
    "network_errors",
    "noisy",
    "pair_error",
    "people",
    "position_errors",
    "render_frames",
    "render_video",
    "situation",
    "thin_cubes",
    "true_fundamental",
    "world_error",
]
