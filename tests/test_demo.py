"""The demo's scene has the clocks and lenses that it says, and the comparison with the truth is one."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from network_input import made_up

from epibar.cli import demo, main
from epibar.cli.demo_answer import compared
from epibar.cli.parser import build_parser
from epibar.network import NetworkClock, Scale
from epibar.synthetic.staging import BARREL, LATEST, RATES, stage

SIZE = (160, 120)


@pytest.fixture(scope="module")
def staging():
    return stage(3, seconds=2.0, size=SIZE)


def test_lenses_and_clocks_differ(staging):
    cameras, clocks = staging.cameras, staging.clocks
    assert [camera.name for camera in cameras] == ["cam1", "cam2", "cam3", "cam4"]
    assert len({camera.K[0, 0] for camera in cameras}) == 4
    assert all(BARREL[0] <= camera.distortions[0] <= BARREL[1] for camera in cameras)
    starts = [clock.start for clock in clocks]
    assert min(starts) == 0 < max(starts) < LATEST
    assert clocks[0].drift == 0
    assert all(clock.fps in RATES for clock in clocks)
    assert all(len(clock.moments) == 2 * clock.fps for clock in clocks)
    together = stage(3, seconds=2.0, size=SIZE, barrel=False, unsynchronised=False)
    assert len({(clock.start, clock.fps, clock.drift) for clock in together.clocks}) == 1
    assert not any(camera.distorted for camera in together.cameras)


def test_an_offset_leads_to_the_same_moment(staging):
    """The second of a video that shows what the first frame of the first video would show."""
    for index, clock in enumerate(staging.clocks):
        frame = staging.offset(index) * clock.fps - staging.empty_frames
        moment = clock.start + frame / clock.fps / clock.rate
        first = staging.clocks[0]
        assert moment == pytest.approx(first.start - staging.empty_frames / first.fps / first.rate)
    assert staging.offset(0) == 0


def test_videos_show_it(staging, tmp_path):
    path = staging.render(1, tmp_path / "cam2.mp4")
    video = cv2.VideoCapture(str(path))
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(staging.clocks[1].fps)
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == staging.empty_frames + len(staging.clocks[1].moments)


def as_found(staging, scale=0.1):
    """The network that is the truth but for its unit, with stated errors of 1 %, 1° and 0.1 units."""
    made = made_up(4, refused=(), lost=())
    cameras = {
        true.name: replace(
            made.cameras[true.name],
            size=true.size,
            matrix=true.K,
            distortions=np.array(true.distortions),
            rotation=true.R,
            translation=scale * true.t,
            expected={"focal": 0.01, "rotation": 1.0, "position": 0.1},
        )
        for true in staging.cameras
    }
    clocks = {name: NetworkClock(staging.offset(k), 0.0, 0.001) for k, name in enumerate(cameras)}
    return replace(made, cameras=cameras, clocks=clocks)


def test_the_truth_is_told_to_be_right(staging):
    lines = compared(as_found(staging), staging)
    assert lines[0].split() == ["camera", "focal", "length", "rotation", "position", "clock"]
    assert len(lines) == 7
    for line in lines[1:5]:
        assert "(stated 1.00 %)" in line
        assert "0.00° (stated 1.00°)" in line
        assert "0.0 cm (stated 100.0 cm)" in line
        assert line.endswith((" 0 ms", "+0 ms", "-0 ms"))
        assert "above" not in line
    assert lines[5] == "z is 0.00° from the vertical (standard error 0.20°)"
    assert lines[6].startswith("12 of 12 errors")


def test_metres_are_held_against_the_truth(staging):
    network = replace(as_found(staging, 1.02), scale=Scale(0.03, ("people",)))
    lines = compared(network, staging)
    assert lines[5].endswith(", lengths in metres are off by +2.0 % (stated 3.0 %)")
    # 0.1 of the network's unit is stated, of which one is 1/1.02 m.
    assert "0.0 cm (stated 9.8 cm)" in lines[1]
    assert lines[6].endswith("what was stated of them too: the unit of length of the network is 0.980 m")
    in_metres = compared(replace(network, unit="metre"), staging)
    assert in_metres[6].endswith("a metre of the network is 0.980 m")


def test_what_is_wrong_is_told(staging):
    network = as_found(staging)
    wrong = network.cameras["cam3"]
    K = wrong.matrix.copy()
    K[:2, :2] *= 1.03
    wrong = replace(wrong, matrix=K)
    clock = replace(network.clocks["cam2"], offset=network.clocks["cam2"].offset + 0.05)
    lost = replace(network.cameras["cam4"], accepted=False, reason="it fell")
    network = replace(
        network,
        cameras=network.cameras | {"cam3": wrong, "cam4": lost},
        clocks=network.clocks | {"cam2": clock},
    )
    lines = compared(network, staging)
    assert lines[0] == "cam4: left out: it fell"
    row = {line.split()[0]: line for line in lines[1:]}
    assert "+3.00 % (stated 1.00 %) above it" in row["cam3"]
    assert row["cam2"].endswith("+50 ms")
    assert lines[-1].startswith("8 of 9 errors")
    alone = replace(network, cameras=dict.fromkeys(network.cameras, lost))
    assert "fewer than two" in compared(alone, staging)[-1]


@pytest.mark.parametrize("words", [["--cameras", "1"], ["--cameras", "x"], ["--lens", "fisheye"]])
def test_bad_options(words, tmp_path, capsys):
    assert main(["demo", "--out", str(tmp_path / "out"), *words]) == 2
    assert words[0] in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_default_is_four_unknown_cameras():
    parser = build_parser()
    default = parser.parse_args(["demo"])
    spelt = parser.parse_args(["demo", "--cameras", "4", "--unsynchronised", "--lens", "barrel"])
    assert vars(default) == vars(spelt)


def test_two_cameras_without_a_lens(tmp_path, monkeypatch, capsys):
    """The whole command, far too short for a result."""
    monkeypatch.setattr(demo, "SECONDS", 1.0)
    monkeypatch.setattr(demo, "SIZE", SIZE)
    words = ["demo", "--cameras", "2", "--synchronised", "--lens", "none", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert "against the known answer" in printed
    assert str(tmp_path / "out" / "report.html") in printed
    assert not (tmp_path / "out" / "network.json").exists()
