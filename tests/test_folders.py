"""The folder of a run: one run at a time, nothing lost, nothing deleted but what was written."""

import json
import os
import shutil
import signal
import stat
import subprocess
import sys
import time

import numpy as np
import pytest
from jobs_input import FAST, WORDS, content, write_masks

import epibar
from epibar import EpibarError
from epibar.files import atomic
from epibar.files.atomic import sweep, write_atomically
from epibar.jobs.folder import Folder

POSIX = pytest.mark.skipif(os.name == "nt", reason="permissions and signals of POSIX")


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))


@pytest.fixture(scope="module")
def done(masks, tmp_path_factory):
    out = tmp_path_factory.mktemp("done")
    epibar.calibrate_all(masks[:2], out, **FAST)
    return out


def test_one_run_at_a_time(masks, again):
    with Folder(again), pytest.raises(EpibarError, match="another run of epibar is at work"):
        epibar.calibrate_all(masks[:2], again, **FAST)
    epibar.calibrate_all(masks[:2], again, **FAST)


@POSIX
def test_a_run_that_was_killed_lets_go_of_the_folder(masks, tmp_path):
    code = "import sys, time; from pathlib import Path; from epibar.jobs.folder import Folder\n"
    code += "with Folder(Path(sys.argv[1])): print('held', flush=True); time.sleep(600)"
    process = subprocess.Popen([sys.executable, "-c", code, tmp_path], stdout=subprocess.PIPE)
    try:
        assert process.stdout.readline() == b"held\n"
        with pytest.raises(EpibarError, match="at work"):
            epibar.calibrate_all(masks[:2], tmp_path, **FAST)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
    assert epibar.calibrate_all(masks[:2], tmp_path, **FAST).calibrations


@pytest.mark.parametrize(
    "name",
    [
        "cam1_cam2.png",
        "cam1_cam2_frontier.csv",
        "report.html",
        "calibration.json",
        "network.json",
        "recordings/cam1.npz",
        "recordings/clocks.json",
    ],
)
def test_what_the_user_has_there_is_neither_deleted_nor_taken_for_ours(name, masks, tmp_path):
    mine = tmp_path / "out" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("my own")
    with pytest.raises(EpibarError, match="not written by epibar"):
        epibar.calibrate_all(masks[:2], tmp_path / "out", **{**FAST, "report": True})
    assert mine.read_text() == "my own"
    assert [
        path for path in (tmp_path / "out").rglob("*") if path.is_file() and ".epibar" not in path.parts
    ] == [mine]


def test_what_has_no_name_of_a_result_stays(masks, again):
    (again / "cam1_cam3.png").write_text("my own")
    (again / "notes.txt").write_text("my own")
    epibar.calibrate_all(masks[:2], again, **{**FAST, "seed": 1})
    assert (again / "cam1_cam3.png").read_text() == (again / "notes.txt").read_text() == "my own"


def test_a_folder_of_before_there_was_a_list(masks, again):
    before = content(again)
    shutil.rmtree(again / ".epibar")
    epibar.calibrate_all(masks[:2], again, **FAST)
    assert content(again) == before


def test_a_damaged_list(masks, again):
    for text in ("{", "[]", '{"format": 1, "files": [1]}', "[" * 100_000):
        (again / ".epibar" / "written.json").write_text(text)
        with pytest.raises(EpibarError, match=r"written\.json: damaged"):
            epibar.calibrate_all(masks[:2], again, **FAST)


def test_a_file_whose_noting_was_interrupted_is_noted_the_next_time(tmp_path, monkeypatch):
    def interrupted(path, text):
        raise KeyboardInterrupt

    file = tmp_path / "cam1_cam2.png"
    with Folder(tmp_path) as folder:
        with monkeypatch.context() as patch:
            patch.setattr("epibar.jobs.folder.write_text", interrupted)
            with pytest.raises(KeyboardInterrupt):
                folder.will_write(file)
        assert not folder.owns(file)
        folder.will_write(file)
        file.touch()
    with Folder(tmp_path) as folder:
        folder.refuse_foreign([file])


def test_results_do_not_go_among_the_images_of_a_camera(masks, tmp_path):
    cv2 = pytest.importorskip("cv2")
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
        for index in range(3):
            cv2.imwrite(str(tmp_path / name / f"{index:03}.png"), np.zeros((8, 8), np.uint8))
    left, right = tmp_path / "left", tmp_path / "right"
    for cameras, out in (
        ([left, right], left),
        ([left, right], tmp_path / "x" / ".." / "right"),
        ([left / "%03d.png", right], left),
    ):
        with pytest.raises(EpibarError, match="among the images"):
            epibar.calibrate_all({"a": cameras[0], "b": cameras[1]}, out, **FAST)
    assert sorted(path.name for path in left.iterdir()) == ["000.png", "001.png", "002.png"]
    with pytest.raises(EpibarError, match="would replace this input"):
        epibar.calibrate_all(
            [left, right], tmp_path, intrinsics=None, ignore=[tmp_path / "left_right.png"] * 2, **FAST
        )


def test_left_overs_are_swept_and_others_are_not(masks, again):
    left = [
        again / f".calibration.json.{'0' * 16}.epibar-part",
        again / "pairs" / f".x.{'a1' * 8}.epibar-part",
    ]
    stays = [again / ".mine.part", again / f"x.{'0' * 16}.epibar-part.txt"]
    for path in (*left, *stays):
        path.write_text("half")
    epibar.calibrate_all(masks[:2], again, **FAST)
    assert [path.exists() for path in left] == [False, False]
    assert all(path.exists() for path in stays)
    sweep(again / "nowhere")


@POSIX
def test_permissions_are_those_of_the_umask_which_is_not_changed(tmp_path, monkeypatch):
    def refuse(_):
        raise AssertionError("other threads would write with another umask")

    before = os.umask(0o027)
    try:
        monkeypatch.setattr(os, "umask", refuse)
        write_atomically(tmp_path / "file", lambda stream: stream.write(b"x"))
    finally:
        monkeypatch.undo()
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


@POSIX
def test_file_and_folder_are_synced_in_order(tmp_path, monkeypatch):
    told = []
    sync, replace = os.fsync, os.replace

    def fsync(handle):
        told.append("folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else "file")
        sync(handle)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(os, "replace", lambda *paths: (told.append("rename"), replace(*paths)))
    write_atomically(tmp_path / "file", lambda stream: stream.write(b"x"))
    assert told == ["file", "rename", "folder"]


@POSIX
def test_what_is_no_file_is_not_replaced_by_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pipe, folder, link, real = (tmp_path / name for name in ("pipe", "folder", "link", "real"))
    os.mkfifo(pipe)
    folder.mkdir()
    for path, why in ((pipe, "a pipe or a device"), (folder, "it is a folder"), ("", "no name of a file")):
        with pytest.raises(EpibarError, match=f"cannot be written .*{why}"):
            write_atomically(path, lambda stream: stream.write(b"x"))
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    link.symlink_to(real.name)
    for _ in range(2):
        write_atomically(link, lambda stream: stream.write(b"x"))
    assert link.is_symlink()
    assert real.read_bytes() == b"x"
    pipe.unlink()
    link.unlink()
    link.symlink_to(link.name)
    with pytest.raises(EpibarError, match="link: cannot be written"):
        write_atomically(link, lambda stream: stream.write(b"x"))


@pytest.mark.parametrize("at", ["open", "fsync", "replace"])
def test_a_disk_that_fails_keeps_what_was_there(at, tmp_path, monkeypatch):
    path = tmp_path / "file"
    path.write_bytes(b"before")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(atomic.os, at, fail)
    with pytest.raises(EpibarError, match=r"file: cannot be written \(No space left on device\)"):
        write_atomically(path, lambda stream: stream.write(b"after"))
    monkeypatch.undo()
    assert path.read_bytes() == b"before"
    assert [found.name for found in tmp_path.iterdir()] == ["file"]


FULL = """
import resource, sys
from epibar.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), resource.RLIM_INFINITY))
sys.exit(main(sys.argv[2:]))
"""


@POSIX
@pytest.mark.parametrize("most", [0, 2_000, 60_000])
def test_a_full_disk_is_told_and_what_is_finished_is_kept(most, masks, done, tmp_path):
    """Files may not grow beyond a limit, which fails as a full disk does: while they are written."""
    out = tmp_path / "out"
    words = ["calibrate", *masks[:2], "--out", out, *WORDS]
    full = subprocess.run(
        [sys.executable, "-c", FULL, str(most), *map(str, words)], capture_output=True, text=True, timeout=300
    )
    assert full.returncode in (2, 3), full.stderr
    assert "cannot be" in full.stderr
    assert "Traceback" not in full.stderr
    assert not list(out.rglob("*.epibar-part"))
    epibar.calibrate_all(masks[:2], out, **FAST)
    assert content(out) == content(done)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_only_be_read(masks, again):
    for folder in (again, again / ".epibar"):
        folder.chmod(0o555)
    try:
        with pytest.raises(EpibarError, match="cannot be"):
            epibar.calibrate_all(masks[:2], again, **{**FAST, "seed": 1})
    finally:
        for folder in (again, again / ".epibar"):
            folder.chmod(0o755)


@POSIX
def test_a_run_that_is_killed_ends_with_the_same_bytes(masks, done, tmp_path):
    """A hundred times, and on Dask: benchmarks/kill_and_resume.py."""
    out = tmp_path / "out"
    words = [sys.executable, "-m", "epibar", "calibrate", *map(str, masks[:2]), "--out", str(out), *WORDS]
    kills = 0
    for wait in (0.4, 0.9, 1.4):
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(wait)
        process.send_signal(signal.SIGKILL)
        kills += process.wait() == -signal.SIGKILL
    assert kills
    epibar.calibrate_all(masks[:2], out, **FAST)
    assert content(out) == content(done)
    assert not list(out.rglob("*.epibar-part"))
    listed = json.loads((out / ".epibar" / "written.json").read_text())["files"]
    found = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    assert {name for name in found if not name.startswith(".epibar/")} <= set(listed)
