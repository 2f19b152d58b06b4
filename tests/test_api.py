"""The public names: conventions that a swap or a transposition would break, and clear errors."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from pair_input import LINES, block, calibrated, recorded, walkers

import epibar
from epibar import synthetic


@pytest.fixture
def scene():
    return walkers()


@pytest.fixture
def recordings():
    return recorded()


@pytest.fixture
def calibration():
    return calibrated()


# --- conventions ---


def test_x_is_the_column_and_y_the_row():
    masks = np.zeros((70, 20, 30), bool)
    masks[65, 5, 25] = True  # y = 5, x = 25, in the second word
    bits = epibar.barcodes(masks, [[0, 5, 29, 5], [25, 0, 25, 19], [5, 0, 5, 19], [0, 25, 29, 25]])
    assert bits.dtype == np.uint64
    assert bits.tolist() == [[0, 2], [0, 2], [0, 0], [0, 0]]


def test_match_barcodes_finds_the_same_lines_best_first():
    rng = np.random.default_rng(0)
    bits = rng.integers(0, 2**63, (50, 2), dtype=np.uint64)
    order = rng.permutation(50)
    index_a, index_b, correlation = epibar.match_barcodes(bits, bits[order], frames=128, mutual=1)
    exact = correlation > 0.999
    assert exact.sum() == 50
    assert (order[index_b[exact]] == index_a[exact]).all()
    assert (np.diff(correlation) <= 0).all()


def test_recording_describes_its_masks(scene, recordings):
    masks, recording = scene.masks(1), recordings[1]
    assert recording.size == (masks.shape[2], masks.shape[1])
    assert recording.frames == len(recording.times) == len(masks)
    assert recording.times[1] == pytest.approx(1 / 25)
    assert (recording.heat == masks.sum(axis=0, dtype=np.int64)).all()
    assert (recording.moving_pixels == masks.sum(axis=(1, 2), dtype=np.int64)).all()
    assert len(recording.segments) == LINES
    assert (epibar.barcodes(masks, recording.segments) == recording.barcodes).all()
    ys, xs = np.nonzero(masks[7])
    corners = np.vstack(recording.hulls(7))
    assert np.abs(corners.min(axis=0) - (xs.min(), ys.min())).max() <= 1
    assert np.abs(corners.max(axis=0) - (xs.max(), ys.max())).max() <= 1


def test_frames_of_a_long_recording_stand_in_their_order():
    masks = np.zeros((700, 24, 32), bool)  # two whole blocks of 256 frames and the start of a third
    for frame in [*range(200), *range(640, 700)]:
        masks[frame, 4 + frame // 50 : 12 + frame // 50, frame * 3 % 28 : frame * 3 % 28 + 4] = True
    recording = epibar.Recording.from_masks(masks, fps=25.0, lines=500, seed=0)
    assert (recording.heat == masks.sum(axis=0, dtype=np.int64)).all()
    naive = np.zeros((500, 704), bool)
    for line, segment in enumerate(recording.segments):
        one = np.zeros((24, 32), np.uint8)
        cells = epibar.barcodes(np.eye(24 * 32, dtype=bool).reshape(-1, 24, 32), segment[None])
        one.ravel()[np.unpackbits(cells.view(np.uint8), bitorder="little")[: one.size] > 0] = 1
        naive[line, :700] = (masks & (one > 0)).any(axis=(1, 2))
    assert (np.packbits(naive, axis=1, bitorder="little").view(np.uint64) == recording.barcodes).all()


def test_F_maps_points_of_a_to_lines_of_b(scene, calibration):
    a, b = scene.volume_correspondences(0, 1)
    assert calibration.accepted, calibration.reason
    error = epibar.symmetric_epipolar_distance(calibration.F, a, b).mean()
    assert error < 1.0
    assert epibar.symmetric_epipolar_distance(calibration.F.T, a, b).mean() > 10
    assert np.linalg.norm(calibration.F) == pytest.approx(1)
    assert abs(np.linalg.det(calibration.F)) < 1e-9
    assert calibration.expected_error < 3.0


def test_where_F_is_trusted_it_is_right(scene, calibration):
    everywhere = calibration.trusted(1e6)
    for side, trusted in enumerate(calibration.trusted()):
        assert trusted.shape == everywhere[side].shape == (24, 32)
        assert 0 < trusted.sum() <= everywhere[side].sum()
        assert not trusted[np.isnan(calibration.error_maps[side])].any()
        assert calibration.trusted(0.5)[side].sum() < trusted.sum()
    # Points of A in cells that are trusted, each on its true line in B.
    rows, columns = np.nonzero(calibration.trusted()[0])
    size = scene.cameras[0].size
    points = np.column_stack([(columns + 0.5) * size[0] / 32, (rows + 0.5) * size[1] / 24]) - 0.5
    homogeneous = np.column_stack([points, np.ones(len(points))])
    true, found = (homogeneous @ F.T for F in (scene.fundamental(0, 1), calibration.F))
    true, found = (
        lines[:, :2] / np.linalg.norm(lines[:, :2], axis=1, keepdims=True) for lines in (true, found)
    )
    sines = np.abs(true[:, 0] * found[:, 1] - true[:, 1] * found[:, 0])
    assert np.median(np.rad2deg(np.arcsin(sines))) < 1.0


def test_nothing_is_trusted_of_a_refused_pair(calibration):
    refused = replace(calibration, accepted=False)
    assert not any(region.any() for region in refused.trusted())
    assert not any(region.any() for region in replace(calibration, error_maps=None).trusted())
    with pytest.raises(epibar.EpibarError, match="max_error"):
        calibration.trusted(0)


def test_frontier_points_are_true_correspondences(scene, calibration):
    points = calibration.frontier_points
    true = scene.fundamental(0, 1)
    assert len(points) > 100
    assert points.a.shape == points.b.shape == (len(points), 2)
    assert np.median(epibar.symmetric_epipolar_distance(true, points.a, points.b)) < 1.5
    assert points.frame.max() < scene.frames


def test_candidates_are_unit_lines_with_falling_correlation(calibration):
    candidates = calibration.candidates
    assert len(candidates) == len(candidates.lines_a) == len(candidates.lines_b) == len(candidates.inliers)
    for lines in (candidates.lines_a, candidates.lines_b):
        assert np.hypot(lines[:, 0], lines[:, 1]) == pytest.approx(1)
    assert candidates.inliers.dtype == bool


def test_same_seed_same_result(recordings, calibration):
    again = epibar.calibrate(*recordings)
    assert again.F.tobytes() == calibration.F.tobytes()
    assert again.counts == calibration.counts


def test_a_camera_that_is_moved_while_it_films_is_told(scene, recordings):
    masks = scene.masks(1)
    masks[280:] = np.roll(masks[280:], 15, axis=1)  # tilted
    moved = epibar.Recording.from_masks(masks, lines=LINES, seed=1, name="cam2")
    for pair in ((recordings[0], moved), (moved, recordings[0])):
        cal = epibar.calibrate(*pair)
        assert cal.kind == "knocked", cal.reason
        assert cal.evidence["z"] > 5
        assert "as if a camera had been moved" in cal.reason


def test_swapped_cameras_give_the_transposed_matrix(scene, recordings):
    swapped = epibar.calibrate(recordings[1], recordings[0])
    a, b = scene.volume_correspondences(0, 1)
    assert epibar.symmetric_epipolar_distance(swapped.F, b, a).mean() < 1.0


def test_unrelated_recordings_are_refused(recordings):
    other = synthetic.people(seed=99, cameras=1, walkers=6, frames=400, size=(400, 300))
    cal = epibar.calibrate(recordings[0], epibar.Recording.from_masks(other.masks(0), lines=LINES))
    assert not cal.accepted
    assert cal.reason.endswith(".") or len(cal.reason) > 20


def test_without_motion_there_is_a_reason_and_no_F():
    still = epibar.Recording.from_masks(np.zeros((60, 48, 64), bool), lines=200)
    cal = epibar.calibrate(still, still)
    assert not cal.accepted
    assert cal.F is None
    assert cal.kind
    assert len(cal.reason) > 20


# --- errors ---


@pytest.mark.parametrize(
    ("masks", "words"),
    [
        (np.zeros((4, 8, 8)), "float64"),
        (np.full((4, 8, 8), np.nan), "float64"),
        (np.zeros((4, 8, 8), int), "int64"),
        (np.zeros((8, 8), bool), "shape"),
        (np.zeros((4, 8, 8, 3), np.uint8), "shape"),
        (np.zeros((0, 8, 8), bool), "no frames"),
        (np.zeros((4, 0, 8), bool), "no pixels"),
        ([["text"]], "dtype"),
        (None, "dtype"),
        ([[[1], [1, 2]]], "no array"),
    ],
)
def test_unusable_masks(masks, words):
    with pytest.raises(epibar.EpibarError, match=words):
        epibar.Recording.from_masks(masks)


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"fps": 0}, "fps"),
        ({"fps": np.nan}, "fps"),
        ({"fps": "fast"}, "fps"),
        ({"lines": 0}, "lines"),
        ({"lines": 10.5}, "lines"),
        ({"lines": True}, "lines"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"min_component_area": 0}, "min_component_area"),
        ({"name": None}, "name"),
        ({"name": 7}, "name"),
    ],
)
def test_unusable_options_of_a_recording(options, name):
    with pytest.raises(epibar.EpibarError, match=name):
        epibar.Recording.from_masks(block(), **options)


def test_ready_masks_have_no_use_for_a_foreground_model(tmp_path):
    path = tmp_path / "cam1.npz"
    np.savez_compressed(path, masks=block())
    assert epibar.record(path, lines=100, masks=True, fps=25.0).warnings == []
    for options in ({"background": "empty.mp4"}, {"foreground": "knn"}):
        (told,) = epibar.record(path, lines=100, masks=True, fps=25.0, **options).warnings
        assert "is not used" in told
    for options, name in (({"foreground": "zzz"}, "zzz"), ({"name": 5}, "name")):
        with pytest.raises(epibar.EpibarError, match=name):
            epibar.record(path, lines=100, masks=True, **options)


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"method": "magic"}, "method"),
        ({"method": None}, "method"),
        ({"seed": -1}, "seed"),
        ({"seed": 0.5}, "seed"),
        ({"time_offset": np.nan}, "time_offset"),
        ({"time_offset": np.inf}, "time_offset"),
        ({"time_offset": "soon"}, "time_offset"),
        ({"time_offset": 1e6}, "time_offset"),
        ({"max_expected_error": 0}, "max_expected_error"),
        ({"max_expected_error": np.nan}, "max_expected_error"),
        ({"candidates": -1}, "candidates"),
        ({"draws": 1.5}, "draws"),
    ],
)
def test_unusable_options_of_a_calibration(options, name):
    recording = epibar.Recording.from_masks(block(), lines=100)
    with pytest.raises(epibar.EpibarError, match=name):
        epibar.calibrate(recording, recording, **options)


def test_masks_given_to_calibrate_are_named():
    recording = epibar.Recording.from_masks(block(), lines=100)
    with pytest.raises(epibar.EpibarError, match="rec_b is a ndarray"):
        epibar.calibrate(recording, block())


def test_barcode_arguments():
    with pytest.raises(epibar.EpibarError, match="segments"):
        epibar.barcodes(block(), [[0, 0, 1]])
    with pytest.raises(epibar.EpibarError, match="finite"):
        epibar.barcodes(block(), [[0, 0, 1, np.nan]])
    bits = np.zeros((3, 2), np.uint64)
    with pytest.raises(epibar.EpibarError, match="bits_b"):
        epibar.match_barcodes(bits, bits[:, :1], frames=128)
    with pytest.raises(epibar.EpibarError, match="bits_a"):
        epibar.match_barcodes(bits.astype(float), bits, frames=128)
    with pytest.raises(epibar.EpibarError, match="mutual"):
        epibar.match_barcodes(bits, bits, frames=128, mutual=0)


def test_errors_are_value_errors():
    assert issubclass(epibar.EpibarError, ValueError)


def test_import_is_light():
    code = "import sys, epibar; sys.exit(any(m in sys.modules for m in ('numpy', 'cv2', 'epibar._core')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_public_name_exists():
    for name in epibar.__all__:
        assert getattr(epibar, name) is not None
    with pytest.raises(AttributeError):
        epibar.nonsense  # noqa: B018


@pytest.mark.parametrize("number", [10**400, -(10**400)], ids=["above", "below"])
def test_a_whole_number_that_is_larger_than_any_other(number, tmp_path):
    """Python has no end of them, and what asks whether one is finite raises."""
    masks = np.zeros((5, 8, 8), bool)
    np.save(tmp_path / "masks.npy", masks)
    with pytest.raises(epibar.EpibarError, match="fps"):
        epibar.Recording.from_masks(masks, fps=number)
    with pytest.raises(epibar.EpibarError, match=r"masks\.npy|fps"):
        epibar.record(tmp_path / "masks.npy", masks=True, fps=number)
    recordings = {name: epibar.Recording.from_masks(masks, lines=5) for name in "abc"}
    with pytest.raises(epibar.EpibarError, match="time_offset"):
        epibar.calibrate_network(recordings, time_offset=number)
    with pytest.raises(epibar.EpibarError, match="time_offset"):
        epibar.calibrate_network(recordings, time_offset={"a": 0.0, "b": number, "c": 0.0})


@pytest.mark.parametrize("points", [[["x", "y"]], [[1, 2], [3]], [[10**400, 1]], [[None, {}]], [[1j, 2]]])
def test_points_that_are_no_numbers(points):
    with pytest.raises(epibar.EpibarError, match="points_a"):
        epibar.symmetric_epipolar_distance(np.diag([1.0, 1, 0]), points, [[1, 2]])
