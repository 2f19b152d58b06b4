"""Saved recordings and ready masks are both .npz: what is given as the other is told before any work."""

import numpy as np
import pytest

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.jobs.inputs import camera_inputs


@pytest.fixture
def files(tmp_path):
    """Two files of masks and two recordings."""
    masks = np.zeros((40, 48, 64), bool)
    for t in range(40):
        masks[t, 10:20, t : t + 8] = True
    found = {}
    for k in (1, 2):
        found[f"masks{k}"] = str(tmp_path / f"masks{k}.npz")
        np.savez(found[f"masks{k}"], masks=masks, fps=25.0)
        found[f"saved{k}"] = str(tmp_path / f"saved{k}.npz")
        epibar.Recording.from_masks(masks, lines=50).save(found[f"saved{k}"])
    return found


@pytest.mark.parametrize("masks", [False, True])
def test_both_at_once_is_refused_before_any_work(masks, files, tmp_path, capsys):
    words = ["calibrate", "cam0.mp4", files["masks1"], files["saved1"], "--out", str(tmp_path / "out")]
    assert main([*words, *(["--masks"] if masks else [])]) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert "saved1.npz is a saved recording and" in told
    assert f"'epibar record {files['masks1']} --masks --out FILE.npz'" in told
    assert not (tmp_path / "out").exists()


def test_each_as_the_other_is_refused_before_any_work(files, tmp_path, capsys):
    out = ["--out", str(tmp_path / "out")]
    assert main(["calibrate", "cam0.mp4", files["masks1"], *out]) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert "masks1.npz: its key 'masks' says that it holds masks: give --masks" in told
    assert main(["calibrate", "cam0.mp4", files["saved1"], "--masks", *out]) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert "saved1.npz: a saved recording, not masks, which --masks says" in told
    with pytest.raises(EpibarError, match=r"give masks$"):
        camera_inputs([files["masks1"], files["masks2"]])
    assert not (tmp_path / "out").exists()


def test_what_cannot_be_looked_into_is_no_matter_yet(files, tmp_path):
    (tmp_path / "damaged.npz").write_bytes(b"PK")
    sources = [str(tmp_path / "damaged.npz"), "rtsp://host/a.npz", "missing.npz", files["saved1"]]
    assert len(camera_inputs(sources)) == 4


def test_a_saved_part_that_is_shorter_is_told(files, capsys):
    told = "from the frames 0:40 of its video; if that is longer, record it again"
    for words, said in (
        (["--frames", "0:40"], None),
        (["--frames", ":500"], "frames 0:500 asked for"),
        (["--seconds", "1.6"], None),
        (["--seconds", "60"], "60 s asked for"),
    ):
        assert main(["inspect", files["saved1"], *words]) == 0
        printed = capsys.readouterr().out
        assert (told in printed) == (said is not None), words
        assert said is None or said in printed
