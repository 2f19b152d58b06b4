"""What coverage-guided fuzzing of the readers runs, and ``test_fuzz_corpus.py`` replays.

One function for each kind of file takes any bytes, reads them as such a file, uses what was read, and returns
whether it was one. Whatever is raised but an EpibarError is a failure, and so is a file that does not come
back as it was. ``fuzz_readers.py`` gives the functions to a fuzzer.
"""

import io
import os
import tempfile
import zipfile
from pathlib import Path

import numpy as np

import epibar
from epibar import Calibration, EpibarError, Network, Recording
from epibar.files.checks import OPTIONAL, RECORDING
from epibar.files.frontier_csv import read_frontier_points
from epibar.lens.cameras_toml import load_cameras, write_cameras
from epibar.network.tracks_csv import load_tracks
from epibar.outcome import Run
from epibar.sources.mask_array_file import MaskArrayFile

CALIBRATION = [
    "epibar_calibration",
    "header",
    "F",
    "floor",
    "candidates.lines_a",
    "candidates.lines_b",
    "candidates.correlation",
    "candidates.inliers",
    "frontier_points.frame",
    "frontier_points.a",
    "frontier_points.b",
    "frontier_points.residual",
    "shift_curve.0",
    "shift_curve.1",
    "error_maps.0",
    "error_maps.1",
    "else",
]
FRAMES_AT_MOST = 50
"""Of masks: a stranger may have many, each of which costs its time."""

_in_memory = "/dev/shm" if os.path.isdir("/dev/shm") else None
_folder = tempfile.TemporaryDirectory(prefix="epibar-fuzzed-", dir=_in_memory)


def _file(name, data):
    path = Path(_folder.name) / name
    path.write_bytes(data)
    return path


def _read(reader, path):
    try:
        return reader(path)
    except EpibarError as error:
        told = str(error)
    assert 0 < len(told) < 20_000
    return None


def _archive(name, data, names):
    """Write an archive of a list of arrays, as check sums stop nearly every change of the archive.

    The list: the number of a name, two bytes of length, and so many bytes of a ``.npy`` file.
    """
    found = {}
    while len(data) > 2:
        length = int.from_bytes(data[1:3], "little")
        found[names[data[0] % len(names)]] = data[3 : 3 + length]
        data = data[3 + length :]
    path = Path(_folder.name) / name
    with zipfile.ZipFile(path, "w") as archive:
        for entry, content in found.items():
            if entry == "header" and not content.startswith(b"\x93NUMPY"):
                content = _npy(np.array(content.decode(errors="replace").replace("\x00", "")))
            archive.writestr(entry + ".npy", content)
    return path


def _npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def listed(arrays, names):
    """Return the list that :func:`_archive` takes."""
    rows = []
    for name, array in arrays.items():
        content = str(array).encode() if name == "header" else _npy(array)
        rows.append(bytes([names.index(name)]) + len(content).to_bytes(2, "little") + content)
    return b"".join(rows)


def _same(found, again):
    assert found.keys() == again.keys()
    for name, value in found.items():
        np.testing.assert_array_equal(value, again[name])


def _use_recording(recording):
    if recording is None:
        return False
    assert str(epibar.inspect(recording))
    assert repr(recording)
    recording.hulls(recording.frames - 1)
    path = Path(_folder.name) / "again.npz"
    recording.save(path)
    _same(recording.to_arrays(), Recording.load(path).to_arrays())
    return True


def _use_calibration(calibration):
    if calibration is None:
        return False
    assert repr(calibration)
    path = Path(_folder.name) / "again.npz"
    calibration.save(path)
    assert Calibration.load(path).reason == calibration.reason
    return True


def archive(data):
    """Any bytes as an archive."""
    path = _file("any.npz", data)
    as_recording = _use_recording(_read(Recording.load, path))
    return _use_calibration(_read(Calibration.load, path)) or as_recording


def recording(data):
    """A list of a recording's arrays."""
    return _use_recording(_read(Recording.load, _archive("recording.npz", data, [*RECORDING, "else"])))


def calibration(data):
    """A list of a calibration's arrays; its header may be plain text."""
    return _use_calibration(_read(Calibration.load, _archive("calibration.npz", data, CALIBRATION)))


def masks(data):
    """Masks as an ``.npy`` file, or with a first byte above 127 as one in an archive."""
    if data[:1] > b"\x7f":
        path = Path(_folder.name) / "masks.npz"
        with zipfile.ZipFile(path, "w") as entries:
            entries.writestr("masks.npy", data[1:])
    else:
        path = _file("masks.npy", data[1:])
    found = _read(MaskArrayFile, path)
    if found is not None:
        frames, height, width = found.shape
        assert min(found.shape) > 0
        for index, mask in enumerate(_checked(found)):
            assert mask.shape == (height, width)
            assert index < frames
            if index == FRAMES_AT_MOST:
                break
        if height * width < 10_000 and frames < FRAMES_AT_MOST:
            _use_recording(_read(lambda path: epibar.record(path, masks=True, lines=5), path))
    return found is not None


def _checked(frames):
    try:
        yield from frames
    except EpibarError:
        return


def network(data):
    """A ``network.json``."""
    found = _read(Network.load, _file("network.json", data))
    if found is None:
        return False
    assert repr(found)
    for camera in found.cameras.values():
        assert not camera.accepted or np.isfinite(camera.matrix).all()
    for keep in (False, True):
        _read(lambda _, keep=keep: found.scaled(person_height=1.7, keep=keep), None)
    for kind in ("anipose", "opencv", "npz"):
        _read(lambda path, kind=kind: found.export(path, kind), Path(_folder.name) / "exported")
    path = Path(_folder.name) / "again.json"
    found.save(path)
    first = path.read_bytes()
    Network.load(path).save(path)
    assert path.read_bytes() == first
    return True


def run(data):
    """A ``calibration.json``."""
    found = _read(Run.load, _file("calibration.json", data))
    if found is not None:
        for pair in found.pairs:
            assert pair.F is None or np.isfinite(pair.F).all()
        for write in (epibar.export.write_csv, epibar.export.write_npz, epibar.export.write_opencv):
            _read(lambda path, write=write: write(found, path), Path(_folder.name) / "exported")
    return found is not None


def cameras(data):
    """A ``cameras.toml``."""
    found = _read(load_cameras, _file("cameras.toml", data))
    if found is not None:
        again = Path(_folder.name) / "again.toml"
        write_cameras(again, found)
        names = [camera.name for camera in load_cameras(again)]
        assert names == [camera.name for camera in found]
    return found is not None


def tracks(data):
    """A ``tracks.csv``."""
    found = _read(load_tracks, _file("tracks.csv", data))
    if found is not None:
        again = Path(_folder.name) / "again.csv"
        found.save(again)
        assert len(load_tracks(again).time) == len(found.time)
    return found is not None


def points(data):
    """A table of frontier points."""
    found = _read(read_frontier_points, _file("cam1_cam2_frontier.csv", data))
    if found is not None:
        assert found.frame.shape == found.residual.shape
    return found is not None


ALL = (archive, recording, calibration, masks, network, run, cameras, tracks, points)

assert set(RECORDING) >= OPTIONAL
