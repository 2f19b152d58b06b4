"""report.html is written anew where ``scale`` and ``check --update`` change the network, without a video."""

import json
import shutil

import numpy as np
import pytest
from check_input import films, replaced, stand_in
from network_input import LINES, made_up, situation
from test_report import Page

import epibar
from epibar.cli import main
from epibar.jobs.folder import Folder
from epibar.jobs.stored_report import rewrite_report


@pytest.fixture(scope="module")
def done(masks, tmp_path_factory):
    """A run of three cameras of which nothing is known, whose input is not there afterwards."""
    out = tmp_path_factory.mktemp("run") / "out"
    inputs = [shutil.copy(path, out.parent) for path in masks]
    assert main(["calibrate", *inputs, "--out", str(out), "--masks", "--lines", str(LINES), "--quiet"]) == 0
    for path in inputs:
        (out.parent / path).unlink()
    return out


def rewrite(out, network):
    with Folder(out) as folder:
        return rewrite_report(folder, network)


def report(out):
    return (out / "report.html").read_bytes()


def places(page):
    return {one["name"]: one["place"] for one in page.data["space"]["cameras"]}


def test_of_the_same_network_it_is_the_same(again):
    before = report(again)
    (again / "report.html").write_text("something else")
    assert rewrite(again, epibar.Network.load(again / "network.json")) == []
    assert report(again) == before


def test_scale(again, capsys):
    before = Page(again / "report.html")
    assert main(["scale", str(again), "--distance", "cam1", "cam2", "13.50+-0.03"]) == 0
    printed = capsys.readouterr()
    assert "report.html" not in printed.err
    after = Page(again / "report.html")
    assert after.data["pairs"] == before.data["pairs"]
    assert after.data["cameras"] == before.data["cameras"]
    assert np.linalg.norm(np.subtract(*list(places(after).values())[:2])) == pytest.approx(13.5, rel=1e-3)
    assert np.linalg.norm(np.subtract(*list(places(before).values())[:2])) == pytest.approx(1.0, rel=1e-3)
    size = [np.ptp(np.concatenate(page.data["space"]["tracks"]), axis=0) for page in (before, after)]
    np.testing.assert_allclose(size[1], 13.5 * size[0], rtol=0.02)
    shown = "".join(after.text)
    assert "13.5 m between cam1 and cam2" in shown
    assert "13.5 m between" not in "".join(before.text)


def test_check_update(masks, again, monkeypatch, capsys):
    """Pairs of what moved are marked, and lose the matrix of before; all else of them stays."""
    net = epibar.Network.load(again / "network.json")
    before = Page(again / "report.html")
    core = stand_in(monkeypatch)
    core.verdicts = {"cam2": replaced(net.cameras["cam2"], ["cam1", "cam3"])}
    words = ["--masks", "--lines", "50", "--time-offset", "0", "--frames", ":60", "--update"]
    assert main(["check", str(again), *masks, *words]) == 0
    assert "report.html" not in capsys.readouterr().err
    after = Page(again / "report.html")
    was, now = places(before), places(after)
    updated = epibar.Network.load(again / "network.json").cameras["cam2"]
    np.testing.assert_allclose(now["cam2"], updated.position, atol=2e-3)
    assert (now["cam1"], now["cam3"]) == (was["cam1"], was["cam3"])
    focal = f"{updated.matrix[0, 0]:.0f}"
    assert focal in "".join(after.text)
    assert focal not in "".join(before.text)
    for one, other in zip(before.data["pairs"], after.data["pairs"], strict=True):
        if 1 in (one["a"], one["b"]):
            assert (other["kind"], other["accepted"], other["F"]) == ("moved", False, None)
            assert other["verdict"] == "A camera has moved since"
            assert "cam2 moved after the pair was calibrated" in other["reason"]
            assert other["evidence"] == one["evidence"]
        else:  # moments are chosen among those that other pairs show
            assert {**other, "moments": None} == {**one, "moments": None}
    # Metres afterwards: both are shown.
    assert main(["scale", str(again), "--person-height", "1.7"]) == 0
    assert [pair["kind"] for pair in Page(again / "report.html").data["pairs"]].count("moved") == 2
    assert "m of people" in "".join(Page(again / "report.html").text)


def test_a_run_without_a_report_gets_none(again):
    (again / "report.html").unlink()
    assert main(["scale", str(again), "--person-height", "1.7", "--quiet"]) == 0
    assert not (again / "report.html").exists()


def test_somebody_elses_report_stays(again):
    path = again / ".epibar" / "written.json"
    listed = json.loads(path.read_text())
    listed["files"].remove("report.html")
    path.write_text(json.dumps(listed))
    before = report(again)
    (told,) = rewrite(again, made_up(3))
    assert "not written by epibar" in told
    assert report(again) == before


def missing_recording(out):
    (out / "recordings" / "cam2.npz").unlink()


def other_recording(out):
    films("cam2")["cam2"].save(out / "recordings" / "cam2.npz")


def damaged_pair(out):
    (out / "pairs" / "cam1_cam3.npz").write_bytes(b"PK")


def other_pair(out):
    shutil.copy(out / "pairs" / "cam1_cam2.npz", out / "pairs" / "cam1_cam3.npz")


def damaged_entry(out):
    content = json.loads((out / "calibration.json").read_text())
    content["pairs"][0]["picture"] = "../cam1_cam2.png"
    (out / "calibration.json").write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (missing_recording, "cam2.npz, the recording of cam2, is not there"),
        (other_recording, "cam2.npz is of another run than"),
        (damaged_pair, "cam1_cam3.npz"),
        (other_pair, "cam1_cam3.npz is of another run than"),
        (damaged_entry, "pairs[0].picture"),
    ],
)
def test_where_it_cannot_be_made_it_is_told_what_is_stale(change, named, again, capsys):
    change(again)
    before = report(again)
    assert main(["scale", str(again), "--distance", "cam1", "cam2", "13.5"]) == 0
    told = capsys.readouterr().err
    assert "still shows the network as it was, its cameras and its view in space" in told
    assert named in told
    assert report(again) == before
    assert epibar.Network.load(again / "network.json").unit == "metre"


def test_pictures_that_are_damaged(again, capsys):
    (again / "pictures").mkdir(exist_ok=True)
    (again / "pictures" / "cam1.npz").write_bytes(b"PK")
    assert main(["scale", str(again), "--distance", "cam1", "cam2", "13.5"]) == 0
    assert "silhouettes are shown instead" in capsys.readouterr().err
    assert "13.5 m between" in "".join(Page(again / "report.html").text)


def test_saved_recordings_are_read_from_where_they_were(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for k in range(2):
        situation().recording(k, lines=200, frames=80).save(f"cam{k + 1}.npz")
    words = ["--method", "lines", "--quiet"]
    assert main(["calibrate", "cam1.npz", "cam2.npz", "--out", "out", *words]) == 0
    data = Page(tmp_path / "out" / "report.html").data
    assert rewrite(tmp_path / "out", made_up(2)) == []
    page = Page(tmp_path / "out" / "report.html")
    assert page.data["pairs"] == data["pairs"]
    assert len(page.data["space"]["cameras"]) == 2
    (tmp_path / "cam2.npz").unlink()
    (told,) = rewrite(tmp_path / "out", made_up(2))
    assert "cam2.npz, the recording of cam2, is not there" in told
