"""Four cameras around flying cubes, and the quickest options, for the tests of jobs."""

import numpy as np

from epibar import synthetic
from epibar.jobs import Watch

FAST = {"masks": True, "lines": 4000, "method": "lines", "time_offset": 0.0, "report": False}
WORDS = ["--masks", "--lines", "4000", "--method", "lines", "--no-report"]


def write_masks(folder):
    """Ready masks of each camera."""
    scene = synthetic.cubes(3, cameras=4, objects=12, frames=200, size=(160, 120), size_m=(0.25, 0.45))
    paths = []
    for index in range(4):
        paths.append(folder / f"cam{index + 1}.npz")
        np.savez_compressed(paths[-1], masks=scene.masks(index), fps=25.0)
    return paths


def content(out):
    return (out / "calibration.json").read_bytes()


class Heard(Watch):
    """Keeps what a job told."""

    def __init__(self):
        self.notes, self.warnings, self.errors, self.stages = [], [], [], []

    def note(self, text):
        self.notes.append(text)

    def warning(self, text):
        self.warnings.append(text)

    def error(self, text):
        self.errors.append(text)

    def progress(self, stage, done, total):
        self.stages.append((stage, done, total))


class Hasty(Heard):
    """Presses Ctrl-C as soon as a pair is told."""

    def verdict(self, text):
        raise KeyboardInterrupt
