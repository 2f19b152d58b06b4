"""A made-up pair that is recorded and calibrated once, and a block that walks, for the tests of the API."""

import functools

import numpy as np

import epibar
from epibar import synthetic

LINES = 6000


@functools.cache
def walkers():
    return synthetic.people(seed=3, cameras=2, walkers=6, frames=400, size=(400, 300), asymmetric=True)


@functools.cache
def recorded():
    return [
        epibar.Recording.from_masks(walkers().masks(i), lines=LINES, seed=i, name=f"cam{i + 1}")
        for i in range(2)
    ]


@functools.cache
def calibrated():
    return epibar.calibrate(*recorded())


def block(frames=80, height=48, width=64):
    """One block that walks to the right, and back again."""
    masks = np.zeros((frames, height, width), np.uint8)
    for t in range(frames):
        x = abs((2 * t) % 100 - 50)
        masks[t, 20:32, x : x + 10] = 1
    return masks
