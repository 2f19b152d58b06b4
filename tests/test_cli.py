"""The command line: exit codes, errors that name file or argument, good pairs kept when a camera is bad."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.cli import main
from epibar.lens.cameras_toml import load_cameras, write_cameras

FAST = ["--lines", "6000", "--quiet"]


@pytest.fixture(scope="module")
def scene():
    return synthetic.people(seed=5, cameras=3, walkers=5, frames=400, size=(320, 240), asymmetric=True)


@pytest.fixture(scope="module")
def masks(scene, tmp_path_factory):
    """Ready masks of three cameras."""
    folder = tmp_path_factory.mktemp("masks")
    paths = []
    for index in range(3):
        path = folder / f"cam{index + 1}.npz"
        np.savez_compressed(path, masks=scene.masks(index), fps=25.0)
        paths.append(str(path))
    return paths


@pytest.fixture(scope="module")
def cameras(scene, tmp_path_factory):
    """The known cameras, in an order that is not that of the videos: they are found by name."""
    path = tmp_path_factory.mktemp("cameras") / "cameras.toml"
    tables = []
    for index in (2, 0, 1):
        camera = scene.cameras[index]
        rotation = cv2.Rodrigues(camera.R)[0].ravel().tolist()
        tables.append(
            f'[cam_{index}]\nname = "cam{index + 1}"\nsize = {list(camera.size)}\n'
            f"matrix = {camera.K.tolist()}\ndistortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n"
            f"rotation = {rotation}\ntranslation = {camera.t.tolist()}\n"
        )
    path.write_text("\n".join(tables))
    return path


@pytest.fixture(scope="module")
def calibrated(masks, cameras, tmp_path_factory):
    """Three cameras, all pairs, with intrinsics."""
    out = tmp_path_factory.mktemp("out")
    code = main(["calibrate", *masks, "--masks", "--out", str(out), "--intrinsics", str(cameras), *FAST])
    assert code == 0
    return out


def read(out):
    """calibration.json, strictly: no NaN."""

    def refuse(word):
        raise AssertionError(f"{word} in calibration.json")

    return json.loads((out / "calibration.json").read_text(), parse_constant=refuse)


# --- results ---


def test_every_pair_is_written(calibrated):
    result = read(calibrated)
    assert [(pair["a"], pair["b"]) for pair in result["pairs"]] == [
        ("cam1", "cam2"),
        ("cam1", "cam3"),
        ("cam2", "cam3"),
    ]
    assert result["errors"] == []
    assert [camera["name"] for camera in result["cameras"]] == ["cam1", "cam2", "cam3"]
    for pair in result["pairs"]:
        assert {"accepted", "kind", "reason", "F", "expected_error", "time_offset", "counts"} <= pair.keys()
        assert {"seed", "method", "floor", "rivals"} <= pair.keys()
        assert pair["F"] is None or np.shape(pair["F"]) == (3, 3)
        picture = cv2.imread(str(calibrated / pair["picture"]))
        assert picture.shape[0] > 300
        assert picture.shape[1] > 600
        table = np.genfromtxt(calibrated / pair["frontier_points"], delimiter=",", names=True)
        assert table.dtype.names == ("frame_a", "x_a", "y_a", "x_b", "y_b", "residual")


def test_accepted_pairs_are_right(calibrated, scene):
    pairs = [pair for pair in read(calibrated)["pairs"] if pair["accepted"]]
    assert pairs
    for pair in pairs:
        a, b = int(pair["a"][-1]) - 1, int(pair["b"][-1]) - 1
        points_a, points_b = scene.volume_correspondences(a, b)
        assert epibar.symmetric_epipolar_distance(pair["F"], points_a, points_b).mean() < 3


def test_evaluate(calibrated, cameras, capsys):
    assert main(["evaluate", str(calibrated / "calibration.json"), "--cameras", str(cameras)]) == 0
    text = capsys.readouterr().out
    assert "cam1" in text
    assert "cam2 - cam3" in text
    assert "px" in text
    assert main(["evaluate", str(calibrated), "--cameras", str(cameras)]) == 0
    assert capsys.readouterr().out == text


def test_evaluate_goes_on_after_a_pair_without_a_baseline(calibrated, cameras, tmp_path, capsys):
    known = {camera.name: camera for camera in load_cameras(cameras)}
    one, two = known["cam1"], known["cam2"]
    write_cameras(
        tmp_path / "known.toml",
        [one, replace(two, rotation=one.rotation, translation=one.translation), known["cam3"]],
    )
    words = ["evaluate", str(calibrated / "calibration.json"), "--cameras", str(tmp_path / "known.toml")]
    assert main(words) == 0
    told = capsys.readouterr()
    assert "cam1 - cam2: no errors are given, the two cameras stand at one place" in told.err
    assert [line.split()[4] for line in told.out.splitlines() if line.startswith("cam1 - cam2")] == ["-"]
    assert any("px" in line for line in told.out.splitlines() if line.startswith("cam1 - cam3"))


def test_what_the_system_says_of_a_file_is_no_traceback(tmp_path, capsys):
    too_long = str(tmp_path / ("x" * 5000)) + ".mp4"
    assert main(["inspect", too_long]) == 2
    assert main(["calibrate", too_long, "other.mp4", "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert f"epibar: error: {too_long}: File name too long" in told
    assert "Traceback" not in told


def test_evaluate_with_cameras_of_another_size(calibrated, cameras, tmp_path, capsys):
    write_cameras(tmp_path / "known.toml", [replace(c, size=(64, 48)) for c in load_cameras(cameras)])
    words = ["evaluate", str(calibrated / "calibration.json"), "--cameras", str(tmp_path / "known.toml")]
    assert main(words) == 2
    assert "known.toml: cam1 is for 64x48, but cam1 was recorded at 320x240" in capsys.readouterr().err


def test_evaluate_a_damaged_calibration(calibrated, cameras, tmp_path, capsys):
    result = read(calibrated)
    del result["pairs"][0]["F"]
    (tmp_path / "calibration.json").write_text(json.dumps(result))
    for path in calibrated.glob("*.csv"):
        shutil.copy(path, tmp_path)
    assert main(["evaluate", str(tmp_path / "calibration.json"), "--cameras", str(cameras)]) == 2
    assert "damaged: pairs[0].F is missing" in capsys.readouterr().err


def test_a_recording_stands_for_its_video(masks, calibrated, cameras, tmp_path):
    saved = []
    for index, path in enumerate(masks[:2]):
        saved.append(str(tmp_path / f"cam{index + 1}.npz"))
        words = ["record", path, "--masks", "--out", saved[-1], "--intrinsics", str(cameras), *FAST]
        assert main(words) == 0
    assert main(["calibrate", *saved, "--out", str(tmp_path / "out"), *FAST]) == 0
    assert read(tmp_path / "out")["pairs"][0]["F"] == read(calibrated)["pairs"][0]["F"]


def test_intrinsics_of_what_is_recorded_already(masks, cameras, tmp_path, capsys):
    saved = [str(tmp_path / f"cam{index + 1}.npz") for index in range(2)]
    for path, out in zip(masks, saved, strict=False):
        assert main(["record", path, "--masks", "--out", out, *FAST]) == 0
    words = ["calibrate", *saved, "--out", str(tmp_path / "out"), "--intrinsics", str(cameras), *FAST]
    # Without distortion the matrix is all that was missing.
    assert main(words) == 0
    assert "essential_deviation" in read(tmp_path / "out")["pairs"][0]["evidence"]
    bent = tmp_path / "bent.toml"
    bent.write_text(cameras.read_text().replace("distortions = [0.0,", "distortions = [-0.3,"))
    words[words.index(str(cameras))] = str(bent)
    assert main(words) == 2
    assert "cam1.npz: recorded without intrinsics, so its lens still bends lines" in capsys.readouterr().err


def test_cameras_that_are_found_by_their_place_are_told(masks, cameras, tmp_path, capsys):
    renamed = tmp_path / "renamed.toml"
    renamed.write_text(cameras.read_text().replace('name = "cam3"', 'name = "left"'))
    # The table called "left" is the first.
    words = ["calibrate", masks[2], masks[0], "--masks", "--out", str(tmp_path / "out"), "--lines", "6000"]
    assert main([*words, "--intrinsics", str(renamed)]) == 0
    (told,) = [line for line in capsys.readouterr().err.splitlines() if "of this name" in line]
    assert told.startswith("epibar: warning: cam3: ")
    assert "renamed.toml" in told
    assert "'left'" in told


def test_what_cannot_be_done_to_what_is_recorded_already(masks, tmp_path, capsys):
    saved = str(tmp_path / "cam1.npz")
    assert main(["record", masks[0], "--masks", "--out", saved, *FAST]) == 0
    assert main(["inspect", saved, "--foreground", "knn"]) == 0
    assert "so its foreground 'knn' cannot be applied" in capsys.readouterr().out
    assert main(["inspect", saved, "--masks"]) == 2
    assert "a saved recording, not masks; give it without --masks" in capsys.readouterr().err


def test_an_ignore_mask_for_what_is_recorded_already(masks, tmp_path, capsys):
    saved = str(tmp_path / "cam1.npz")
    assert main(["record", masks[0], "--masks", "--out", saved, *FAST]) == 0
    mask = tmp_path / "ignore.png"
    cv2.imwrite(str(mask), np.zeros((10, 10), np.uint8))
    assert main(["inspect", saved, "--ignore", str(mask)]) == 0
    assert "recorded already, so its ignore mask cannot be applied" in capsys.readouterr().out


def test_another_number_of_lines_for_what_is_recorded_already(masks, tmp_path, capsys):
    saved = str(tmp_path / "cam1.npz")
    assert main(["record", masks[0], "--masks", "--out", saved, "--lines", "150"]) == 0
    told = "recorded already, with 150 lines; for 300 record the video again"
    for words, expected in ((["--lines", "300"], True), (["--lines", "150"], False), ([], False)):
        capsys.readouterr()
        assert main(["inspect", saved, *words]) == 0
        assert (told in capsys.readouterr().out) == expected


# --- what a user can get wrong ---


def test_one_broken_video_of_three(masks, tmp_path, capsys):
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(b"this is not a video" * 100)
    words = ["calibrate", masks[0], str(broken), masks[1], "--masks", "--out", str(tmp_path / "out"), *FAST]
    assert main([word for word in words if word != "--quiet"]) == 3
    told = capsys.readouterr().err
    assert "broken.mp4" in told
    assert "accepted: 1 of 1 pairs; errors: 1, see above" in told.splitlines()[-1]
    result = read(tmp_path / "out")
    assert [(pair["a"], pair["b"]) for pair in result["pairs"]] == [("cam1", "cam2")]
    assert (tmp_path / "out" / "cam1_cam2.png").exists()
    assert len(result["errors"]) == 1
    assert result["errors"][0]["camera"] == "broken"
    assert "broken.mp4" in result["errors"][0]["message"]


def test_a_missing_file_is_named(masks, tmp_path, capsys):
    assert main(["calibrate", masks[0], "nowhere.mp4", "--masks", "--out", str(tmp_path / "o")]) == 2
    told = capsys.readouterr().err
    assert "nowhere.mp4" in told
    assert "accepted: 0 of 1 pairs; errors: 1, see above" in told.splitlines()[-1]
    assert read(tmp_path / "o")["pairs"] == []


def test_where_nothing_can_be_read_earlier_results_stay(masks, tmp_path, capsys):
    out, videos = tmp_path / "out", [tmp_path / Path(name).name for name in masks[:2]]
    for name, video in zip(masks, videos, strict=False):
        video.write_bytes(Path(name).read_bytes())
    words = ["calibrate", *map(str, videos), "--masks", "--out", str(out), *FAST]
    assert main(words) == 0
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    for video in videos:  # as where a drive is not there
        video.unlink()
    capsys.readouterr()
    assert main([word for word in words if word != "--quiet"]) == 2
    assert "errors: 2, see above; what an earlier run wrote in" in capsys.readouterr().err.splitlines()[-1]
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["calibrate"], "VIDEO"),
        (["calibrate", "A", "--out", "OUT"], "two cameras"),
        (["calibrate", "A", "B"], "--out"),
        (["calibrate", "A", "A", "--out", "OUT"], "given twice"),
        (["calibrate", "A", "B", "--out", "OUT", "--lines", "0"], "--lines"),
        (["calibrate", "A", "B", "--out", "OUT", "--lines", "many"], "--lines"),
        (["calibrate", "A", "B", "--out", "OUT", "--seed", "-1"], "--seed"),
        (["calibrate", "A", "B", "--out", "OUT", "--method", "magic"], "--method"),
        (["calibrate", "A", "B", "--out", "OUT", "--foreground", "magic"], "--foreground"),
        (["calibrate", "A", "B", "--out", "OUT", "--time-offset", "soon"], "--time-offset"),
        (["calibrate", "A", "B", "--out", "OUT", "--time-offset", "nan"], "--time-offset"),
        (["calibrate", "A", "B", "C", "--out", "OUT", "--time-offset", "3"], "--time-offset"),
        (["calibrate", "A", "B", "--out", "OUT", "--background", "A"], "--background"),
        (["calibrate", "A", "B", "--out", "OUT", "--ignore", "A", "A", "A"], "--ignore"),
        (["calibrate", "A", "B", "--out", "OUT", "--intrinsics", "none.toml"], "none.toml"),
        (["calibrate", "A", "B", "--out", "A"], "--out"),
        (["record", "A", "--masks", "--out", "cam.txt"], "--out"),
        (["record", "A", "--masks", "--out", "A"], "--out"),
        (["record", "A", "--masks", "--out", "nowhere/cam.npz"], "nowhere"),
        (["evaluate", "none.json", "--cameras", "none.toml"], "none.json"),
        (["evaluate", "A", "--cameras", "none.toml"], "cam1.npz"),
        (["nonsense"], "nonsense"),
        ([], "COMMAND"),
    ],
)
def test_bad_arguments(words, named, masks, tmp_path, capsys):
    names = {"A": masks[0], "B": masks[1], "C": masks[2], "OUT": str(tmp_path / "out")}
    words = [names.get(word, word) for word in words]
    assert main([*words, "--masks"] if words[:1] == ["calibrate"] else words) == 2
    text = capsys.readouterr().err
    assert named in text
    assert "Traceback" not in text


def test_intrinsics_of_another_size(masks, cameras, tmp_path, capsys):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(cameras.read_text().replace("size = [", "size = [1"))
    out = tmp_path / "out"
    words = ["calibrate", *masks[:2], "--masks", "--out", str(out), "--intrinsics", str(wrong), *FAST]
    assert main(words) == 2
    assert "cam1" in capsys.readouterr().err


def test_an_ignore_mask_of_another_size(masks, tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "ignore.png"), np.zeros((10, 10), np.uint8))
    words = ["record", masks[0], "--masks", "--out", str(tmp_path / "r.npz")]
    assert main([*words, "--ignore", str(tmp_path / "ignore.png"), *FAST]) == 2
    assert "ignore.png" in capsys.readouterr().err
    assert not (tmp_path / "r.npz").exists()


def test_no_traceback_from_the_process_itself(tmp_path):
    run = subprocess.run(
        [sys.executable, "-m", "epibar", "calibrate", "no1.mp4", "no2.mp4", "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 2
    assert "no1.mp4" in run.stderr
    assert "Traceback" not in run.stderr


# --- comfort ---


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from epibar.cli import main; assert main(['calibrate', '--help']) == 0; "
        "sys.exit(any(name in sys.modules for name in ('numpy', 'cv2', 'epibar._core')))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0
    assert "--intrinsics" in run.stdout


def test_version(capsys):
    assert main(["--version"]) == 0
    assert epibar.__version__ in capsys.readouterr().out


@pytest.mark.skipif(os.name == "nt", reason="signals differ on Windows")
def test_interrupt_exits_with_130_promptly(masks, tmp_path):
    words = [sys.executable, "-m", "epibar", "calibrate", *masks, "--masks", "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        [*words, "--lines", "1000000"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        # A shell that runs the tests in the background may have told them to ignore it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    end = time.monotonic() + 120
    while not (tmp_path / "out").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.05)
    time.sleep(2)
    assert process.poll() is None, "finished before it could be interrupted: give it more to do"
    process.send_signal(signal.SIGINT)
    started = time.perf_counter()
    _, stderr = process.communicate(timeout=20)
    assert process.returncode == 130
    assert time.perf_counter() - started < 5
    assert b"Traceback" not in stderr
