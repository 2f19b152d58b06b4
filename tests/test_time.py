"""The clocks of two cameras as a user meets them, and the maps of the expected error."""

from dataclasses import replace

import numpy as np
import pytest

import epibar
from epibar import plot, synthetic
from epibar.clocks import Timing, common_frames, frame_interval, frames_of_b, positions_in_b
from epibar.files.frontier_csv import write_frontier_points
from epibar.files.json_file import write_json
from epibar.outcome.entries import camera_entry
from epibar.outcome.run import Run
from epibar.recording import new_recorder

LINES = 4000
FPS = 25.0
LENGTH = 10.0
START = {"a": 3.26, "b": 1.0}
"""Seconds of the scene at which each camera's film begins."""
OFFSET_SECONDS = START["a"] - START["b"]


@pytest.fixture(scope="module")
def scene():
    return synthetic.cubes(seed=4, cameras=4, objects=8, frames=700, fps=50.0, size=(400, 300))


def film(scene, camera, start, fps, length=LENGTH, rate=1.0):
    """Record a camera that films on its own; its clock is fast by ``rate``."""
    view = scene.filmed_at(start + np.arange(int(length * fps)) / fps / rate, fps)
    return epibar.Recording.from_masks(view.masks(camera), fps, LINES, camera)


@pytest.fixture(scope="module")
def late_a(scene):
    return film(scene, 0, START["a"], FPS)


@pytest.fixture(scope="module")
def cal(scene, late_a):
    b = film(scene, 1, START["b"], FPS, length=12.0)
    return epibar.calibrate(late_a, b, time_offset="search", search_seconds=5.0, draws=3000)


def error(scene, F):
    return epibar.symmetric_epipolar_distance(F, *scene.volume_correspondences(0, 1)).mean()


def test_a_film_of_other_moments_is_the_scene_between_its_frames(scene):
    whole = scene.filmed_at(np.array([0.2, 0.4]), 5.0)
    assert whole.frames == 2
    assert whole.fps == 5.0
    assert (whole.masks(1) == [scene.masks(1, 10, 11)[0], scene.masks(1, 20, 21)[0]]).all()
    solids = scene.solids
    between = scene.filmed_at(np.array([0.21]), 25.0).solids
    assert np.allclose(between.centres[0], 0.5 * (solids.centres[10] + solids.centres[11]))
    assert np.allclose(between.axes[0], 0.5 * (solids.axes[10] + solids.axes[11]))


def test_a_search_finds_a_fraction_of_a_frame(scene, cal):
    assert cal.accepted, cal.reason
    assert cal.time_offset == pytest.approx(OFFSET_SECONDS * FPS, abs=0.05)  # 56.5 frames
    assert cal.timing.offset_uncertainty < 0.05
    assert cal.timing.offsets_tried == 251
    assert cal.timing.frames_per_frame == 1.0
    assert abs(cal.timing.runner_up - cal.time_offset) > FPS
    assert cal.timing.runner_up_share < 1
    assert cal.frame_of_b([0, 10]) == pytest.approx([cal.time_offset, cal.time_offset + 10])
    assert error(scene, cal.F) < 0.4


def test_no_offset_is_tried_before_one_is_searched(scene, late_a, cal):
    b = film(scene, 1, START["b"], FPS, length=12.0)
    found = epibar.calibrate(late_a, b, time_offset="auto", search_seconds=5.0, draws=3000)
    assert (found.F == cal.F).all()
    assert found.time_offset == cal.time_offset
    at_once = film(scene, 1, START["a"], FPS)
    together = epibar.calibrate(late_a, at_once, time_offset="auto", search_seconds=5.0, draws=3000)
    assert together.accepted
    assert together.time_offset == 0.0
    with pytest.raises(epibar.EpibarError, match=r"time_offset = 'soon': .* 'search' or 'auto'"):
        epibar.calibrate(late_a, b, time_offset="soon")


def test_different_rates_meet(scene, late_a):
    b = film(scene, 1, START["b"], 30.0, length=12.0)
    cal = epibar.calibrate(late_a, b, time_offset=OFFSET_SECONDS * 30.0, draws=3000)
    assert cal.accepted, cal.reason
    assert cal.time_offset == OFFSET_SECONDS * 30.0
    assert cal.timing.frames_per_frame == pytest.approx(1.2)
    assert cal.timing.offset_uncertainty is None
    assert cal.timing.offsets_tried == 1
    assert error(scene, cal.F) < 0.4
    common = common_frames(late_a, b, cal)
    assert len(common) == cal.counts["frames"]  # as the compiled module has it
    seconds = START["a"] + common[:, 0] / FPS - START["b"]
    assert np.abs(seconds - common[:, 1] / 30.0).max() <= 0.5 / 30.0 + 1e-9
    _, right = plot.epipolar_lines(cal, late_a, b, frame=200)
    assert right.get_title() == "camera B, frame 308"  # 67.8 + 1.2 * 200


def test_unrelated_recordings_have_no_offset(late_a):
    other = synthetic.cubes(
        seed=4, cameras=4, objects=8, frames=700, fps=50.0, size=(400, 300), motion_seed=9
    )
    b = film(other, 1, START["b"], FPS, length=12.0)
    cal = epibar.calibrate(late_a, b, time_offset="search", search_seconds=8.0, draws=3000)
    assert not cal.accepted
    assert cal.kind == "no_common_scene", cal.reason
    assert cal.timing.offsets_tried == 401
    assert cal.timing.offset_uncertainty is None
    assert cal.clock_drift is None


@pytest.mark.parametrize("search_seconds", [0, -1.0, np.nan, np.inf, "long", None])
def test_a_range_that_is_none(late_a, search_seconds):
    with pytest.raises(epibar.EpibarError, match="search_seconds"):
        epibar.calibrate(late_a, late_a, time_offset="search", search_seconds=search_seconds)


def test_an_offset_that_is_right_to_a_frame_is_sharpened(scene, late_a):
    b = film(scene, 1, START["b"], FPS, length=12.0)
    rough = OFFSET_SECONDS * FPS + 1.3
    cal = epibar.calibrate(late_a, b, time_offset=rough, sharpen_offset=True, draws=3000)
    assert cal.accepted
    assert cal.time_offset == pytest.approx(OFFSET_SECONDS * FPS, abs=0.05)


@pytest.mark.parametrize("time_offset", [250.0, -251.5, 1e6])
def test_an_offset_beyond_both_recordings(late_a, time_offset):
    with pytest.raises(epibar.EpibarError, match="none in common"):
        epibar.calibrate(late_a, late_a, time_offset=time_offset)


# --- which frame of B is which frame of A ---


def seen_at(times):
    """A recording with frames at some times, in which nothing moves."""
    recorder = epibar.recording.new_recorder(8, 8, 10, 0, 1)
    for time in times:
        recorder.push(np.zeros((8, 8), np.uint8), time)
    return epibar.Recording(recorder.finish())


@pytest.fixture(scope="module")
def clocked():
    """Makes a calibration with a given clock."""
    refused = epibar.calibrate(seen_at([0.0, 0.1]), seen_at([0.0, 0.1]))
    return lambda offset, per_frame: replace(refused, time_offset=offset, timing=Timing(per_frame))


def test_frames_of_different_rates_meet_by_time(clocked):
    slow, fast = seen_at(np.arange(10) / 10), seen_at(np.arange(30) / 30)
    assert common_frames(slow, fast, clocked(0.0, 3.0)).tolist() == [[i, 3 * i] for i in range(10)]
    assert common_frames(slow, fast, clocked(3.0, 3.0)).tolist() == [[i, 3 * i + 3] for i in range(9)]
    # The last frame of B counts until half a frame later, by the compiled module too.
    thirds = [*([3 * i, i] for i in range(10)), [28, 9]]
    assert common_frames(fast, slow, clocked(0.0, 1 / 3)).tolist() == thirds


def test_frames_that_are_missing_have_no_partner(clocked):
    slow, gap = seen_at(np.arange(10) / 10), seen_at(np.delete(np.arange(10) / 10, [4, 5]))
    kept = [*([i, i] for i in range(4)), *([i, i - 2] for i in range(6, 10))]
    assert common_frames(slow, gap, clocked(0.0, 1.0)).tolist() == kept
    assert common_frames(gap, slow, clocked(0.0, 1.0)).tolist() == [[j, i] for i, j in kept]
    assert np.isnan(positions_in_b(slow, gap, clocked(0.0, 1.0))[4:6]).all()


@pytest.mark.parametrize("fps_b", [25.0, 30.0])
@pytest.mark.parametrize("ppm", [0.0, 1000.0, -1000.0])
def test_frames_of_clocks_that_drift(clocked, fps_b, ppm):
    """Both film the same 80 seconds; B's clock gains or loses 80 ms, 2 frames, over them."""
    rate = 1 + 1e-6 * ppm
    a, b = seen_at(np.arange(2000) / 25.0), seen_at(np.arange(int(80 * fps_b)) / fps_b)
    offset = -12.25
    common = common_frames(a, b, clocked(offset, rate * fps_b / 25.0))
    by_b = common[:, 0] / 25.0 * rate + offset / fps_b
    assert np.abs(by_b - common[:, 1] / fps_b).max() <= 0.5 / fps_b + 1e-9
    assert len(common) >= 2000 - 12.25 * 25.0 / fps_b - 3


def test_times_in_whole_milliseconds_do_not_move_the_interval():
    assert frame_interval(seen_at(np.round(np.arange(900) / 30.0, 3))) == pytest.approx(1 / 30, abs=1e-6)
    assert frame_interval(seen_at(np.delete(np.arange(90) / 30.0, [4, 5, 60]))) == pytest.approx(1 / 30)
    assert frame_interval(seen_at([0.0])) == 1.0


# --- maps of the expected error ---


def cell_of(points, size, shape):
    """Row and column of the cell of each point."""
    x = np.clip(((points[:, 0] + 0.5) / size[0] * shape[1]).astype(int), 0, shape[1] - 1)
    y = np.clip(((points[:, 1] + 0.5) / size[1] * shape[0]).astype(int), 0, shape[0] - 1)
    return y, x


def test_error_maps_agree_with_the_number(scene, cal):
    points = scene.volume_correspondences(0, 1)
    over_volume = []
    for camera, error_map in enumerate(cal.error_maps):
        assert error_map.shape == (24, 32)
        known = error_map[np.isfinite(error_map)]
        assert len(known)
        assert (known > 0).all()
        over_volume.append(error_map[cell_of(points[camera], scene.cameras[camera].size, error_map.shape)])
    mean = np.nanmean(over_volume)
    assert 0.5 * cal.expected_error < mean < 2.0 * cal.expected_error
    # F is known better where things moved than in the worst corner.
    assert np.nanmax(cal.error_maps[0]) > np.nanmedian(over_volume[0])


def test_error_maps_are_nan_where_the_other_camera_sees_nothing(scene, cal):
    width, height = scene.cameras[1].size
    rows, columns = np.mgrid[:24, :32]
    x = (columns + 0.5) * scene.cameras[0].size[0] / 32 - 0.5
    y = (rows + 0.5) * scene.cameras[0].size[1] / 24 - 0.5
    lines = np.stack([x, y, np.ones_like(x)], axis=-1) @ cal.F.T
    corners = np.array([[0, 0, 1], [width - 1, 0, 1], [0, height - 1, 1], [width - 1, height - 1, 1]])
    sides = lines @ corners.T
    missed = (sides > 0).all(axis=-1) | (sides < 0).all(axis=-1)
    assert (np.isnan(cal.error_maps[0]) == missed).all()


def test_a_pair_without_an_answer_has_no_maps():
    still = epibar.Recording.from_masks(np.zeros((40, 48, 64), bool), lines=50)
    assert epibar.calibrate(still, still).error_maps is None


def recorded(masks, frames):
    """Record some frames at the moments at which they were filmed."""
    recorder = new_recorder(masks.shape[2], masks.shape[1], 200, 0, 1)
    for frame in frames:
        recorder.push(np.ascontiguousarray(masks[frame]), frame / FPS)
    return epibar.Recording(recorder.finish(), name=f"{len(frames)} frames")


def test_points_have_the_frame_of_b_that_was_seen_with_them_where_frames_were_dropped(tmp_path):
    """Ten frames of B are missing, so that its index is ten less from there on."""
    rng = np.random.default_rng(3)
    masks = np.zeros((120, 48, 64), np.uint8)
    for frame, (x, y) in enumerate(rng.integers(4, 40, (120, 2))):
        masks[frame, y : y + 6, x : x + 9] = True
    a, b = (recorded(masks, frames) for frames in (range(120), (*range(30), *range(40, 120))))
    found = epibar.calibrate(a, b, seed=0)
    frames = np.array([10, 35, 80])
    clock = found.time_offset, found.timing.frames_per_frame
    np.testing.assert_array_equal(frames_of_b(a, b, *clock, frames), [10, 35, 70])
    points = epibar.FrontierPoints(frames, np.ones((3, 2)), np.ones((3, 2)), np.zeros(3))
    known = replace(found, frontier_points=points)
    pair = Run.of([a, b], {(0, 1): known}).pairs[0]
    np.testing.assert_array_equal(pair.frames_b, [10, 35, 70])
    # And of a run of the command line, by the recordings that it keeps.
    (tmp_path / "recordings").mkdir()
    for recording in (a, b):
        recording.save(tmp_path / "recordings" / f"{recording.name}.npz")
    keys = ("accepted", "kind", "reason", "F", "time_offset", "expected_error")
    entry = {"a": a.name, "b": b.name, "frontier_points": "f.csv", **{k: getattr(known, k) for k in keys}}
    write_frontier_points(tmp_path / "f.csv", points)
    cameras = [camera_entry(one.name, f"{one.name}.mp4", k, one) for k, one in enumerate((a, b))]
    result = {"format": 1, "intrinsics": None, "cameras": cameras, "pairs": [entry], "errors": []}
    write_json(tmp_path / "calibration.json", result)
    np.testing.assert_array_equal(Run.load(tmp_path).pairs[0].frames_b, [10, 35, 70])
    (tmp_path / "recordings" / f"{b.name}.npz").unlink()
    np.testing.assert_array_equal(Run.load(tmp_path).pairs[0].frames_b, [10, 35, 80])
