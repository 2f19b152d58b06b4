"""report.html: self-contained, within its size, nothing injected, the numbers those of the calibration."""

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pytest
from report_input import LATE, NO_POINTS, SIZE, make_report_input

import epibar
from epibar.clocks import Timing
from epibar.geometry.epipolar import epipoles
from epibar.jobs.update_files import MOVED_KIND
from epibar.report.inputs import ReportCamera, ReportPair
from epibar.report.page import write_report
from epibar.report.prose import ADVICE, TITLES, advice
from epibar.show.line_barcodes import hull_barcodes
from epibar.show.moments import choose_moments
from epibar.sources.pictures import Pictures, as_jpeg

VERDICTS = Path(__file__).parent.parent / "rust/epibar/src/verify/verdict.rs"


class Page(HTMLParser):
    """Tags, attributes and the text of scripts and styles."""

    def __init__(self, path):
        super().__init__()
        self.tags, self.inline, self.text = [("", {})], {}, []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        tag, attrs = self.tags[-1]
        if tag in ("script", "style"):
            name = attrs.get("id", tag)
            self.inline[name] = self.inline.get(name, "") + data
        else:
            self.text.append(data)

    @property
    def data(self):
        def refuse(word):
            raise AssertionError(f"{word} in the payload")

        return json.loads(self.inline["data"], parse_constant=refuse)


@pytest.fixture(scope="module")
def report_input():
    return make_report_input()


@pytest.fixture(scope="module")
def page(report_input, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    assert write_report(path, *report_input, errors=["cam9.mp4: no such file"]) == path
    return Page(path)


def decoded(url):
    return cv2.imdecode(np.frombuffer(base64.b64decode(url.split(",")[1]), np.uint8), cv2.IMREAD_COLOR)


# --- one file ---


def test_nothing_is_loaded_from_anywhere(page):
    for tag, attributes in page.tags:
        assert tag not in ("link", "iframe", "object", "embed", "base"), tag
        for name in ("src", "href", "xlink:href", "srcset", "action"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:image/jpeg;base64,")), (tag, name, value)
    assert not re.search(r"@import|url\(", page.inline["style"])
    policy = next(a["content"] for t, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert "default-src 'none'" in policy
    assert "http" not in policy
    # The plotting library names addresses of maps it is never asked to draw; our own scripts name none.
    assert "http" not in page.inline["script"].replace("http://www.w3.org/2000/svg", "")


def test_four_cameras_stay_below_15_megabytes(report_input, tmp_path):
    """Noise, which JPEG cannot compress, and offsets by which no two pairs share a frame."""
    rng = np.random.default_rng(0)
    masks = np.zeros((150, 480, 640), np.uint8)
    for t in range(150):
        masks[t, 200:300, 4 * t : 4 * t + 60] = 1
    noise = Pictures(
        {t: as_jpeg(rng.integers(0, 256, (480, 640, 3), dtype=np.uint8)) for t in range(len(masks))}
    )
    recording = epibar.Recording.from_masks(masks, lines=100)
    cameras = [ReportCamera(f"cam{k}", "noise.avi", False, recording, noise) for k in range(4)]
    good = report_input[1][0].calibration
    pairs = [
        ReportPair(
            f"cam{a}", f"cam{b}", replace(good, time_offset=7.0 * a + b, frontier_points=NO_POINTS), 1.0
        )
        for a in range(4)
        for b in range(a + 1, 4)
    ]
    path = write_report(tmp_path / "report.html", cameras, pairs)
    assert 8_000_000 < path.stat().st_size < 15_000_000
    shown = [len(camera["images"]) for camera in Page(path).data["cameras"]]
    assert sum(shown) >= 6 * 16


def test_names_and_messages_cannot_inject_markup(report_input, page, tmp_path):
    evil = "</script><img src=x onerror=alert(1)><b>&amp;"
    cameras, pairs = report_input
    recording = epibar.Recording.from_masks(np.eye(40, dtype=bool)[None].repeat(80, 0), lines=50)
    recording.warnings = [evil]
    cameras = [replace(cameras[0], name=evil), replace(cameras[1], source=None), cameras[2]]
    cameras.append(ReportCamera("idle", evil, False, recording, None))
    calibration = replace(pairs[0].calibration, reason=evil, kind=evil, accepted=False)
    found = Page(
        write_report(tmp_path / "report.html", cameras, [ReportPair(evil, "cam2", calibration, 1.0)], [evil])
    )
    for tag in ("script", "img", "b"):
        expected = sum(name == tag for name, _ in page.tags)
        assert sum(name == tag for name, _ in found.tags) == expected, tag
    assert not any(name.startswith("on") for _, attributes in found.tags for name in attributes)
    assert found.data["cameras"][0]["name"] == evil
    assert found.data["pairs"][0]["reason"] == evil
    assert evil in "".join(found.text)


def test_unusable_input_is_named(report_input, tmp_path):
    cameras, pairs = report_input
    with pytest.raises(epibar.EpibarError, match="two cameras are called 'cam1'"):
        write_report(tmp_path / "report.html", [cameras[0], cameras[0]], [])
    with pytest.raises(epibar.EpibarError, match="unknown camera, 'cam3'"):
        write_report(tmp_path / "report.html", cameras[:2], pairs)
    with pytest.raises(epibar.EpibarError, match="missing"):
        write_report(tmp_path / "missing" / "report.html", cameras, pairs)


# --- what it says ---


def test_the_overview_needs_no_scripts(page):
    text = "".join(page.text)
    assert "3 cameras · 3 pairs · 1 accepted · 2 refused · 1 error" in text
    assert "cam9.mp4: no such file" in text
    cells = {a["href"]: a for t, a in page.tags if t == "a" and "cell" in a.get("class", "")}
    assert set(cells) == {"#pair-1", "#pair-2", "#pair-3"}
    assert "accepted" in cells["#pair-1"]["class"]
    for refused, word in (("#pair-2", "Ambiguous"), ("#pair-3", "No common scene")):
        assert "refused" in cells[refused]["class"].split()
        assert "accepted" not in cells[refused]["class"]
        assert word in cells[refused]["aria-label"]


def test_refused_pairs_say_what_to_do_next(page):
    accepted, ambiguous, nothing = page.data["pairs"]
    assert accepted["accepted"] is True
    assert accepted["advice"] == []
    assert ambiguous["accepted"] is nothing["accepted"] is False
    assert any("motion" in text for text in ambiguous["advice"])
    assert any("--time-offset 0" in text for text in nothing["advice"])


def test_too_little_evidence_is_told_from_none(report_input):
    nothing = report_input[1][2].calibration
    assert nothing.kind == "no_common_scene"
    for z, longer in ((None, False), (0.5, False), (4.8, True)):
        evidence = {} if z is None else {"z": z}
        told = advice(replace(nothing, evidence=evidence))
        assert told[0].startswith("Some evidence is there") is longer
        assert sum("film longer" in text.lower() for text in told) == 1


def test_a_far_point_does_not_squash_the_residuals(report_input, tmp_path):
    cameras, pairs = report_input
    points = pairs[0].calibration.frontier_points
    residual = points.residual.copy()
    residual[0] = 450.0
    calibration = replace(pairs[0].calibration, frontier_points=replace(points, residual=residual))
    path = write_report(tmp_path / "report.html", cameras, [replace(pairs[0], calibration=calibration)])
    shown = Page(path).data["pairs"][0]["residuals"]
    assert shown["furthest"] == 450
    assert shown["edges"][-1] == pytest.approx(10 * np.median(residual), abs=1e-3)
    assert sum(shown["counts"]) == len(residual)
    assert shown["counts"][-1] >= 1


@pytest.mark.skipif(not VERDICTS.exists(), reason="not a checkout")
def test_every_kind_of_verdict_has_words():
    kinds = set(re.findall(r'Self::\w+ => "(\w+)"', VERDICTS.read_text()))
    assert "accepted" in kinds
    assert MOVED_KIND not in kinds  # of a pair whose cameras were updated
    kinds |= {MOVED_KIND}
    assert set(TITLES) == kinds
    assert set(ADVICE) == kinds - {"accepted"}


def test_the_payload_has_the_numbers_of_the_calibration(report_input, page):
    pairs = report_input[1]
    for pair, entry in zip(pairs, page.data["pairs"], strict=True):
        calibration = pair.calibration
        if calibration.F is None:
            assert entry["F"] is None
        else:
            assert entry["F"] == calibration.F.tolist()
        assert entry["expected_error"] == calibration.expected_error
        assert entry["reason"] == calibration.reason
        assert sum((entry["residuals"] or {"counts": []})["counts"]) == len(calibration.frontier_points)
    points = pairs[0].calibration.frontier_points
    for moment in page.data["pairs"][0]["moments"]:
        here = points.frame == moment["a"]
        expected = np.column_stack([points.a[here], points.b[here], points.residual[here]])
        assert np.allclose(np.reshape(moment["points"], (-1, 5)), expected, atol=1e-3)
    assert sum(len(moment["points"]) for moment in page.data["pairs"][0]["moments"]) > 50


def test_error_maps_are_shown_where_there_are_any(report_input, tmp_path):
    cameras, pairs = report_input
    grids = np.arange(12.0).reshape(3, 4), np.full((3, 4), np.nan)
    for maps, expected in (((grids[0], grids[0] + 1), 3), ((grids[0], grids[1]), None), (None, None)):
        calibration = replace(pairs[0].calibration)
        object.__setattr__(calibration, "error_maps", maps)
        path = write_report(tmp_path / "report.html", cameras, [replace(pairs[0], calibration=calibration)])
        found = Page(path).data["pairs"][0]["error_maps"]
        assert (found and len(found[0])) == expected


def test_the_share_of_an_image_that_is_known(report_input, tmp_path):
    cameras, pairs = report_input
    grids = np.arange(12.0).reshape(3, 4), np.full((3, 4), 2.0)
    grids[1][0] = np.nan
    for accepted, expected in ((True, {"limit": 3, "shares": [0.3333, 1]}), (False, None)):
        calibration = replace(pairs[0].calibration, accepted=accepted)
        object.__setattr__(calibration, "error_maps", grids)
        path = write_report(tmp_path / "report.html", cameras, [replace(pairs[0], calibration=calibration)])
        assert Page(path).data["pairs"][0]["trusted"] == expected


# --- lines and barcodes ---


def test_the_lines_shown_are_epipolar_and_their_barcodes_agree(report_input, page):
    F = report_input[1][0].calibration.F
    entry = page.data["pairs"][0]
    shown = entry["line_sets"][0]
    assert shown["kind"] == "epipolar"
    assert len(shown["lines_a"]) >= 4
    for a, b in zip(shown["lines_a"], shown["lines_b"], strict=True):
        assert abs(np.dot(a, epipoles(F)[0])) < 1e-9
        on_a = np.cross(a, (1.0, 0.3, -50.0))  # where another line crosses it
        expected = F @ (on_a / np.linalg.norm(on_a))
        assert np.linalg.norm(np.cross(expected / np.linalg.norm(expected), b / np.linalg.norm(b))) < 1e-6
    assert np.median(shown["correlation"]) > 0.8
    count = len(entry["strip_frames"])
    rows = [
        np.unpackbits(np.frombuffer(base64.b64decode(text), np.uint8), count=count, bitorder="little")
        for text in shown["bits_a"]
    ]
    again = hull_barcodes(
        report_input[0][0].recording, np.array(shown["lines_a"]), np.array(entry["strip_frames"])
    )
    assert (np.array(rows) == again).all()


def test_barcodes_from_hulls_are_those_of_the_pixels(report_input):
    recording = report_input[0][0].recording
    x0, y0, x1, y1 = recording.segments[:400].T
    lines = np.column_stack([y0 - y1, x1 - x0, x0 * y1 - x1 * y0])
    lines /= np.hypot(lines[:, 0], lines[:, 1])[:, None]
    found = hull_barcodes(recording, lines, np.arange(recording.frames))
    words = recording.barcodes[:400].view(np.uint8)
    expected = np.unpackbits(words, axis=1, count=recording.frames, bitorder="little").astype(bool)
    assert expected.any(axis=1).sum() > 100
    assert (found == expected).mean() > 0.99


def test_without_a_matrix_the_best_candidates_are_shown_as_such(page):
    assert [shown["kind"] for shown in page.data["pairs"][2]["line_sets"]] == ["candidates"]


# --- frames ---


def test_b_shows_the_moment_of_a(page):
    for moment in page.data["pairs"][0]["moments"]:
        assert moment["b"] == moment["a"] + LATE
    assert all(moment["a"] == moment["b"] for moment in page.data["pairs"][1]["moments"])


def test_b_shows_the_moment_of_a_by_clocks_that_differ(report_input, tmp_path):
    """25 and 30 frames a second, and B's clock 1 % fast: 6 frames of B after 20 seconds."""
    masks = np.zeros((600, 48, 64), np.uint8)
    for t in range(600):
        masks[t, 10:30, t // 15 : t // 15 + 8] = 1
    a, b = (
        epibar.Recording.from_masks(masks[:count], fps, lines=50, name=name)
        for name, count, fps in (("a", 500, 25.0), ("b", 600, 30.0))
    )
    cameras = [ReportCamera(one.name, None, False, one, None) for one in (a, b)]
    timing = Timing(frames_per_frame=1.2 * 1.01, drift=10_000.0, drift_used=True)
    calibration = replace(
        report_input[1][0].calibration, time_offset=-6.5, timing=timing, frontier_points=NO_POINTS
    )
    path = write_report(tmp_path / "report.html", cameras, [ReportPair("a", "b", calibration, 1.0)])
    moments = Page(path).data["pairs"][0]["moments"]
    assert len(moments) == 16
    for moment in moments:
        assert abs(moment["b"] - (1.212 * moment["a"] - 6.5)) <= 0.5
    assert moments[-1]["b"] - (1.2 * moments[-1]["a"] - 6.5) > 4


def test_moments_that_other_pairs_show_come_first():
    common = np.column_stack([np.arange(100), np.arange(100)])
    worth = np.ones(100, np.int64)
    worth[:20] = 0
    worth[50] = 5
    chosen = choose_moments(common, worth, wanted_a={42}, wanted_b=set(), count=4)
    assert chosen[:, 0].tolist() == [20, 42, 60, 80]
    assert choose_moments(common, worth, set(), set(), count=4)[1, 0] == 50
    assert choose_moments(common[:0], worth[:0], set(), set()).shape == (0, 2)


def test_pictures_are_the_frames_they_claim_to_be(report_input, tmp_path):
    masks = np.zeros((100, 48, 64), np.uint8)
    for t in range(100):
        masks[t, 10:30, t // 2 : t // 2 + 8] = 1
    recording = epibar.Recording.from_masks(masks, lines=50)
    pictures = Pictures({t: as_jpeg(np.full((48, 64, 3), 2 * t, np.uint8)) for t in range(100)})
    cameras = [ReportCamera(name, "frames", False, recording, pictures) for name in "ab"]
    calibration = replace(report_input[1][0].calibration, time_offset=4.0, frontier_points=NO_POINTS)
    path = write_report(tmp_path / "report.html", cameras, [ReportPair("a", "b", calibration, 1.0)])
    data = Page(path).data
    moments = data["pairs"][0]["moments"]
    assert len(moments) == 16
    for camera, key in ((0, "a"), (1, "b")):
        for moment in moments:
            picture = decoded(data["cameras"][camera]["images"][str(moment[key])])
            assert picture.shape == (48, 64, 3)
            assert abs(picture.mean() - 2 * moment[key]) <= 1.5


def test_pictures_are_undistorted_with_the_intrinsics(report_input, tmp_path):
    rng = np.random.default_rng(1)
    image = cv2.resize(rng.integers(0, 256, (12, 16, 3), dtype=np.uint8), SIZE)
    (tmp_path / "frames").mkdir()
    for index in range(60):
        shown = image.copy()
        shown[100:110, 2 * index : 2 * index + 10] = 255 * (index % 2)
        cv2.imwrite(str(tmp_path / "frames" / f"{index:03d}.png"), shown)
    camera = epibar.Intrinsics("a", SIZE, [[250, 0, 160], [0, 250, 120], [0, 0, 1]], [-0.4, 0.1, 0, 0, 0])
    recorded = [
        epibar.record(tmp_path / "frames", lines=50, name=name, intrinsics=lens, pictures=True)
        for name, lens in (("a", camera), ("b", None))
    ]
    calibration = replace(report_input[1][0].calibration, time_offset=0.0, frontier_points=NO_POINTS)
    cameras = [ReportCamera(one.name, "frames", False, one, one.pictures) for one in recorded]
    path = write_report(tmp_path / "report.html", cameras, [ReportPair("a", "b", calibration, 1.0)])
    straight, bent = (
        decoded(next(iter(entry["images"].values()))).astype(int) for entry in Page(path).data["cameras"]
    )
    assert np.abs(straight - camera.undistort_image(image)).mean() < 4
    assert np.abs(bent - image).mean() < 4
    assert np.abs(straight - bent).mean() > 12


def test_moments_with_pictures_of_both_come_first(report_input, tmp_path):
    """The second camera's pictures are of other frames, but for ten moments."""
    cameras, pairs = report_input
    kept = [dict(camera.pictures) for camera in cameras[:2]]
    both = set(range(100, 150, 5))
    pictures = [
        Pictures({frame: jpeg for frame, jpeg in kept[0].items() if frame % 2 == 0 or frame in both}),
        Pictures({frame: jpeg for frame, jpeg in kept[1].items() if frame % 2 == 0 or frame - LATE in both}),
    ]
    pictures[1] = Pictures({f: j for f, j in pictures[1].items() if (f - LATE) % 2 == 1 or f - LATE in both})
    shown = [replace(camera, pictures=some) for camera, some in zip(cameras[:2], pictures, strict=True)]
    data = Page(write_report(tmp_path / "report.html", shown, pairs[:1])).data
    moments = [(str(moment["a"]), str(moment["b"])) for moment in data["pairs"][0]["moments"]]
    assert 8 <= len(moments) <= 10
    for a, b in moments:
        assert int(a) in both
        assert a in data["cameras"][0]["images"]
        assert b in data["cameras"][1]["images"]


def test_without_pictures_a_camera_shows_silhouettes(page):
    third = page.data["cameras"][2]
    assert third["images"] == {}
    shown = {str(moment["b"]) for moment in page.data["pairs"][1]["moments"]}
    assert shown <= set(third["hulls"])
    assert any(third["hulls"].values())
    assert len(page.data["cameras"][0]["images"]) >= 16
