"""How report.html opens with the network: its table, the numbers of its view, tracks, sizes, names."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from network_report_input import cameras, network, network_report, renamed, walkers
from test_report import Page

import epibar
from epibar.network import Ground
from epibar.network.walkers import WalkerTracks
from epibar.report import NetworkReport, read_tracks
from epibar.report.camera_angles import field_of_view, image_corners, tilt
from epibar.report.network_table import VERDICTS, camera_table
from epibar.report.page import write_report
from epibar.report.space_payload import magnification, nice

STATUSES = Path(__file__).parent.parent / "rust/epibar/src/network/result.rs"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    shown, made = network_report()
    path = tmp_path_factory.mktemp("report") / "report.html"
    return Page(write_report(path, shown, [], network=made))


def text_of(page):
    return " ".join(" ".join(page.text).split())


def rows(page):
    """Cells of each camera's row."""
    found, camera = {}, None
    for tag, attributes in page.tags:
        if tag == "tr":
            camera = attributes.get("data-camera")
        if tag == "td" and camera is not None and "data-label" in attributes:
            found.setdefault(camera, []).append(attributes["data-label"])
    return found


# --- what it says without scripts ---


def test_the_table_says_what_is_known_of_each_camera(page):
    text = text_of(page)
    assert list(rows(page)) == [f"cam{k}" for k in range(1, 6)]
    assert "3 of 5 cameras accepted, the others left out" in text
    assert "cam1 ✓ Accepted 700 px, 51° 0.80 −11.3° +0.000 s ± 1 ms 1 % · 0.2° · 0.002" in text
    assert "+0.500 s ± 1 ms, +3 ppm" in text
    assert "Left out: nothing in common with the others Left out: nothing moves in it." in text
    assert text.count("Left out: nothing moves in it.") == 2, "of two cameras, in the table alone"
    assert "cam4 ✕ Left out: nothing in common with the others Left out: nothing moves in it. unknown" in text
    assert "0.2 of the distance between cam1 and cam2 wide" in text
    assert "z = 0 is that floor" in text


def test_metres_and_a_missing_floor_are_said(tmp_path):
    made = network(unit="metre", refused=(), lost=())
    text = text_of(
        Page(write_report(tmp_path / "a.html", cameras(made.cameras), [], network=NetworkReport(made)))
    )
    assert "✓ Made up" in text
    assert "0.80 m" in text
    assert "A cell of the grid is 0.2 m wide." in text
    # A focal length that was given is not found to be right to 0 %.
    one = replace(made.cameras["cam1"], expected={"focal": 0.0, "rotation": 0.2, "position": 0.002})
    assert "given · 0.2° · 0.002 m" in camera_table(replace(made, cameras={**made.cameras, "cam1": one}))
    made = replace(made, ground=Ground("cameras"))
    text = text_of(
        Page(write_report(tmp_path / "b.html", cameras(made.cameras), [], network=NetworkReport(made)))
    )
    assert "No floor was found" in text
    assert "0.80 m" not in text


def test_a_network_of_nothing(tmp_path):
    made = network(refused=("cam1", "cam2", "cam5"), lost=("cam3", "cam4"), floor=False)
    names = [f"cam{k}" for k in range(1, 6)]
    lost = network(lost=names, floor=False)
    for one, count in ((made, 3), (lost, 0)):
        page = Page(write_report(tmp_path / "report.html", cameras(names), [], network=NetworkReport(one)))
        assert "Refused: no camera accepted" in text_of(page)
        assert len(page.data["space"]["cameras"]) == count


def test_why_there_is_none(tmp_path):
    report = NetworkReport(None, "two cameras <need> intrinsics")
    page = Page(write_report(tmp_path / "report.html", cameras(["a", "b"]), [], network=report))
    assert "No network: two cameras <need> intrinsics." in text_of(page)
    assert page.data["space"] is None


@pytest.mark.skipif(not STATUSES.exists(), reason="not a checkout")
def test_every_status_of_a_camera_has_words():
    text = STATUSES.read_text()
    block = text[text.index("impl CameraStatus") : text.index("pub struct NetworkCamera")]
    assert set(VERDICTS) == set(re.findall(r'=> "(\w+)"', block))


# --- the numbers of the view ---


def test_the_view_has_the_places_of_the_network(page):
    made, space = network(), page.data["space"]
    assert [one["name"] for one in space["cameras"]] == ["cam1", "cam2", "cam3", "cam5"]
    for one in space["cameras"]:
        camera = made.cameras[one["name"]]
        assert np.allclose(one["place"], camera.position, atol=1e-5)
        assert one["accepted"] is camera.accepted
        corners = np.array(one["corners"])
        seen = (corners - camera.position) @ camera.rotation.T
        assert np.allclose(seen[:, 2], seen[0, 2], atol=1e-4)
        assert seen[0, 0] < 0 < seen[1, 0], "clockwise from the upper left"
        assert seen[0, 1] < 0 < seen[2, 1]
    statuses = {(pair["a"], pair["b"]): pair["status"] for pair in space["pairs"]}
    assert statuses[0, 1] == "contradicts"
    assert statuses[0, 3] == "predicted"
    assert statuses[1, 3] == "confirmed"
    assert len(space["tracks"]) == 3
    assert np.allclose(space["tracks"][0], walkers()[0], atol=2e-3)


def test_a_camera_that_was_left_out_far_off_does_not_shrink_the_others(tmp_path):
    made = network()
    far = replace(made.cameras["cam3"], translation=np.array([0.0, 0.0, 1e7]))
    made = replace(made, cameras={**made.cameras, "cam3": far})
    page = Page(write_report(tmp_path / "r.html", cameras(made.cameras), [], network=NetworkReport(made)))
    space = page.data["space"]
    assert [one["name"] for one in space["cameras"]] == ["cam1", "cam2", "cam5"]
    assert space["floor"]["step"] < 1
    assert "cam3 ✕ Left out" in text_of(page)


def test_angles_are_those_of_the_lens():
    camera = network().cameras["cam1"]
    pinhole = replace(camera, distortions=np.zeros(5))
    assert field_of_view(pinhole) == pytest.approx(2 * np.degrees(np.arctan(320 / 700)))
    assert field_of_view(camera) > field_of_view(pinhole)
    assert tilt(camera) == pytest.approx(-np.degrees(np.arctan2(0.2, 1.0)))
    corners = image_corners(pinhole, 2.0)
    ray = (corners[0] - camera.position) @ camera.rotation.T
    assert np.allclose(ray, 2.0 * np.array([-320 / 700, -240 / 701, 1.0]))


def test_errors_are_enlarged_by_a_round_number():
    assert [nice(value) for value in (1.0, 1.9, 2.0, 4.99, 0.07, 730.0)] == [1, 1, 2, 2, 0.05, 500]
    made = network()
    assert magnification(made) == 20  # 0.03 of the extent of 2 and some, over 0.002
    coarse = {**made.cameras["cam1"].expected, "position": 3.0}
    large = {name: replace(one, expected=one.expected and coarse) for name, one in made.cameras.items()}
    assert magnification(replace(made, cameras=large)) == 1, "never made smaller"


# --- tracks ---


def test_tracks_are_read_and_cut_at_gaps(tmp_path):
    path = tmp_path / "tracks.csv"
    assert read_tracks(path) == []
    foot = np.array([[1, 2, 0], [1.5, 2, 0], [3, 3, 0], [1.2, 2, 0], [9, 9, 0]], float)
    WalkerTracks(
        names=("cam1", "cam2"),
        unit="metre",
        time=np.array([0.0, 0.4, 9.0, 0.2, 0.3]),
        track=np.array([7, 7, 7, 7, 8]),
        foot=foot,
        top=foot + np.array([0, 0, 1.7]),
        cameras=np.ones((5, 2), bool),
        residual=np.zeros(5),
    ).save(path)
    found = [track.tolist() for track in read_tracks(path)]
    assert found == [[[1, 2, 0], [1.2, 2, 0], [1.5, 2, 0]], [[3, 3, 0]], [[9, 9, 0]]]


@pytest.mark.parametrize("content", [b"time,track,x,y\n0,1,2,3\n", b"", b"\xff\xfe\x00", b'a,"b\x00'])
def test_other_tracks_are_refused_by_name(content, tmp_path):
    path = tmp_path / "tracks.csv"
    path.write_bytes(content)
    with pytest.raises(epibar.EpibarError, match=r"tracks\.csv.*not shown"):
        read_tracks(path)


# --- names, sizes ---


def test_names_cannot_inject_markup(tmp_path):
    made = network()
    evil = "</script><img src=x onerror=alert(1)><b>&amp;"
    names = {name: name for name in made.cameras} | {"cam1": evil, "cam4": '"><svg onload=alert(1)>'}
    made = renamed(made, names)
    lost = replace(made.cameras[names["cam4"]], reason=evil, status=evil)
    made = replace(made, cameras={**made.cameras, names["cam4"]: lost}, reason=evil)
    page = Page(write_report(tmp_path / "r.html", cameras(made.cameras), [], [evil], NetworkReport(made)))
    plain = network_report()
    expected = Page(write_report(tmp_path / "p.html", plain[0], [], ["x"], plain[1]))
    for tag in ("script", "img", "b", "svg"):
        assert sum(name == tag for name, _ in page.tags) == sum(name == tag for name, _ in expected.tags), tag
    assert not any(name.startswith("on") for _, attributes in page.tags for name in attributes)
    assert list(rows(page)) == list(names.values())
    assert page.data["space"]["cameras"][0]["name"] == evil
