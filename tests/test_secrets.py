"""User names, passwords and keys in addresses of cameras reach no file, log, report or error."""

import json
import logging
import os

import numpy as np
import pytest
from jobs_input import FAST, write_masks

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.errors import address_without_secrets, printable, without_secrets
from epibar.jobs.inputs import CameraInput, camera_inputs
from epibar.sources.source import source_name

SECRETS = ("hunter2", "s3cr3t", "admin")
ADDRESSES = (
    "rtsp://admin:hunter2@127.0.0.1:9/stream1",
    "rtsp://admin:hunt/er2@s3cr3t@127.0.0.1:9/a/b",
    "http://127.0.0.1:9/video.mjpg?user=admin&password=s3cr3t&channel=1",
    "rtsp://127.0.0.1:9/user=admin_password=s3cr3t_channel=1_stream=0.sdp",
    "rtsp://admin:hunter2@127.0.0.1:9",
    "rtmp://127.0.0.1:9/live?s3cr3t#hunter2",
)


def clean(text):
    return not any(secret in text for secret in SECRETS)


@pytest.mark.parametrize("address", ADDRESSES)
def test_an_address_without_secrets(address):
    for shown in (address_without_secrets(address), without_secrets(f"{address}: no answer from {address}.")):
        assert clean(shown), shown
        assert "127.0.0.1:9" in shown
    assert clean(source_name(address))
    assert source_name(address)
    assert clean(str(EpibarError(f"{address}: no")))
    assert clean(repr(CameraInput("cam", address, 0)))


def test_what_is_no_secret_stays():
    text = "a@b.c and cam1.mp4?x=1: see https://example.org/docs#part."
    assert without_secrets(text) == "a@b.c and cam1.mp4?x=1: see https://example.org/docs."
    assert address_without_secrets("user:x@folder/cam 1.mp4") == "user:x@folder/cam 1.mp4"
    assert address_without_secrets("rtsp://u:p w@h/x") == "rtsp://***@h/x"
    assert without_secrets("rtsp://h/a?channel=2&subtype=0") == "rtsp://h/a?channel=2&subtype=0"


def test_cameras_that_differ_in_their_host_alone():
    addresses = [f"rtsp://admin:hunter2@10.0.0.{host}/stream1?key=s3cr3t" for host in (1, 2)]
    names = [camera.name for camera in camera_inputs(addresses)]
    assert len(set(names)) == 2
    assert all(map(clean, names))
    with pytest.raises(EpibarError, match="given twice") as error:
        camera_inputs([addresses[0]] * 2)
    assert clean(str(error.value))


def test_a_network_has_no_camera_that_is_called_like_an_address():
    recording = epibar.Recording.from_masks(np.zeros((3, 9, 9), bool), lines=5)
    for address in ADDRESSES:
        with pytest.raises(EpibarError, match="no name of a camera") as error:
            epibar.calibrate_network({"cam1": recording, address: recording})
        assert clean(str(error.value))


@pytest.mark.parametrize("address", ADDRESSES)
def test_a_run_with_an_address_that_does_not_answer(address, tmp_path, capfd, caplog):
    masks = write_masks(tmp_path)[:2]
    out = tmp_path / "out"
    options = {**FAST, "masks": False, "report": True, "lines": 50}
    saved = []
    for index, path in enumerate(masks):
        recording = epibar.record(path, masks=True, lines=50)
        recording.save(tmp_path / f"saved{index}.npz")
        saved.append(tmp_path / f"saved{index}.npz")
    with caplog.at_level(logging.DEBUG):
        found = epibar.calibrate_all([*saved, address], out, **options)
    assert len(found.errors) == 1
    words = ["calibrate", *map(str, saved), address, "--out", str(out), "--lines", "50", "--method", "lines"]
    assert main([*words, "--verbose", "--json"]) == 3
    assert main(["inspect", address]) == 2
    assert main(["record", address, "--out", str(tmp_path / "x.npz")]) == 2
    assert main(["inspect", address, f"--bogus={address}"]) == 2
    told = capfd.readouterr()
    assert clean(told.out + told.err + caplog.text), told
    assert "127.0.0.1:9" in told.err
    for path in out.rglob("*"):
        if path.is_file():
            text = path.read_bytes().decode("latin-1")
            assert "hunter2" not in text, path
            assert "s3cr3t" not in text, path
    assert clean(json.dumps(json.loads((out / "calibration.json").read_text())))


def test_nothing_that_is_printed_commands_a_terminal(tmp_path, capsys):
    evil = "a\x1b]0;owned\x07\x9b31m\u202eb"
    assert printable(evil) == "a\\x1b]0;owned\\x07\\x9b31m\\u202eb"
    assert main(["inspect", str(tmp_path / f"{evil}.mp4")]) == 2
    assert main(["evaluate", f"{evil}.json", "--cameras", "x"]) == 2
    assert main([f"{evil}"]) == 2
    told = capsys.readouterr().err
    assert "\\x1b]0;owned" in told
    assert not any(sign in told for sign in "\x1b\x07\x9b\u202e")
    for name in (evil, "a\nb", "x\x00"):
        with pytest.raises(EpibarError, match=r"cannot be (part|printed)"):
            camera_inputs({name: "a.mp4", "b": "b.mp4"})


@pytest.mark.skipif(os.name == "nt", reason="names that are no text")
def test_names_that_are_no_text(tmp_path):
    odd = os.fsdecode(os.fsencode(tmp_path) + b"/cam\xff.npz")
    masks = write_masks(tmp_path)
    os.rename(masks[0], odd)
    with pytest.raises(EpibarError, match="cannot be printed"):
        epibar.calibrate_all([odd, masks[1]], tmp_path / "out", **FAST)
    found = epibar.calibrate_all({"a": odd, "b": masks[1]}, tmp_path / "out", **FAST)
    assert not found.errors
    assert json.loads((tmp_path / "out" / "calibration.json").read_text())["cameras"][0]["name"] == "a"


def test_a_bug_keeps_its_traceback_and_the_secret(monkeypatch, capsys):
    from epibar.cli import inspect

    def broken(_):
        raise RuntimeError(ADDRESSES[0])

    monkeypatch.setattr(inspect, "run", broken)
    assert main(["inspect", "x"]) == 1
    told = capsys.readouterr().err
    assert "Traceback" in told
    assert clean(told)
