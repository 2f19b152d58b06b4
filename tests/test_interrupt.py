"""Ctrl-C ends the command promptly in every stage, and loses nothing that was computed."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future

import pytest
from jobs_input import FAST, WORDS, content, write_masks

import epibar
from epibar.cli import interrupt, main
from epibar.jobs import Watch

NEVER = 2**31 - 1
"""Rounds of a hash: a computation of a quarter of an hour that hears no signal."""

WIDE = 30.0
"""Seconds that a busy machine may take for what is done in one."""

STAGES = {
    "recording": ("runner", "record_camera"),
    "clocks": ("runner", "find_clocks"),
    "pairs": ("runner", "calibrate_pair"),
    "network": ("runner", "join_cameras"),
    "tables": ("result_files", "write_tables"),
    "report": ("result_files", "Results.write_report"),
}

HANGING = """
import hashlib, pathlib, sys
from epibar import cli
from epibar.jobs import result_files, runner

place = {module}
usual = place.{name}

def hang(*given):
    names = [getattr(one, "name", "") for one in given]
    if {only} and {only} != names[:2]:
        return usual(*given)
    pathlib.Path({flag!r}).touch()
    hashlib.pbkdf2_hmac("sha256", b"", b"", {never})

place.{name} = hang
cli.run_process()
"""


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))[:3]


def hanging(stage, tmp_path, words, only=()):
    """Start a command whose stage never ends, and return it once it is there."""
    module, name = STAGES[stage]
    *owner, name = name.split(".")
    flag = tmp_path / "reached"
    code = HANGING.format(
        module=".".join([module, *owner]), name=name, only=list(only), flag=str(flag), never=NEVER
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        # A shell that runs the tests in the background may have told them to ignore it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        wait_for(flag.exists, process)
    except BaseException:
        process.kill()
        raise
    return process


def wait_for(there, process=None):
    end = time.monotonic() + 120
    while not there():
        assert process is None or process.poll() is None, process.stderr.read().decode()
        assert time.monotonic() < end
        time.sleep(0.02)


def interrupted(process):
    """Interrupt a command; returns what it said."""
    process.send_signal(signal.SIGINT)
    try:
        _, told = process.communicate(timeout=WIDE)
    finally:
        process.kill()
    assert process.returncode == 130, told.decode()
    assert b"epibar: interrupted" in told
    assert b"Traceback" not in told
    return told


def test_the_limit_is_a_second():
    assert 0.5 < interrupt.GRACE < 1.0


@pytest.mark.skipif(os.name == "nt", reason="signals differ on Windows")
@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_ends(stage, masks, tmp_path):
    lines = ["--masks", "--lines", "2000"]
    out = tmp_path / "out"
    process = hanging(stage, tmp_path, ["calibrate", *map(str, masks), "--out", str(out), *lines])
    interrupted(process)
    reached = list(STAGES).index(stage)
    assert len(list(out.glob("recordings/cam*.npz"))) == (3 if reached > 0 else 0)
    assert (out / "recordings" / "clocks.json").exists() == (reached > 1)
    assert len(list(out.glob("pairs/*.npz"))) == (3 if reached > 2 else 0)
    assert (out / "network.json").exists() == (reached > 3)
    assert not list(out.rglob("*.epibar-part"))


@pytest.mark.skipif(os.name == "nt", reason="signals differ on Windows")
def test_a_run_interrupted_among_its_pairs_ends_with_the_same_bytes(masks, tmp_path):
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    words = ["calibrate", *map(str, masks), *WORDS, "--time-offset", "0", "--out"]
    assert main([*words, str(whole)]) == 0
    process = hanging("pairs", tmp_path, [*words, str(broken)], only=["cam2", "cam3"])
    wait_for(lambda: len(list(broken.glob("pairs/*.npz"))) == 2, process)
    interrupted(process)
    before = {path: path.stat().st_mtime_ns for path in broken.glob("*/cam*.npz")}
    assert len(before) >= 5
    assert main([*words, str(broken)]) == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert content(broken) == content(whole)


class AtOnce(Executor):
    """Has done every task when it is handed over; keeps the names of what they were about."""

    def __init__(self):
        self.tasks = []

    def submit(self, function, *arguments):
        self.tasks.append("-".join(one.name for one in arguments if hasattr(one, "name")))
        future = Future()
        future.set_result(function(*arguments))
        return future


class Impatient(Watch):
    """Interrupts at the first recording, or at the first pair."""

    def __init__(self, at):
        self.at = at

    def note(self, text):
        if self.at == "recording" and "frames of" in text:
            raise KeyboardInterrupt

    def verdict(self, text):
        raise KeyboardInterrupt


@pytest.mark.parametrize("at", ["recording", "pair"])
def test_what_tasks_have_finished_is_kept_though_nobody_took_it(at, masks, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        epibar.calibrate_all(masks, tmp_path / "out", executor=AtOnce(), watch=Impatient(at), **FAST)
    if at == "pair":
        listed = json.loads(content(tmp_path / "out"))["pairs"]
        assert [pair["a"] + pair["b"] for pair in listed] == ["cam1cam2", "cam1cam3", "cam2cam3"]
        assert all((tmp_path / "out" / pair["picture"]).exists() for pair in listed)
    again = AtOnce()
    epibar.calibrate_all(masks, tmp_path / "out", executor=again, **FAST)
    computed = {"recording": ["cam1-cam2", "cam1-cam3", "cam2-cam3"], "pair": []}[at]
    assert again.tasks == computed
    epibar.calibrate_all(masks, tmp_path / "whole", **FAST)
    assert content(tmp_path / "out") == content(tmp_path / "whole")
