"""Has a camera moved? What is asked of the compiled module, what is refused, and what the command line says.

But for the last test the verdicts are made up, so that every kind of them is there.
"""

import functools
import json
from dataclasses import replace

import numpy as np
import pytest
from network_input import LINES, made_up

import epibar
from epibar import EpibarError, Recording, _core, synthetic
from epibar.cli import main
from epibar.lens import Intrinsics, write_cameras
from epibar.network import CameraCheck, NetworkCheck
from epibar.synthetic.settings import turned

SIZE = (640, 480)
FEW = ["--masks", "--lines", "50", "--time-offset", "0"]


def network():
    """cam1, cam2 and cam3 stand; cam4 was refused when the network was made."""
    return made_up(4, refused=(), lost=("cam4",))


def some_masks(seed=0, size=SIZE):
    masks = np.zeros((30, size[1], size[0]), bool)
    for t in range(30):
        masks[t, 100 + seed : 200, 8 * t : 8 * t + 40] = True
    return masks


def films(*names, size=SIZE, matrix=None):
    return {
        name: Recording.from_masks(some_masks(k, size), lines=50, matrix=matrix)
        for k, name in enumerate(names)
    }


UNMOVED = {
    "status": "unmoved",
    "reason": "what moves fits the stored camera",
    "turned": 0.01,
    "turned_error": 0.05,
    "shifted": 0.001,
    "shifted_error": 0.004,
    "focal": 0.0,
    "deviate": 0.3,
    "since": None,
}
MOVED = {
    "status": "moved",
    "reason": "it is turned by 3.0 degrees",
    "turned": 3.0123,
    "turned_error": 0.061,
    "shifted": 0.02,
    "shifted_error": float("inf"),
    "focal": 0.012,
    "deviate": 25.0,
    "since": 12.34,
}
UNSURE = {
    **dict.fromkeys(UNMOVED),
    "status": "unsure",
    "reason": "too little moves in it",
    "deviate": float("nan"),
}


class Stub:
    """Stands for the compiled module: says what it is told to say, and keeps what it was asked."""

    def __init__(self, **verdicts):
        self.verdicts = verdicts

    def __call__(self, recordings, names, cameras, clocks, progress):
        self.recordings, self.names, self.cameras, self.clocks = recordings, names, cameras, clocks
        if progress is not None:
            progress("anything", 1.0)
        return [{"name": name, **self.verdicts.get(name, UNMOVED)} for name in names]


@pytest.fixture
def core(monkeypatch):
    stub = Stub()
    monkeypatch.setattr(_core, "check_network", stub, raising=False)
    return stub


# --- from Python ---


def test_what_is_asked(core):
    told = []
    net = network()
    check = net.check(films("cam3", "cam1"), 0.0, lambda stage, share: told.append((stage, share)))
    assert told == [("check", 1.0)]
    assert core.names == ["cam3", "cam1"]
    assert core.clocks == ([0.0, 0.0], False, True)
    assert all(isinstance(one, _core.Recording) for one in core.recordings)
    stored = net.cameras["cam3"]
    assert core.cameras[0] == {
        "matrix": stored.matrix.tolist(),
        "distortions": stored.distortions.tolist(),
        "rotation": stored.rotation.tolist(),
        "translation": stored.translation.tolist(),
        "expected": stored.expected,
    }
    assert isinstance(check, NetworkCheck)
    assert check.ok
    assert check.moved == check.unsure == []
    assert check.cameras["cam1"] == CameraCheck(name="cam1", **UNMOVED)
    assert check.left_out.keys() == {"cam2", "cam4"}
    assert "no new recording" in check.left_out["cam2"]
    assert "not accepted" in check.left_out["cam4"]
    assert check.reason == "none of 2 cameras has moved; not looked at: cam2, cam4"


def test_clocks_are_against_the_first_that_is_looked_at(core):
    net = network()
    seconds = {"cam4": 1.0, "cam2": 1.5, "cam1": 3.0}
    net.check(films("cam4", "cam2", "cam1"), seconds)
    assert core.names == ["cam2", "cam1"]
    assert core.clocks == ([0.0, 1.5], False, True)


def test_clocks_are_found(core):
    stages = set()
    network().check(films("cam1", "cam2", "cam3"), progress=lambda stage, _: stages.add(stage))
    seconds, _, given = core.clocks
    assert len(seconds) == 3
    assert not given
    assert "check" in stages


def test_a_recording_without_its_lens(core):
    """Its distortions are none, and its matrix is the stored one or it is refused."""
    net = network()
    mine = films("cam2", matrix=net.cameras["cam2"].matrix)
    net.check({**films("cam1"), **mine}, 0.0)
    assert core.cameras[0]["distortions"] == net.cameras["cam1"].distortions.tolist()
    assert core.cameras[1]["distortions"] == [0.0] * 5
    other = net.cameras["cam2"].matrix * [[1.001], [1.001], [1]]
    with pytest.raises(EpibarError, match=r"cam2: .*another camera matrix"):
        net.check({**films("cam1"), **films("cam2", matrix=other)}, 0.0)


@pytest.mark.parametrize(
    ("names", "options", "told"),
    [
        (["cam1", "cam9"], {}, "cam9: the network has no camera of that name; it has cam1"),
        (["cam1"], {}, "at least two"),
        (["cam1", "cam4"], {}, "1 can be looked at .*cam4: not accepted"),
        (["cam1", "cam2"], {"time_offset": "soon"}, "soon"),
        (["cam1", "cam2", "cam3"], {"time_offset": 1.0}, "does not say whose"),
        (["cam1", "cam2"], {"search_seconds": 0}, "search_seconds"),
    ],
)
def test_what_is_refused(core, names, options, told):
    with pytest.raises(EpibarError, match=told):
        network().check(films(*names), **options)


def test_frames_of_another_size(core):
    with pytest.raises(EpibarError, match=r"cam2: 320x480 frames, .* at 640x480"):
        network().check({**films("cam1"), **films("cam2", size=(320, 480))}, 0.0)


def test_what_the_compiled_module_refuses_is_told(monkeypatch):
    def refused(*_):
        raise ValueError("cam1: no frames")

    monkeypatch.setattr(_core, "check_network", refused, raising=False)
    with pytest.raises(EpibarError, match="cam1: no frames"):
        network().check(films("cam1", "cam2"), 0.0)


@pytest.mark.parametrize(
    ("verdicts", "reason"),
    [
        ({"cam2": MOVED}, "of 3 cameras cam2 has moved"),
        ({"cam1": MOVED, "cam2": MOVED}, "of 3 cameras cam1, cam2 have moved"),
        ({"cam2": UNSURE}, "of 3 cameras none is known to have moved, but cam2 cannot be judged"),
        ({"cam1": MOVED, "cam3": UNSURE}, "of 3 cameras cam1 has moved, and cam3 cannot be judged"),
    ],
)
def test_sentences(core, verdicts, reason):
    core.verdicts = verdicts
    check = network().check(films("cam1", "cam2", "cam3"), 0.0)
    assert not check.ok
    assert check.reason == f"{reason}; not looked at: cam4"


# --- from the command line ---


@pytest.fixture
def folder(tmp_path):
    network().save(tmp_path / "network.json")
    for k in range(4):
        np.savez_compressed(tmp_path / f"cam{k + 1}.npz", masks=some_masks(k), fps=25.0)
    return tmp_path


def videos(folder, *numbers):
    return [str(folder / f"cam{number}.npz") for number in numbers or (1, 2, 3, 4)]


def test_nothing_has_moved(core, folder, capsys):
    before = {path.name for path in folder.iterdir()}
    assert main(["check", str(folder), *videos(folder), *FEW]) == 0
    printed = capsys.readouterr()
    assert core.names == ["cam1", "cam2", "cam3"]
    table = printed.out.splitlines()
    assert table[0].split("  ")[0] == "camera"
    assert "cam1    has not moved" in table[1]
    assert "0.01° ± 0.05°" in table[1]
    assert table[-1] == "check: none of 3 cameras has moved; not looked at: cam4"
    assert "cam4 was not looked at: not accepted" in printed.err
    assert "distance between cam1 and cam2" in printed.err
    assert {path.name for path in folder.iterdir()} == before


def test_a_camera_has_moved(core, folder, capsys):
    core.verdicts = {"cam2": MOVED}
    assert main(["check", str(folder), *videos(folder), *FEW]) == 4
    printed = capsys.readouterr()
    (row,) = (line for line in printed.out.splitlines() if line.startswith("cam2"))
    assert row.startswith("cam2    HAS MOVED")
    assert "3.01° ± 0.061°" in row
    assert "0.02 ± unknown" in row
    assert "+1.2 %" in row
    assert row.endswith("12.3 s")
    assert "cam2: it is turned by 3.0 degrees" in printed.err


def test_a_camera_that_cannot_be_judged(core, folder, capsys):
    core.verdicts = {"cam3": UNSURE}
    assert main(["check", str(folder), *videos(folder), *FEW, "-q"]) == 4
    assert capsys.readouterr() == ("", "")


def test_for_programs(core, folder, capsys):
    """However quiet, one object on stdout, in which no number is infinite."""
    core.verdicts = {"cam2": MOVED, "cam3": UNSURE}
    assert main(["check", str(folder), *videos(folder), *FEW, "--json"]) == 4
    printed = capsys.readouterr()
    result = json.loads(printed.out, parse_constant=pytest.fail)
    assert "HAS MOVED" in printed.err
    assert result["ok"] is False
    assert result["moved"] == ["cam2"]
    assert result["unsure"] == ["cam3"]
    assert result["reason"].startswith("of 3 cameras cam2 has moved, and cam3 cannot be judged")
    assert result["unit"] == "baseline"
    assert result["cameras"]["cam2"] == {**MOVED, "name": "cam2", "shifted_error": None}
    assert result["cameras"]["cam3"]["deviate"] is None
    assert result["left_out"].keys() == {"cam4"}
    assert main(["check", str(folder), *videos(folder, 1, 2), *FEW, "--json", "-q"]) == 4
    printed = capsys.readouterr()
    assert json.loads(printed.out)["moved"] == ["cam2"]
    assert printed.err == ""


def test_a_video_that_cannot_be_read(core, folder, capsys):
    """The others are checked; nobody is told that all is well."""
    (folder / "cam2.npz").write_bytes(b"damaged")
    assert main(["check", str(folder), *videos(folder), *FEW, "--json"]) == 3
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    assert core.names == ["cam1", "cam3"]
    assert result["ok"] is False
    assert result["unsure"] == ["cam2"]
    assert "cam2.npz" in result["cameras"]["cam2"]["reason"]
    assert result["left_out"].keys() == {"cam4"}
    core.verdicts = {"cam1": MOVED}
    assert main(["check", str(folder), *videos(folder), *FEW]) == 4
    (folder / "cam3.npz").unlink()
    capsys.readouterr()
    assert main(["check", str(folder), *videos(folder), *FEW, "--json"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "fewer than two" in printed.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["{0}/cam1.npz", "{0}/other.npz"], "other: the network has no camera of that name"),
        (["{0}/cam1.npz", "{0}/cam4.npz"], "at least two"),
        (["{0}/cam1.npz", "{0}/more/cam1.npz"], "both of camera cam1"),
        (["{0}/cam1.npz", "{0}/cam2.npz", "{0}/cam3.npz", "--time-offset", "3"], "--time-offset 3 with 3"),
        (["{0}/cam1.npz", "{0}/cam2.npz", "--background", "b"], "--background: 1 given for 2"),
        (["{0}/cam1.npz", "{0}/cam2.npz", "--intrinsics", "none.toml"], "none.toml"),
        ([], "VIDEO"),
    ],
)
def test_what_does_not_fit_is_refused_before_any_work(core, folder, words, told, capsys):
    assert main(["check", str(folder), *(word.format(folder) for word in words), "--masks"]) == 2
    printed = capsys.readouterr()
    assert told in printed.err
    assert "frames of" not in printed.err


def test_no_network(tmp_path, capsys):
    assert main(["check", str(tmp_path), "a.mp4", "b.mp4"]) == 2
    assert "network.json: no such file" in capsys.readouterr().err
    (tmp_path / "network.json").write_text("{}")
    assert main(["check", str(tmp_path), "a.mp4", "b.mp4"]) == 2
    assert "not a network" in capsys.readouterr().err


def test_an_offset_of_two_cameras_is_in_frames(core, folder):
    words = ["--masks", "--lines", "50", "--time-offset", "5"]
    assert main(["check", str(folder), *videos(folder, 1, 2), *words, "-q"]) == 0
    seconds, _, given = core.clocks
    assert seconds == pytest.approx([0, 0.2])
    assert given


# --- lenses ---


def with_calibration(folder, intrinsics):
    """What a run leaves that took lenses out of its recordings."""
    net = network()
    known = [
        Intrinsics(name, SIZE, camera.matrix, [-0.2, 0.0, 0.0, 0.0, 0.0])
        for name, camera in net.cameras.items()
        if camera.matrix is not None
    ]
    write_cameras(intrinsics, known)
    cameras = [
        {"name": one.name, "width": 640, "height": 480, "matrix": one.matrix.tolist(), "index": k}
        for k, one in enumerate(known)
    ]
    content = {"format": 1, "cameras": cameras, "pairs": [], "intrinsics": str(intrinsics)}
    (folder / "calibration.json").write_text(json.dumps(content))


def test_lenses_that_the_run_took_out_are_taken_out_again(core, folder, capsys):
    intrinsics = folder / "known.toml"
    with_calibration(folder, intrinsics)
    assert main(["check", str(folder), *videos(folder), *FEW]) == 0, capsys.readouterr().err
    assert [one["distortions"] for one in core.cameras] == [[0.0] * 5] * 3
    moved = intrinsics.rename(folder / "elsewhere.toml")
    assert main(["check", str(folder), *videos(folder), *FEW]) == 2
    assert "--intrinsics says where" in capsys.readouterr().err
    core.cameras = None
    assert main(["check", str(folder), *videos(folder), *FEW, "--intrinsics", str(moved)]) == 0
    assert [one["distortions"] for one in core.cameras] == [[0.0] * 5] * 3


# --- the real thing ---

BEFORE, AFTER = 600, 700
"""Frames that the network is made of, and where the new footage starts."""


@functools.cache
def situation():
    return synthetic.situation(3, "network_plain")


def recorded(camera, first, last, film=None):
    made = situation()
    film = film or made.films[camera]
    return Recording.from_masks(
        np.stack(list(film.iter_masks(first, last))), fps=made.clocks[camera].fps, lines=LINES, seed=camera
    )


@pytest.mark.skipif(
    not hasattr(_core, "check_network"), reason="the compiled module has no check_network yet"
)
def test_a_camera_that_was_turned_is_found(tmp_path):
    """Four cameras calibrated, filmed again later: as they stood, and with the third turned by 3 degrees."""
    before = {f"cam{k + 1}": recorded(k, 0, BEFORE) for k in range(4)}
    net = epibar.calibrate_network(before, time_offset=0.0)
    assert net.accepted, net.reason
    net.save(tmp_path / "network.json")
    net = epibar.Network.load(tmp_path / "network.json")
    after = {f"cam{k + 1}": recorded(k, AFTER, AFTER + 600) for k in range(4)}
    same = net.check(after)
    assert same.ok, same.reason
    film = situation().films[2]
    knocked = replace(film, camera=turned(film.camera, np.random.default_rng(0), 3.0))
    after["cam3"] = recorded(2, AFTER, AFTER + 600, knocked)
    check = net.check(after)
    assert check.moved == ["cam3"], check.reason
    found = check.cameras["cam3"]
    assert found.turned == pytest.approx(3.0, abs=1.0)
