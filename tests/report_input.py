"""A small calibrated scene for the tests of the report."""

from dataclasses import replace
from functools import cache

import numpy as np

import epibar
from epibar import synthetic
from epibar.geometry.correspondences import FrontierPoints
from epibar.report.inputs import ReportCamera, ReportPair
from epibar.sources.pictures import Pictures, as_jpeg

SIZE = (320, 240)
LATE = 7
"""Frames by which the second camera was started earlier than the others."""

NO_POINTS = FrontierPoints(np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))


@cache
def calibrated():
    """Masks and recordings of three cameras, the third in another hall; calibration of the first two."""
    hall = synthetic.people(seed=5, cameras=2, walkers=5, frames=400, size=SIZE, asymmetric=True)
    other = synthetic.people(seed=6, cameras=2, walkers=3, frames=400, size=SIZE)
    masks = [hall.masks(0)[LATE:], hall.masks(1)[:-LATE], other.masks(0)]
    recordings = [
        epibar.Recording.from_masks(stack, lines=6000, seed=index, name=f"cam{index + 1}")
        for index, stack in enumerate(masks)
    ]
    good = epibar.calibrate(recordings[0], recordings[1], time_offset=float(LATE))
    assert good.accepted, good
    return masks, recordings, good


def pictures_of(masks, frames=None):
    """Pictures of some frames of masks; of all by default."""
    frames = range(len(masks)) if frames is None else frames
    return Pictures(
        {frame: as_jpeg(np.repeat(masks[frame][:, :, None] * 255, 3, axis=2)) for frame in frames}
    )


def make_report_input():
    """Three cameras, an accepted pair with a time offset, a refused one with F, a refused one without.

    Of the first two cameras there are pictures, of the third there are none.
    """
    masks, recordings, good = calibrated()
    cameras = []
    for recording, stack in zip(recordings, masks, strict=True):
        pictures = None if recording is recordings[2] else pictures_of(stack.astype(np.uint8))
        cameras.append(ReportCamera(recording.name, f"{recording.name}.npz", True, recording, pictures))
    refused = replace(
        good,
        accepted=False,
        kind="ambiguous",
        reason="A different geometry, 15 px away, explains the motion nearly as well.",
        time_offset=0.0,
    )
    nothing = replace(
        good,
        F=None,
        accepted=False,
        kind="no_common_scene",
        reason="Nothing suggests that they see the same.",
        expected_error=None,
        time_offset=0.0,
        frontier_points=NO_POINTS,
        candidates=replace(good.candidates, inliers=np.zeros(len(good.candidates), bool)),
        shift_curve=(np.empty(0), np.empty(0)),
        rivals=[],
    )
    pairs = [
        ReportPair("cam1", "cam2", good, 3.2),
        ReportPair("cam1", "cam3", refused, 2.0),
        ReportPair("cam2", "cam3", nothing, 1.0),
    ]
    return cameras, pairs
