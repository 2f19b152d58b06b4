"""``--frames N:`` with an offset that is given: frame N is one moment only of videos of one frame rate."""

from __future__ import annotations

import numpy as np
import pytest

import epibar
from epibar.cli import main
from epibar.errors import EpibarError
from epibar.jobs.first_frames import refuse_first_frames
from epibar.jobs.inputs import CameraInput, RecordOptions
from epibar.sources.frame_range import FrameRange

TOLD = r"--frames 15: .* begins at 0.600 s of cam1 \(25 frames a second\) and at 0.500 s of cam2 \(30 frames"


@pytest.fixture
def films(tmp_path):
    """Three masks of 25, 30 and 25.1 frames a second."""
    films = []
    for name, fps in (("cam1", 25.0), ("cam2", 30.0), ("cam3", 25.1)):
        films.append(tmp_path / f"{name}.npz")
        np.savez(films[-1], masks=np.zeros((40, 24, 32), np.uint8), fps=fps)
    return [str(film) for film in films]


@pytest.mark.parametrize("command", ["calibrate", "Python"])
def test_it_is_refused_before_anything_is_recorded(command, films, tmp_path, capsys):
    out = tmp_path / "out"
    if command == "Python":
        with pytest.raises(EpibarError, match=TOLD):
            epibar.calibrate_all(films, out, masks=True, frames=(15, None), time_offset=0.0)
    else:
        words = ["--masks", "--frames", "15:", "--time-offset", "0", "--out", str(out)]
        assert main(["calibrate", *films, *words]) == 2
        capsys.readouterr().err.index("use all frames, cut the videos at one moment")
    assert not out.exists()


@pytest.mark.parametrize(
    ("first", "time_offset", "chosen"),
    [(0, 0.0, [0, 1]), (15, "auto", [0, 1]), (15, "search", [0, 1]), (15, 0.0, [0, 2]), (15, 0.0, [1])],
)
def test_what_is_one_moment_or_is_found_is_not_refused(first, time_offset, chosen, films):
    cameras = [CameraInput(f"cam{k}", films[k], k, None, None) for k in chosen]
    options = RecordOptions(masks=True, frames=FrameRange(first))
    refuse_first_frames(cameras, options, time_offset)


def test_a_small_difference_of_rates_counts_late_in_a_video(films):
    cameras = [CameraInput(f"cam{k}", films[k], k, None, None) for k in (0, 2)]
    with pytest.raises(EpibarError, match="so that a given --time-offset"):
        refuse_first_frames(cameras, RecordOptions(masks=True, frames=FrameRange(1000)), 0.0)
