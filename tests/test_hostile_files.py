"""Files from a stranger: one clear error before they cost anything, and nothing outside of their folder."""

import io
import json
import os
import shutil
import zipfile

import numpy as np
import pytest
from jobs_input import FAST, write_masks

import epibar
from epibar import Calibration, EpibarError, Network, Recording
from epibar.cli import main
from epibar.files.archive import read_archive, room, write_archive
from epibar.lens.cameras_toml import load_cameras
from epibar.network import WalkerTracks
from epibar.network.tracks_csv import load_tracks
from epibar.outcome import Run
from epibar.sources.mask_array_file import MaskArrayFile


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibrated")
    epibar.calibrate_all(write_masks(folder)[:2], folder / "out", **FAST)
    return folder / "out"


@pytest.fixture
def recording(calibrated):
    return dict(np.load(calibrated / "recordings" / "cam1.npz"))


def entries(path, members, compression=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path


def array(data):
    stream = io.BytesIO()
    np.save(stream, data)
    return stream.getvalue()


def header(text, data=b""):
    body = text.encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + len(body).to_bytes(2, "little") + body + data


@pytest.mark.parametrize("load", [Recording.load, Calibration.load])
def test_an_archive_that_expands_beyond_all_measure(load, tmp_path):
    """A file of 292 kB that expands to 300 MB."""
    mark = array(np.array(1))
    bomb = entries(tmp_path / "bomb.npz", {"epibar_recording.npy": mark, "x.npy": bytes(300_000_000)})
    assert bomb.stat().st_size < 300_000
    with pytest.raises(EpibarError, match="say they expand to 300,000,"):
        load(bomb)


def test_what_an_entry_says_of_its_size_is_all_that_is_read(tmp_path):
    path = entries(tmp_path / "lies.npz", {"x.npy": bytes(50_000_000)})
    data = path.read_bytes()
    # The size in the list of entries, which comes last.
    at = data.rindex((50_000_000).to_bytes(4, "little"))
    path.write_bytes(data[:at] + (100).to_bytes(4, "little") + data[at + 4 :])
    with pytest.raises(EpibarError, match="damaged"):
        read_archive(path, "an archive")


@pytest.mark.parametrize(
    "text",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }",
        "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
        "{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': " + "(" * 5000,
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1e3,), }",
        "__import__('os').system('true')",
    ],
)
def test_an_array_that_says_what_it_is_not(text, tmp_path):
    path = entries(tmp_path / "a.npz", {"x.npy": header(text, bytes(8))})
    with pytest.raises(EpibarError, match="damaged"):
        read_archive(path, "an archive")


def test_other_compressions_two_of_a_name_and_too_many(tmp_path):
    good = {"x.npy": array(np.arange(3))}
    with pytest.raises(EpibarError, match="never uses"):
        read_archive(entries(tmp_path / "a.npz", good, zipfile.ZIP_LZMA), "an archive")
    with pytest.raises(EpibarError, match="10001 arrays"):
        read_archive(entries(tmp_path / "b.npz", {f"{i}.npy": b"" for i in range(10_001)}), "an archive")
    with zipfile.ZipFile(tmp_path / "c.npz", "w") as archive:
        archive.writestr("x.npy", good["x.npy"])
        with pytest.warns(UserWarning, match="Duplicate"):
            archive.writestr("x.npy", good["x.npy"])
    with pytest.raises(EpibarError, match="2 arrays, of 1 names"):
        read_archive(tmp_path / "c.npz", "an archive")


def test_what_is_written_can_be_read_however_little_it_says(tmp_path):
    F = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    arrays = {"x": np.zeros(10_000_000), "F": F, "t": np.array("")}
    write_archive(tmp_path / "zeros.npz", arrays)
    found = read_archive(tmp_path / "zeros.npz", "an archive")
    assert room(100_000) < arrays["x"].nbytes
    assert all(np.array_equal(found[name], value) for name, value in arrays.items())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("core_times", np.zeros((2, 3))),
        ("core_times", np.zeros(7)),
        ("core_heat", np.zeros((7, 10), np.uint32)),
        ("core_heat", np.zeros((1, 20_000), np.uint32)),
        ("core_barcodes", np.zeros((2, 2), np.uint64)),
        ("core_seed", np.zeros(1)),
        ("core_size", np.array([2**40, 5], np.uint64)),
        ("core_hull_points", np.zeros((3, 3), np.uint16)),
        ("name", np.array(["a", "b"])),
        ("name", np.array(3)),
        ("warnings", np.array("text")),
        ("matrix", np.full((3, 3), np.nan)),
        ("matrix", np.zeros((3, 3))),
        ("first_frame", np.array(-1)),
        ("first_frame", np.array(0.5)),
        ("health_values", np.array([np.nan] * 20)),
        ("epibar_recording", np.array("one")),
        ("epibar_recording", np.array([1, 1])),
        ("epibar_recording", np.array(True)),
    ],
)
def test_a_recording_whose_arrays_do_not_fit(name, value, recording, tmp_path):
    np.savez(tmp_path / "odd.npz", **{**recording, name: value})
    with pytest.raises(EpibarError, match=r"odd\.npz"):
        Recording.load(tmp_path / "odd.npz")


def test_numbers_of_the_health_that_cannot_be(recording, tmp_path):
    for names, values in [(["frames", "moves"], [0.0, 1.0]), (["moves"], [3.0]), (["shaken"], [1e308])]:
        np.savez(tmp_path / "odd.npz", **{**recording, "health_names": names, "health_values": values})
        assert "not known" in str(epibar.inspect(Recording.load(tmp_path / "odd.npz")))
    np.savez(tmp_path / "odd.npz", **{**recording, "health_names": ["frames"], "health_values": [np.inf]})
    with pytest.raises(EpibarError, match="frames of the camera's health is inf"):
        Recording.load(tmp_path / "odd.npz")


@pytest.mark.parametrize(("version", "words"), [(2, "a newer epibar wrote it; update"), (0, "no version")])
def test_older_and_newer_formats_are_told_apart(version, words, calibrated, recording, tmp_path):
    np.savez(tmp_path / "r.npz", **{**recording, "epibar_recording": version})
    pair = dict(np.load(calibrated / "pairs" / "cam1_cam2.npz"))
    np.savez(tmp_path / "c.npz", **{**pair, "epibar_calibration": version})
    result = json.loads((calibrated / "calibration.json").read_text())
    (tmp_path / "calibration.json").write_text(json.dumps({**result, "format": version}))
    for kind, name in ((Recording, "r.npz"), (Calibration, "c.npz"), (Run, "calibration.json")):
        with pytest.raises(EpibarError, match=words):
            kind.load(tmp_path / name)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda h: h.update(accepted="yes"), "accepted is not"),
        (lambda h: h.update(reason=None), "reason is not"),
        (lambda h: h.update(candidates=5), "candidates has no place"),
        (lambda h: h.update({"shift_curve.7": [1]}), "has no place"),
        (lambda h: h.update(rivals=[{"F": 1}]), "rivals is not"),
        (lambda h: h.update(expected_error=float("nan")), "expected_error is not"),
        (lambda h: h.update({"timing.frames_per_frame": 0}), "frames_per_frame is not"),
        (lambda h: h.update({"candidates.lines_a": []}), "of its own"),
        (lambda h: h.update(counts=[1]), "counts is not"),
    ],
)
def test_a_calibration_whose_header_holds_other_things(change, words, calibrated, tmp_path):
    arrays = dict(np.load(calibrated / "pairs" / "cam1_cam2.npz"))
    told = json.loads(str(arrays["header"]))
    change(told)
    np.savez(tmp_path / "odd.npz", **{**arrays, "header": json.dumps(told)})
    with pytest.raises(EpibarError, match=words):
        Calibration.load(tmp_path / "odd.npz")
    np.savez(tmp_path / "odd.npz", **{**arrays, "header": "[" * 100_000})
    with pytest.raises(EpibarError, match=r"odd\.npz: damaged"):
        Calibration.load(tmp_path / "odd.npz")


def put(*path_and_value):
    *path, last, value = path_and_value

    def change(result):
        for key in path:
            result = result[key]
        result[last] = value

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put("pairs", 0, "timing", None), r"pairs\[0\]\.timing is None, expected a table"),
        (put("pairs", 0, "timing", {"frames_per_frame": 0}), "above 0"),
        (put("pairs", 0, "timing", {"frames_per_frame": 10**400}), "finite"),
        (put("pairs", 0, "F", [[1, 2], [3]]), "3 x 3"),
        (put("pairs", 0, "F", [[True] * 3] * 3), "3 x 3"),
        (put("pairs", 0, "accepted", 1), "true or false"),
        (put("pairs", 0, "time_offset", "0"), "finite number"),
        (put("pairs", 0, "reason", {}), "a text"),
        (put("pairs", 0, None), r"pairs\[0\] is no table"),
        (put("pairs", 0, "a", "cam9"), "no such camera"),
        (put("pairs", 0, "a", "cam2"), "is no pair"),
        (put("cameras", 0, "width", 2.5), "a whole number from 2"),
        (put("cameras", 0, "width", 10**9), "a whole number from 2"),
        (put("cameras", 0, "matrix", [[0] * 3] * 3), r"expected \[\[fx"),
        (put("cameras", 0, "name", "cam2"), "one name"),
        (put("cameras", {}), "cameras is no list"),
        (put("intrinsics", 5), "intrinsics is no path"),
        (put("pairs", 0, "frontier_points", "../../etc/passwd"), "in the same folder"),
        (put("pairs", 0, "frontier_points", "/etc/passwd"), "in the same folder"),
        (put("pairs", 0, "frontier_points", "C:secret"), "in the same folder"),
        (put("pairs", 0, "frontier_points", "out.csv"), "leads out of"),
        (put("pairs", 0, "frontier_points", 3), "in the same folder"),
    ],
)
def test_a_calibration_json_of_a_stranger(change, words, calibrated, tmp_path, capsys):
    folder = shutil.copytree(calibrated, tmp_path / "run")
    (tmp_path / "outside.csv").write_text("frame_a,x_a,y_a,x_b,y_b,residual\n")
    (folder / "out.csv").symlink_to(tmp_path / "outside.csv")
    result = json.loads((folder / "calibration.json").read_text())
    change(result)
    (folder / "calibration.json").write_text(json.dumps(result))
    with pytest.raises(EpibarError, match=words):
        Run.load(folder)
    assert main(["export", str(folder), "--format", "csv", "--all", "-o", str(tmp_path / "x.csv")]) == 2
    assert "epibar: error:" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"pairs": NaN}', "nul", "\xff", '{"a": ' + "1" * 5000 + "}"]
)
def test_what_is_no_json(text, tmp_path):
    for name, load in (("calibration.json", Run.load), ("network.json", Network.load)):
        (tmp_path / name).write_bytes(text.encode("latin-1"))
        with pytest.raises(EpibarError, match=rf"{name}: not JSON"):
            load(tmp_path / name)


def test_json_that_is_too_large(tmp_path):
    """A sparse file: it says that it is large, and nothing is read of it."""
    for name, load in (("calibration.json", Run.load), ("network.json", Network.load)):
        with open(tmp_path / name, "wb") as stream:
            stream.truncate(1 << 30)
        with pytest.raises(EpibarError, match=r"1,073,741,824 bytes"):
            load(tmp_path / name)


@pytest.mark.parametrize(
    "row", ["0.5,1,1,1,1,1", "-1,1,1,1,1,1", "1e300,1,1,1,1,1", "1,nan,1,1,1,1", "1,1", "1" + 11 * ",1", "="]
)
def test_frontier_points_of_a_stranger(row, calibrated, tmp_path):
    folder = shutil.copytree(calibrated, tmp_path / "run")
    path = folder / "cam1_cam2_frontier.csv"
    path.write_text(path.read_text().splitlines()[0] + "\n" + row + "\n")
    with pytest.raises(EpibarError, match=r"frontier\.csv: the frontier points cannot be read"):
        Run.load(folder)


@pytest.mark.skipif(os.name == "nt", reason="needs pipes with a name")
def test_a_pipe_is_not_waited_for(calibrated, tmp_path):
    os.mkfifo(tmp_path / "calibration.json")
    with pytest.raises(EpibarError, match="not a file"):
        Run.load(tmp_path)
    with pytest.raises(EpibarError, match="not a file"):
        Network.load(tmp_path / "calibration.json")
    with pytest.raises(EpibarError, match="not a file"):
        load_cameras(tmp_path / "calibration.json")
    with pytest.raises(EpibarError, match="not a file"):
        load_tracks(tmp_path / "calibration.json")
    os.mkfifo(tmp_path / "cam1.npz")
    with pytest.raises(EpibarError, match="not a file"):
        Recording.load(tmp_path / "cam1.npz")
    assert main(["inspect", str(tmp_path / "cam1.npz"), "--quiet"]) == 2


def test_masks_that_are_taken_for_a_recording(tmp_path):
    """However well they were compressed."""
    np.savez_compressed(tmp_path / "cam1.npz", masks=np.zeros((400, 480, 640), bool))
    with pytest.raises(EpibarError, match="holds masks: give --masks"):
        Recording.load(tmp_path / "cam1.npz")


@pytest.mark.skipif(os.name == "nt", reason="needs links")
def test_links_that_go_round_in_a_circle(tmp_path, capsys):
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    for words in (
        ["calibrate", str(loop), str(tmp_path / "b.mp4"), "--out", str(tmp_path / "out")],
        ["calibrate", str(tmp_path / "a.mp4"), str(tmp_path / "b.mp4"), "--out", str(loop)],
        ["record", str(loop), "--out", str(tmp_path / "a.npz")],
    ):
        assert main(words) == 2
        assert "Traceback" not in capsys.readouterr().err


def test_one_long_cell_of_a_table_of_tracks_costs_itself(tmp_path):
    """As texts of one length these rows would be 20 GB."""
    names = ("hall", "door")
    ones, yes = np.ones((20_000, 3)), np.ones((20_000, 2), bool)
    tracks = WalkerTracks(names, "metre", ones[:, 0], np.zeros(20_000, np.int64), ones, ones, yes, ones[:, 0])
    tracks.save(tmp_path / "tracks.csv")
    assert load_tracks(tmp_path / "tracks.csv").cameras.all()
    text = (tmp_path / "tracks.csv").read_text().rstrip()
    (tmp_path / "tracks.csv").write_text(text[:-1] + "1" * 130_000 + "\n")
    with pytest.raises(EpibarError, match="neither 0 nor 1"):
        load_tracks(tmp_path / "tracks.csv")


@pytest.mark.parametrize("shape", [(1, 100_000, 2), (1, 2, 2**40), (1, 2**31, 2**31), (5, -2, 3), (-1, 2, 2)])
def test_masks_that_say_they_are_large(shape, tmp_path):
    text = f"{{'descr': '|b1', 'fortran_order': False, 'shape': {shape}, }}"
    entries(tmp_path / "masks.npz", {"masks.npy": header(text, bytes(100))})
    (tmp_path / "masks.npy").write_bytes(header(text, bytes(100)))
    for name in ("masks.npz", "masks.npy"):
        with pytest.raises(EpibarError, match=name):
            epibar.record(tmp_path / name, masks=True, lines=10)


def test_masks_that_are_compressed_otherwise(tmp_path):
    """A kilobyte holds gigabytes of frames."""
    masks = {"masks.npy": array(np.zeros((1000, 64, 64), bool))}
    path = entries(tmp_path / "masks.npz", masks, zipfile.ZIP_BZIP2)
    assert path.stat().st_size < 1000
    with pytest.raises(EpibarError, match="never uses"):
        epibar.record(path, masks=True, lines=10)


def test_a_rate_of_masks_that_expands(tmp_path):
    masks = array(np.zeros((3, 8, 8), bool))
    entries(tmp_path / "masks.npz", {"masks.npy": masks, "fps.npy": array(np.zeros(40_000_000))})
    with pytest.raises(EpibarError, match="320,000,128 bytes"):
        MaskArrayFile(tmp_path / "masks.npz")


@pytest.mark.parametrize(
    "text",
    [
        "[a]\nsize = 1\nmatrix = 2\ndistortions = 3",
        "[a]\nsize = [1e999, 2]\nmatrix = [[1,0,0],[0,1,0],[0,0,1]]\ndistortions = []",
        "[a]\nsize = [9, 9]\nmatrix = [[1" + "0" * 400 + ",0,0],[0,1,0],[0,0,1]]\ndistortions = []",
        "a = " + "[" * 50_000,
        "cameras = 3",
        "[a]\nsize = [9, 9]\nmatrix = [['x']]\ndistortions = [nan]",
        "[a]\nsize = [9, 9]\nmatrix = [[5,0,4],[0,5,4],[0,0,1]]\ndistortions = []\n"
        "rotation = [[1,0,0],[0,1,0],[0,0,-1]]\ntranslation = [0,0,0]",
        "[a]\nsize = [9, 9]\nmatrix = [[5,0,4],[0,5,4],[0,0,1]]\ndistortions = []\n"
        "rotation = [[1,0.5,0],[0,1,0],[0,0,1]]\ntranslation = [0,0,0]",
    ],
)
def test_a_camera_file_of_a_stranger(text, tmp_path):
    (tmp_path / "cameras.toml").write_text(text)
    with pytest.raises(EpibarError, match=r"cameras\.toml"):
        load_cameras(tmp_path / "cameras.toml")
