"""Start times of cameras: which frames to keep, and the commands that cut, whatever files are called."""

import csv
import json
import math
import os
import shlex
import shutil
import subprocess
from dataclasses import replace

import cv2
import imageio_ffmpeg
import numpy as np
import pytest
from network_input import made_up

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.files.calibration_json import FORMAT
from epibar.files.csv_table import csv_text
from epibar.network import NetworkClock, StartTime
from epibar.network.parts import NetworkPairs
from epibar.outcome.sync import camera_starts, cut_command, write_starts


def network(clocks, names=None, lost=(), refused=()):
    """A network with these clocks (offset, drift)."""
    found = made_up(len(clocks), refused=refused, lost=lost)
    names = names or list(found.cameras)
    found = replace(
        found,
        cameras={
            new: replace(camera, name=new) for new, camera in zip(names, found.cameras.values(), strict=True)
        },
    )
    known = [NetworkClock(*clock, 0.002) for clock in clocks]
    return replace(found, pairs=NetworkPairs([]), clocks=dict(zip(names, known, strict=True)))


def filmed(frames, fps, name="", first_frame=0):
    """A recording of which only the times matter."""
    rng = np.random.default_rng(frames)
    made = epibar.Recording.from_masks(rng.random((frames, 24, 32)) < 0.02, fps=fps, lines=4, name=name)
    made.first_frame = first_frame
    return made


def test_frames_to_keep_show_the_same_moments():
    """The moment at which a kept frame was taken, by the world's clock, from the definition of the clocks."""
    starts, rates, drifts = (0.0, 1.37, -2.2), (25.0, 30.0, 12.5), (0.0, 40.0, -30.0)
    clocks = [(-start * (1 + 1e-6 * drift), drift) for start, drift in zip(starts, drifts, strict=True)]
    frames = (200, 260, 130)
    skipped = (0, 7, 3)
    found = network(clocks).start_times(
        {f"cam{k + 1}": filmed(frames[k], rates[k], first_frame=skipped[k]) for k in range(3)}
    )
    assert list(found) == ["cam1", "cam2", "cam3"]
    stops = [start + (n - 1) / rate for start, n, rate in zip(starts, frames, rates, strict=True)]
    for k, one in enumerate(found.values()):
        half = 0.5 / rates[k] + 1e-3
        for frame, second, moment in (
            (one.first_frame, one.first_second, max(starts)),
            (one.last_frame, one.last_second, min(stops)),
        ):
            assert second == pytest.approx(frame / rates[k], abs=1e-9)
            shown = starts[k] + (frame - skipped[k]) / rates[k] / (1 + 1e-6 * drifts[k])
            assert abs(shown - moment) < half
        assert one.offset == clocks[k][0]
        assert one.offset_frames == pytest.approx(clocks[k][0] * rates[k])
        assert (one.drift, one.error, one.fps) == (drifts[k], 0.002, pytest.approx(rates[k]))
    assert found["cam2"].first_frame == 7  # the last to start keeps its first frame


def test_a_clock_there_and_back():
    clock = NetworkClock(0.5, 100.0, 0.002)
    assert clock.at(1000.0) == pytest.approx(1000.6, abs=1e-9)
    assert clock.time_of(clock.at(17.0)) == pytest.approx(17.0)
    with pytest.raises(EpibarError, match="shows no time"):
        NetworkClock().at(0.0)


def test_frame_rates_alone_say_where_to_start():
    found = network([(0.0, 0.0), (4.0, 0.0)]).start_times({"cam1": 25, "cam2": 30.0})
    assert found["cam1"] == StartTime(0.0, 0.0, 0.0, 0.002, 25.0, 0, 0.0)
    assert (found["cam2"].first_frame, found["cam2"].first_second) == (120, 4.0)
    assert found["cam2"].last_frame is None
    assert found["cam2"].last_second is None


def test_only_accepted_cameras_count():
    clocks = [(0.0, 0.0), (1.0, 0.0), (-90.0, 0.0), (2.0, 0.0)]
    found = network(clocks, refused=("cam3",)).start_times({f"cam{k}": 25.0 for k in (1, 2, 3, 4)})
    assert list(found) == ["cam1", "cam2", "cam4"]
    assert found["cam2"].first_frame == 25


@pytest.mark.parametrize(
    ("clocks", "given", "said"),
    [
        ([(0.0, 0.0), (50.0, 0.0)], {"cam1": filmed(50, 25), "cam2": filmed(50, 25)}, "no moment is common"),
        ([(0.0, 0.0), (1.0, 0.0)], {"cam1": 25.0, "other": 25.0}, "no camera of that name"),
        ([(0.0, 0.0), (1.0, 0.0)], {"cam1": 25.0}, "two are needed"),
        ([(0.0, 0.0), (1.0, 0.0)], {"cam1": 25.0, "cam2": -1.0}, "positive frames per second"),
        ([(0.0, 0.0), (1.0, 0.0)], {"cam1": 25.0, "cam2": math.nan}, "positive frames per second"),
        ([(0.0, 0.0), (1.0, 0.0)], {"cam1": 25.0, "cam2": filmed(50, 25)}, "expected a Recording"),
        ([(0.0, 0.0), (1e300, 0.0)], {"cam1": 25.0, "cam2": 25.0}, "no clock runs"),
        ([(0.0, 0.0), (1.0, -1e6)], {"cam1": 25.0, "cam2": 25.0}, "no clock runs"),
    ],
)
def test_what_cannot_be(clocks, given, said):
    with pytest.raises(epibar.EpibarError, match=said):
        network(clocks).start_times(given)


HOSTILE = [
    "a b.mp4",
    "-i.mp4",
    "x'; touch owned; '.mp4",
    "$(touch owned).mp4",
    "concat:a|b.mp4",
    "`id`.avi",
    '"q".mp4',
]
TIME = StartTime(1.0, 25.0, 0.0, 0.002, 25.0, 25, 1.0, 74, 2.96)


@pytest.mark.parametrize("name", HOSTILE)
def test_a_shell_takes_a_path_as_one_word(name, tmp_path):
    """What the shell makes of the command is what was meant: a program that prints its words tells."""
    command = cut_command(str(tmp_path / name), "cam_sync.mp4", TIME)
    assert shlex.split(command)[0] == "ffmpeg"
    program = tmp_path / "ffmpeg"
    program.write_text('#!/bin/sh\nfor word in "$@"; do printf "%s\\0" "$word"; done\n')
    program.chmod(0o755)
    path = {"PATH": f"{tmp_path}:/usr/bin:/bin"}
    told = subprocess.run(["sh", "-c", command], capture_output=True, check=True, cwd=tmp_path, env=path)
    words = told.stdout.decode().split("\0")[:-1]
    assert words[words.index("-i") + 1] == f"file:{tmp_path / name}"
    assert words[-1] == "cam_sync.mp4"
    assert not (tmp_path / "owned").exists()


def test_what_is_no_video_file_has_no_command(tmp_path):
    for source in (
        "rtsp://host/live",
        "masks.npz",
        "frame_%04d.png",
        str(tmp_path),
        "a\nb.mp4",
        "a\x1b[2J.mp4",
    ):
        assert cut_command(source, "out.mp4", TIME) is None, source


def test_the_command_keeps_whole_frames():
    """It seeks a little ahead of the first, and stops a little behind the last."""
    words = shlex.split(cut_command("cam.mp4", "out.mp4", TIME))
    start, length = (float(words[words.index(option) + 1]) for option in ("-ss", "-t"))
    assert start == pytest.approx(1.0 - 0.01)
    assert start + length == pytest.approx(2.96 + 0.01)
    at_once = shlex.split(cut_command("cam.mp4", "out.mp4", replace(TIME, first_second=0.0, first_frame=0)))
    assert float(at_once[at_once.index("-ss") + 1]) == 0
    open_end = shlex.split(cut_command("cam.mp4", "out.mp4", replace(TIME, last_second=None)))
    assert "-t" not in open_end


def test_names_of_cameras_are_plain_names_of_files():
    names = ["../up", "-x", "a/b", "a:b", "A_b", "..", "%d", "=1+1"]
    starts = camera_starts(dict.fromkeys(names, TIME), {name: f"{k}.mp4" for k, name in enumerate(names)})
    outputs = [shlex.split(one.command)[-1] for one in starts]
    assert len({output.casefold() for output in outputs}) == len(names)
    for output in outputs:
        assert output.endswith("_sync.mp4")
        assert not output.startswith(("-", "."))
        assert not set(output) & set("/\\:%")


def test_a_spreadsheet_sees_no_formula(tmp_path):
    starts = camera_starts({"=cmd()": TIME}, {"=cmd()": "=cmd().mp4"})
    write_starts(tmp_path / "sync.csv", starts)
    (row,) = csv.DictReader((tmp_path / "sync.csv").read_text().splitlines())
    assert row["camera"] == csv_text("=cmd()") == "'=cmd()"
    assert row["file"] == "'=cmd().mp4"
    assert (int(row["first_frame"]), float(row["last_second"])) == (25, 2.96)
    assert row["command"].startswith("ffmpeg ")


@pytest.fixture
def run(tmp_path):
    """A folder as a run leaves it, with videos whose frames tell their numbers."""
    net = network([(0.0, 0.0), (0.48, 0.0)], ["cam1", "it's"])
    (tmp_path / "recordings").mkdir()
    cameras = []
    for index, (name, frames, fps) in enumerate((("cam1", 60, 25.0), ("it's", 80, 25.0))):
        film = filmed(frames, fps, name)
        film.save(tmp_path / "recordings" / f"{name}.npz")
        writer = cv2.VideoWriter(
            str(tmp_path / f"{name}.mp4"), cv2.VideoWriter_fourcc(*"mp4v"), fps, (320, 64)
        )
        for frame in range(frames):
            image = np.zeros((64, 320, 3), np.uint8)
            for bit in range(8):
                image[:, 40 * bit : 40 * bit + 40] = 255 * (frame >> bit & 1)
            writer.write(image)
        writer.release()
        cameras.append(
            {"name": name, "index": index, "file": str(tmp_path / f"{name}.mp4"), "first_frame": 0}
        )
    net.save(tmp_path / "network.json")
    content = {"format": FORMAT, "cameras": cameras, "pairs": []}
    (tmp_path / "calibration.json").write_text(json.dumps(content))
    return tmp_path


def test_the_command_line_prints_what_to_keep(run, capsys):
    assert main(["sync", str(run)]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0].split()[:2] == ["camera", "offset"]
    assert "12 - 71" in out[2]
    assert out[3].startswith("ffmpeg ")
    assert main(["sync", str(run), "--commands"]) == 0
    assert all(line.startswith("ffmpeg ") for line in capsys.readouterr().out.splitlines())
    assert main(["sync", str(run), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["cameras"]
    assert [one["name"] for one in told] == ["cam1", "it's"]
    assert (told[1]["first_frame"], told[1]["last_frame"], told[0]["first_frame"]) == (12, 71, 0)
    assert told[1]["offset"] == 0.48


def test_no_command_is_for_a_video_that_is_not_there(run, capsys):
    (run / "cam1.mp4").unlink()
    assert main(["sync", str(run), "--commands"]) == 0
    printed = capsys.readouterr()
    (command,) = printed.out.splitlines()
    assert "it's" in shlex.split(command)[-6]
    assert f"warning: cam1: no command, for {run / 'cam1.mp4'} is not there" in printed.err
    assert main(["sync", str(run), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["cameras"]
    assert [one["command"] is None for one in told] == [True, False]


def test_a_recording_that_was_given_is_read_where_it_is(run, capsys):
    path = run / "calibration.json"
    content = json.loads(path.read_text())
    content["cameras"][0].update(file=str(run / "mine.npz"), matrix=None)
    path.write_text(json.dumps(content))
    (run / "recordings" / "cam1.npz").rename(run / "mine.npz")
    assert main(["sync", str(run), "--json"]) == 0
    assert [one["command"] is None for one in json.loads(capsys.readouterr().out)["cameras"]] == [True, False]
    (run / "mine.npz").unlink()
    assert main(["sync", str(run)]) == 2
    assert "mine.npz" in capsys.readouterr().err


def test_frames_count_from_the_start_of_the_video(run, capsys):
    """Where the run left out the first frames of one, its recording says how many."""
    recording = filmed(60, 25.0, "cam1", first_frame=7)
    recording.save(run / "recordings" / "cam1.npz")
    content = json.loads((run / "calibration.json").read_text())
    content["cameras"][0]["first_frame"] = 7
    (run / "calibration.json").write_text(json.dumps(content))
    assert main(["sync", str(run), "--json"]) == 0
    one, other = json.loads(capsys.readouterr().out)["cameras"]
    assert (one["first_frame"], one["last_frame"]) == (7, 66)
    assert (other["first_frame"], other["last_frame"]) == (12, 71)


def test_a_run_without_a_network_says_so(run, capsys):
    (run / "network.json").unlink()
    assert main(["sync", str(run)]) == 2
    assert "no network" in capsys.readouterr().err


def test_a_name_that_leads_elsewhere_is_refused(run, capsys):
    content = json.loads((run / "calibration.json").read_text())
    net = network([(0.0, 0.0), (0.48, 0.0)], ["cam1", "../../cam"])
    net.save(run / "network.json")
    content["cameras"][1]["name"] = "../../cam"
    (run / "calibration.json").write_text(json.dumps(content))
    assert main(["sync", str(run)]) == 2
    assert "no name of a camera" in capsys.readouterr().err


@pytest.fixture
def ffmpeg(tmp_path, monkeypatch):
    """The machine's own, or the one that comes with imageio-ffmpeg."""
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "ffmpeg").symlink_to(shutil.which("ffmpeg") or imageio_ffmpeg.get_ffmpeg_exe())
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.usefixtures("ffmpeg")
def test_ffmpeg_cuts_to_the_frame(run, capsys, tmp_path_factory):
    """The commands as a shell runs them, one after the other from a pipe: the right frames, and as many."""
    assert main(["sync", str(run), "--commands"]) == 0
    script, out = capsys.readouterr().out, tmp_path_factory.mktemp("cut")
    subprocess.run(["sh", "-e"], input=script.encode(), capture_output=True, check=True, cwd=out)
    shown = {}
    for path in out.glob("*.mp4"):
        video, numbers = cv2.VideoCapture(str(path)), []
        while (read := video.read())[0]:
            bits = [int(read[1][8:56, 40 * bit + 8 : 40 * bit + 32].mean() > 127) for bit in range(8)]
            numbers.append(sum(value << bit for bit, value in enumerate(bits)))
        shown[path.name] = numbers
    assert shown == {"cam1_sync.mp4": list(range(60)), "it_s_sync.mp4": list(range(12, 72))}
