"""Known lenses: the camera file, what it says of a camera, and taking the lens out of masks and images."""

from .cameras_toml import find_camera, load_cameras, write_cameras
from .intrinsics import Intrinsics
from .undistortion import Undistorter

__all__ = ["Intrinsics", "Undistorter", "find_camera", "load_cameras", "write_cameras"]
