"""The job of all pairs from the command line: what it prints where, and its exit codes."""

import json
import os
import sys

import pytest
from jobs_input import WORDS, content, write_masks

import epibar
from epibar.cli import main


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))


def test_json_is_all_that_is_on_stdout(masks, tmp_path, capsys):
    words = ["calibrate", *map(str, masks[:2]), "--out", str(tmp_path / "out"), *WORDS]
    assert main([*words, "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.out.encode() == content(tmp_path / "out")
    assert "cam1 - cam2: " in printed.err
    assert main([*words, "--json", "--quiet"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["pairs"]
    assert printed.err == ""
    assert main(words) == 0
    printed = capsys.readouterr()
    assert "(kept)" in printed.out
    assert "2 of 2 recordings, 1 of 1 pairs" in printed.err


def test_json_with_a_bad_camera(masks, tmp_path, capsys):
    words = ["calibrate", *map(str, masks[:2]), "none.npz", "--out", str(tmp_path / "out"), *WORDS, "--json"]
    assert main(words) == 3
    printed = capsys.readouterr()
    assert json.loads(printed.out)["errors"][0]["camera"] == "none"
    assert "none.npz" in printed.err


@pytest.mark.parametrize("address", ["nonsense", "tcp://host", "http://host:80"])
def test_no_such_scheduler_address(address, masks, tmp_path, capsys):
    words = ["calibrate", *map(str, masks[:2]), "--out", str(tmp_path / "out"), "--scheduler", address]
    assert main(words) == 2
    assert address in capsys.readouterr().err


def test_exit_codes_are_documented(capsys):
    assert main(["calibrate", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert all(
        code in text for code in ("0 done", "2 unusable input", "3 a camera or a pair", "130 interrupted")
    )


@pytest.mark.skipif(os.name == "nt", reason="needs a pseudo-terminal")
def test_progress_with_an_estimate_on_a_terminal(masks, tmp_path):
    import pty
    import subprocess
    import termios

    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, 120))
    words = ["calibrate", *map(str, masks), "--out", str(tmp_path / "out"), *WORDS, "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "epibar", *words], stdout=subprocess.DEVNULL, stderr=theirs
    )
    os.close(theirs)
    seen = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        seen += part
    os.close(ours)
    assert process.wait() == 0
    assert b"matched 0 of 6 pairs" in seen
    assert b" left" in seen


def test_the_report_is_written(masks, tmp_path):
    words = [*map(str, masks[:2]), "none.npz", "--out", str(tmp_path / "out"), *WORDS[:-1]]
    assert main(["calibrate", *words]) == 3
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "cam1" in page
    assert "none.npz" in page


def test_what_is_recorded_already_cannot_be_cut(masks, tmp_path, capsys):
    saved = tmp_path / "saved.npz"
    epibar.record(masks[0], masks=True, lines=50, frames=(20, 120)).save(saved)
    for part in ("20:120", "20:"):
        assert main(["inspect", str(saved), "--frames", part]) == 0
    for part in ("0:120", "20:100", "30:"):
        assert main(["inspect", str(saved), "--frames", part]) == 2
        assert "recorded already, from the frames 20:120" in capsys.readouterr().err
    words = ["calibrate", str(saved), "none.npz", "--out", str(tmp_path / "out"), "--frames", ":100"]
    assert main(words) == 2
    assert "frames 0:100 asked for" in capsys.readouterr().err
