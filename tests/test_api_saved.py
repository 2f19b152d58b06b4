"""Recordings saved and loaded: what comes back, what was visible, and what is damaged."""

import pickle
import zipfile

import cv2
import numpy as np
import pytest
from pair_input import block, calibrated, recorded

import epibar
from epibar.foreground.options import ForegroundOptions


@pytest.fixture
def recordings():
    return recorded()


@pytest.fixture
def calibration():
    return calibrated()


def test_save_and_load_is_the_identity(recordings, tmp_path):
    recording = recordings[0]
    recording.warnings.append("the light switched at frame 3")
    recording.matrix = np.diag([400.0, 410.0, 1.0])
    recording.save(tmp_path / "cam1.npz")
    loaded = epibar.Recording.load(tmp_path / "cam1.npz")
    recording.matrix, recording.warnings = None, []
    assert loaded.name == "cam1"
    assert loaded.warnings == ["the light switched at frame 3"]
    assert (loaded.matrix == np.diag([400.0, 410.0, 1.0])).all()
    before, after = recording._core.to_arrays(), loaded._core.to_arrays()
    assert before.keys() == after.keys()
    for key, value in before.items():
        assert value.dtype == after[key].dtype
        assert value.tobytes() == after[key].tobytes(), key
    assert [path.name for path in tmp_path.iterdir()] == ["cam1.npz"]


@pytest.fixture
def walk_in_noise(tmp_path):
    """Video of a bright square that crosses a noisy wall of 160x120 pixels."""
    rng = np.random.default_rng(0)
    path = tmp_path / "wall.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 25.0, (160, 120))
    assert writer.isOpened()
    for index in range(70):
        frame = rng.integers(80, 90, (120, 160, 3)).astype(np.uint8)
        frame[40:80, 2 * index : 2 * index + 20] = 220
        writer.write(frame)
    writer.release()
    return path


@pytest.mark.parametrize("given", ["ignore", "foreground"])
def test_an_ignored_half_is_not_visible_and_stays_so(walk_in_noise, tmp_path, given):
    ignore = np.zeros((120, 160), np.uint8)
    ignore[:, 80:] = 255
    options = {"ignore": ignore} if given == "ignore" else {"foreground": ForegroundOptions(ignore=ignore)}
    recording = epibar.record(walk_in_noise, lines=50, **options)
    # Two columns beside what is ignored are its edge.
    expected = np.zeros((120, 160), np.uint8)
    expected[:, :78] = 1
    assert np.array_equal(recording.visible, expected)
    assert recording.heat[:, 79].any()
    assert not recording.heat[:, 80:].any()

    recording.save(tmp_path / "wall.npz")
    loaded = epibar.Recording.load(tmp_path / "wall.npz")
    for copy in (loaded, pickle.loads(pickle.dumps(recording))):
        assert copy.visible.dtype == np.uint8
        assert np.array_equal(copy.visible, expected)
    # Cut at the ignored half are the silhouettes that reach it, and no others away from the image's border.
    arrays = loaded.to_arrays()
    starts, points = arrays["core_hull_start"], arrays["core_hull_points"]
    cut = [not (p[:, 0].min() > 0 and p[:, 0].max() < 78) for p in np.split(points, starts[1:-1])]
    assert 0 < sum(cut) < len(cut)
    assert arrays["core_hull_border"].tolist() == cut


def test_without_an_ignore_mask_all_is_visible(walk_in_noise, recordings, tmp_path):
    assert epibar.record(walk_in_noise, lines=50).visible is None
    assert epibar.record(walk_in_noise, lines=50, ignore=np.zeros((120, 160), bool)).visible is None
    assert "core_visible" not in recordings[0].to_arrays()  # a file as older versions wrote it
    recordings[0].save(tmp_path / "all.npz")
    assert epibar.Recording.load(tmp_path / "all.npz").visible is None


@pytest.mark.parametrize("shape", [(160, 120), (120, 159), (19200,)])
def test_a_visible_area_of_another_size_is_refused(shape):
    with pytest.raises(epibar.EpibarError, match=r"visible (is|has)"):
        epibar.recording.new_recorder(160, 120, 50, 0, 1, np.zeros(shape, np.uint8))


@pytest.mark.parametrize("shape", [(120, 159), (19200,)])
def test_a_stored_visible_area_of_another_size_is_refused(recordings, tmp_path, shape):
    path = tmp_path / "cam1.npz"
    recordings[0].save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays["core_visible"] = np.zeros(shape, np.uint8)
    np.savez(path, **arrays)
    with pytest.raises(epibar.EpibarError, match=r"cam1\.npz: .*visible"):
        epibar.Recording.load(path)


def test_loaded_recordings_calibrate_to_the_same_bits(recordings, calibration, tmp_path):
    loaded = []
    for index, recording in enumerate(recordings):
        recording.save(tmp_path / f"{index}.npz")
        loaded.append(epibar.Recording.load(tmp_path / f"{index}.npz"))
    assert epibar.calibrate(*loaded).F.tobytes() == calibration.F.tobytes()


def test_a_damaged_file_is_an_error_that_names_it(recordings, tmp_path):
    path = tmp_path / "cam1.npz"
    recordings[0].save(path)
    data = path.read_bytes()
    rng = np.random.default_rng(0)
    broken = [b"", b"PK", data[: len(data) // 2], data[:-40], b"not a zip at all" * 10]
    for position in rng.integers(0, len(data), 30):
        broken.append(data[:position] + bytes([data[position] ^ 0x5A]) + data[position + 1 :])
    refused = 0
    for case in broken:
        path.write_bytes(case)
        try:
            epibar.Recording.load(path)  # a flipped bit in a zip header may be harmless
        except epibar.EpibarError as error:
            refused += "cam1.npz" in str(error)
    assert refused >= len(broken) // 2


@pytest.mark.parametrize("change", ["missing", "shape", "dtype", "values", "format", "pickle"])
def test_a_file_that_contradicts_itself_is_refused(recordings, tmp_path, change):
    path = tmp_path / "cam1.npz"
    recordings[0].save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    key = next(name for name in arrays if name.startswith("core_") and arrays[name].ndim == 2)
    if change == "missing":
        del arrays[key]
    elif change == "shape":
        arrays[key] = arrays[key][:-1]
    elif change == "dtype":
        arrays[key] = arrays[key].astype(np.complex128)
    elif change == "values":
        arrays["core_segments"] = np.full_like(arrays["core_segments"], np.nan)
    elif change == "format":
        arrays["epibar_recording"] = np.int64(99)
    elif change == "pickle":
        arrays[key] = np.array([[{"a": 1}]], dtype=object)
    np.savez(path, **arrays)
    with pytest.raises(epibar.EpibarError, match=r"cam1\.npz"):
        epibar.Recording.load(path)


def test_masks_are_not_taken_for_a_recording(tmp_path):
    np.savez(tmp_path / "masks.npz", masks=block())
    with pytest.raises(epibar.EpibarError, match="masks"):
        epibar.Recording.load(tmp_path / "masks.npz")
    with zipfile.ZipFile(tmp_path / "other.npz", "w") as archive:
        archive.writestr("a.txt", "text")
    with pytest.raises(epibar.EpibarError, match=r"other\.npz"):
        epibar.Recording.load(tmp_path / "other.npz")


def test_an_unwritable_place_is_an_error(recordings, tmp_path):
    with pytest.raises(epibar.EpibarError, match="nowhere"):
        recordings[0].save(tmp_path / "nowhere" / "cam1.npz")
