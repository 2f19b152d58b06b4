"""``epibar check`` on the command line: its table, its JSON, its exit codes; the verdicts are made up."""

import json

import numpy as np
import pytest
from check_input import FEW, MOVED, SIZE, UNMOVED, UNSURE, network, some_masks, suspect
from network_input import made_up

from epibar.cli import main
from epibar.lens import Intrinsics, write_cameras


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
    assert "+1.20 % ± 0.3 %" in row
    assert row.endswith("12.3 s")
    assert "cam2: it is turned by 3.0 degrees" in printed.err


def test_a_shift_of_which_nothing_tells_is_said(core, folder, capsys):
    core.verdicts = {
        "cam1": {**UNMOVED, "shifted_error": float("inf"), "reason": "not a shift along the line"}
    }
    assert main(["check", str(folder), *videos(folder), *FEW]) == 0
    printed = capsys.readouterr()
    assert "± unknown" in next(line for line in printed.out.splitlines() if line.startswith("cam1"))
    assert "cam1: not a shift along the line" in printed.err
    assert "cam2:" not in printed.err.replace("cam2: 30 frames", "")


def test_a_camera_that_cannot_be_judged(core, folder, capsys):
    core.verdicts = {"cam3": UNSURE}
    assert main(["check", str(folder), *videos(folder), *FEW, "-q"]) == 4
    assert capsys.readouterr() == ("", "")


def test_one_of_two_cameras_has_moved(core, folder, capsys):
    core.verdicts = {"cam1": suspect("cam3"), "cam3": suspect("cam1")}
    assert main(["check", str(folder), *videos(folder), *FEW]) == 4
    printed = capsys.readouterr()
    rows = [line for line in printed.out.splitlines() if "MAY HAVE MOVED" in line]
    assert [row.split()[0] for row in rows] == ["cam1", "cam3"]
    assert "check: of 3 cameras one of cam1, cam3 has moved" in printed.out
    assert "cam1: it or cam3 moved" in printed.err
    assert main(["check", str(folder), *videos(folder), *FEW, "--json", "-q"]) == 4
    result = json.loads(capsys.readouterr().out)
    assert (result["ok"], result["moved"], result["suspects"]) == (False, [], ["cam1", "cam3"])
    assert result["cameras"]["cam1"]["rivals"] == ["cam3"]
    assert result["cameras"]["cam2"]["rivals"] == []


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


def test_videos_of_one_name_are_told_apart_by_their_folders(core, tmp_path, capsys):
    """As ``epibar calibrate`` names them."""
    made_up(3, refused=(), lost=(), names=["left_video", "right_video", "cam3"]).save(
        tmp_path / "network.json"
    )
    given = ["left/video.npz", "right/video.npz", "left/cam3.npz"]
    for k, file in enumerate(given):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        np.savez_compressed(tmp_path / file, masks=some_masks(k), fps=25.0)
    assert main(["check", str(tmp_path), *(str(tmp_path / file) for file in given), *FEW, "-q"]) == 0
    assert sorted(core.names) == ["cam3", "left_video", "right_video"]


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


def test_videos_and_options_in_any_order(core, folder):
    a, b = videos(folder, 1, 2)
    for words in (["--json", str(folder), *FEW, a, b], [str(folder), a, *FEW, b], [*FEW, str(folder), a, b]):
        core.names = None
        assert main(["check", *words, "-q"]) == 0
        assert core.names == ["cam1", "cam2"]


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
    assert [one["camera"]["distortions"] for one in core.cameras] == [[0.0] * 5] * 3
    moved = intrinsics.rename(folder / "elsewhere.toml")
    assert main(["check", str(folder), *videos(folder), *FEW]) == 2
    assert "--intrinsics says where" in capsys.readouterr().err
    core.cameras = None
    assert main(["check", str(folder), *videos(folder), *FEW, "--intrinsics", str(moved)]) == 0
    assert [one["camera"]["distortions"] for one in core.cameras] == [[0.0] * 5] * 3
