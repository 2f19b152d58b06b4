"""What moves: masks of the frames of one stationary camera."""

from .options import METHODS, ForegroundOptions
from .subtraction import Foreground

__all__ = ["METHODS", "Foreground", "ForegroundOptions"]
