"""The live view, written to a file without a viewer and read back."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import epibar
from epibar import live, synthetic
from epibar.clocks import Timing

OFFSET = 7


@pytest.fixture(scope="module")
def scene():
    return synthetic.people(seed=3, cameras=2, walkers=3, frames=60, size=(320, 240), asymmetric=True)


@pytest.fixture(scope="module")
def recordings(scene):
    return [
        epibar.Recording.from_masks(scene.masks(index), fps=scene.fps, lines=500, name=f"cam {index + 1}")
        for index in (0, 1)
    ]


@pytest.fixture(scope="module")
def calibration(scene):
    """The true F and exact points, with B's clock ahead of A's."""
    a, b = (points[:200] for points in scene.volume_correspondences(0, 1))
    frame = np.arange(len(a)) % 40
    F = scene.fundamental(0, 1)
    points = epibar.FrontierPoints(frame, a, b, epibar.symmetric_epipolar_distance(F, a, b))
    none = epibar.Candidates(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0, bool))
    return epibar.Calibration(F, True, "accepted", "made up", 0.1, OFFSET, none, points, {})


@pytest.fixture
def rerun():
    return pytest.importorskip("rerun", reason="rerun-sdk, the extra 'live', is not installed")


def read(path, ending):
    """Rows of an entity: frame of the common time line, and what was logged."""
    from rerun.chunk import RrdReader

    rows = {}
    for chunk in RrdReader(path).stream():
        if str(chunk.entity_path).replace("\\", "") != ending:
            continue
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if name != "log_time" and ":" in name]
        frames = batch.column(batch.schema.names.index("frame")).to_pylist()
        columns = {name: batch.column(batch.schema.names.index(name)) for name in names}
        for row, frame in enumerate(frames):
            rows.setdefault(frame, {}).update(
                {name: column[row].as_py() for name, column in columns.items() if column[row].is_valid}
            )
    return rows


def test_everything_is_on_one_time_line(rerun, scene, recordings, calibration, tmp_path):
    videos = [
        synthetic.render_video(scene, index, tmp_path / f"cam{index + 1}.avi", empty_frames=0)
        for index in (0, 1)
    ]
    out = tmp_path / "run.rrd"
    live.save(out, recordings, {(0, 1): calibration}, videos)
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".part"] == []

    dots_a, dots_b = read(out, "/cam 1/points/cam 2"), read(out, "/cam 2/points/cam 1")
    lines_b = read(out, "/cam 2/lines/cam 1")
    points = calibration.frontier_points
    for frame in (0, 11, 39):
        mine = points.frame == frame
        np.testing.assert_allclose(dots_a[frame]["Points2D:positions"], points.a[mine], atol=1e-3)
        np.testing.assert_allclose(dots_b[frame]["Points2D:positions"], points.b[mine], atol=1e-3)
        assert dots_a[frame]["Points2D:colors"] == dots_b[frame]["Points2D:colors"]
        # Each point of B lies on the line that its fellow in A has there.
        for strip, point in zip(lines_b[frame]["LineStrips2D:strips"], points.b[mine], strict=True):
            (x0, y0), (x1, y1) = strip
            along = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
            assert abs(np.cross([*along, 0], [*(point - [x0, y0]), 0])[2]) < 1e-2
    assert dots_a[50]["Points2D:positions"] == []

    # Frame 0 of B is 7 frames before frame 0 of A.
    for entity in ("silhouettes", "image"):
        assert sorted(read(out, f"/cam 1/{entity}")) == list(range(60))
        assert sorted(read(out, f"/cam 2/{entity}")) == list(range(-OFFSET, 60 - OFFSET))
    outlines = read(out, "/cam 2/silhouettes")[20]["LineStrips2D:strips"]
    hulls = recordings[1].hulls(20 + OFFSET)
    assert len(outlines) == len(hulls)
    np.testing.assert_allclose(outlines[0][:-1], hulls[0], atol=1e-3)


def test_clocks_that_differ_share_one_time_line(rerun, calibration, tmp_path):
    """B films 30 frames a second to A's 25, its clock is 2 % fast, and C is known through B only."""
    masks = np.zeros((1800, 8, 8), np.uint8)
    a, b, c = (
        epibar.Recording.from_masks(masks[:count], fps, lines=10, name=name)
        for name, count, fps in (("a", 1500, 25.0), ("b", 1800, 30.0), ("c", 1500, 25.0))
    )
    ab = replace(calibration, F=None, time_offset=15.0, timing=Timing(1.2 * 1.02))
    cb = replace(calibration, F=None, time_offset=-30.0, timing=Timing(1.2 * 1.02))
    live.save(tmp_path / "run.rrd", [a, b, c], {(0, 1): ab, (2, 1): cb}, every=300)
    # Frame 1500 of B is 50 s by its clock: 49.5 s after A's frame 0, which is 48.53 s by A's.
    expected = [round(25 * (n / 30 - 0.5) / 1.02) for n in range(0, 1800, 300)]
    assert sorted(read(tmp_path / "run.rrd", "/b/silhouettes")) == expected
    # C's clock runs as A's, and its frame 0 is 1.5 s by B's before A's.
    expected = [round(n - 25 * 1.5 / 1.02) for n in range(0, 1500, 300)]
    assert sorted(read(tmp_path / "run.rrd", "/c/silhouettes")) == expected


def test_every_so_many_frames(rerun, recordings, calibration, tmp_path):
    live.save(tmp_path / "run.rrd", recordings, {(0, 1): calibration}, every=20)
    assert sorted(read(tmp_path / "run.rrd", "/cam 1/silhouettes")) == [0, 20, 40]


def test_a_pair_without_f_has_no_lines(rerun, recordings, calibration, tmp_path):
    live.save(tmp_path / "run.rrd", recordings, {(0, 1): replace(calibration, F=None)}, every=20)
    assert read(tmp_path / "run.rrd", "/cam 1/lines/cam 2") == {}
    assert read(tmp_path / "run.rrd", "/cam 1/silhouettes") != {}


def test_what_cannot_be_shown(rerun, recordings, calibration, scene, tmp_path):
    out = tmp_path / "run.rrd"
    other = synthetic.render_video(scene, 1, tmp_path / "other.avi", empty_frames=0)
    for arguments, words in (
        (([], {}), "recordings is empty"),
        (([recordings[0]] * 2, {}), "its own name"),
        ((recordings, {(0, 5): calibration}), "two places in recordings"),
        ((recordings, {}, [other]), "videos holds 1, expected one for each of 2"),
        ((recordings, {}, [other, None]), "other.avi: 400x300 frames"),
        ((recordings, {}, ["missing.mp4", None]), "missing.mp4"),
    ):
        with pytest.raises(epibar.EpibarError, match=words):
            live.save(out, *arguments)
    assert not out.exists()
    with pytest.raises(epibar.EpibarError, match="no folder"):
        live.save(tmp_path / "missing" / "run.rrd", recordings, {})
    with pytest.raises(epibar.EpibarError, match="every = 0"):
        live.save(out, recordings, {}, every=0)


def test_without_rerun_the_message_says_what_to_install(recordings, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(epibar.EpibarError, match=r"epibar\[live\]"):
        live.save(tmp_path / "run.rrd", recordings, {})
