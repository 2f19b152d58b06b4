"""``--fps``: the frame rate of what states none, and of nothing else."""

import cv2
import numpy as np
import pytest

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.jobs.given_rate import refuse_rate
from epibar.jobs.inputs import CameraInput, RecordOptions
from epibar.jobs.keys import recording_key

FEW = ["--masks", "--lines", "50"]


@pytest.fixture
def images(tmp_path):
    """Folders of masks, as images."""
    for name in ("cam1", "cam2"):
        (tmp_path / name).mkdir()
        for t in range(30):
            mask = np.zeros((48, 64), np.uint8)
            mask[10:20, t : t + 8] = 255
            cv2.imwrite(str(tmp_path / name / f"{t:03d}.png"), mask)
    return [str(tmp_path / name) for name in ("cam1", "cam2")]


def test_a_folder_of_images_has_the_rate_that_is_given(images, tmp_path, capsys):
    saved = tmp_path / "saved.npz"
    assert main(["record", images[0], *FEW, "--out", str(saved), "--fps", "10"]) == 0
    assert epibar.Recording.load(saved).times[-1] == pytest.approx(2.9)
    assert "assumed" not in capsys.readouterr().err
    assert main(["record", images[0], *FEW, "--out", str(saved)]) == 0
    assert epibar.Recording.load(saved).times[-1] == pytest.approx(29 / 25)
    assert "25 frames per second assumed" in (told := capsys.readouterr().err)
    assert "give --fps" in told


def test_all_cameras_of_a_run_have_it(images, tmp_path):
    words = ["--method", "lines", "--no-report", "--fps", "10", "--out", str(tmp_path / "out"), "-q"]
    assert main(["calibrate", *images, *FEW, *words]) == 0
    for name in ("cam1", "cam2"):
        kept = epibar.Recording.load(tmp_path / "out" / "recordings" / f"{name}.npz")
        assert kept.times[-1] == pytest.approx(2.9)


def test_another_rate_is_another_recording(images):
    camera = CameraInput("cam1", images[0], 0)
    assert recording_key(camera, RecordOptions(fps=10.0)) != recording_key(camera, RecordOptions(fps=20.0))


@pytest.mark.parametrize("command", ["calibrate", "record", "inspect"])
def test_for_a_video_it_is_refused_before_any_work(command, images, tmp_path, capsys):
    video = tmp_path / "film.mp4"
    video.write_bytes(b"not looked into")
    sources = {"calibrate": [images[0], str(video)], "record": [str(video)], "inspect": [str(video)]}
    out = [] if command == "inspect" else ["--out", str(tmp_path / "out.npz")]
    assert main([command, *sources[command], *out, "--fps", "10"]) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert "film.mp4: a video, which states its own frame rate, so --fps (fps=) is not for it" in told
    assert not (tmp_path / "out.npz").exists()


def test_what_states_its_own_rate(tmp_path):
    masks = np.zeros((3, 48, 64), bool)
    for name, more in (("with", {"fps": 25.0}), ("without", {})):
        np.savez(tmp_path / f"{name}.npz", masks=masks, **more)
    ready = RecordOptions(masks=True, fps=10.0)
    refuse_rate([str(tmp_path / "without.npz"), "missing.mp4"], ready)
    for source, options, told in (
        (str(tmp_path / "with.npz"), ready, "its key 'fps'"),
        (str(tmp_path / "with.npz"), RecordOptions(fps=10.0), "recorded already"),
        ("rtsp://me:secret@host/film", ready, "a stream"),
        (str(tmp_path), RecordOptions(chapters=True, fps=10.0), "chapters"),
    ):
        with pytest.raises(EpibarError, match=told) as caught:
            refuse_rate([source], options)
        assert "secret" not in str(caught.value)
    refuse_rate([str(tmp_path / "with.npz")], RecordOptions(masks=True))


@pytest.mark.parametrize("fps", ["0", "-1", "nan", "fast"])
def test_bad_rates(fps, images, capsys):
    assert main(["inspect", images[0], "--fps", fps]) == 2
    assert "not a positive number of frames per second" in capsys.readouterr().err
    with pytest.raises(EpibarError, match="fps"):
        RecordOptions(fps=-1.0)
