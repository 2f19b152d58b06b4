"""Whatever readers and public functions are given, they return what they promise or raise EpibarError.

A short run with every test; ``make fuzz`` tries ten thousand of each. What was found is in ``tests/corpus``.
"""

import json
import os
import string
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from jobs_input import FAST, write_masks
from network_input import made_up

import epibar
from epibar import Calibration, EpibarError, Network, Recording
from epibar.camera_files.formats import FORMATS
from epibar.camera_files.world import World
from epibar.errors import printable, without_secrets
from epibar.files.archive import read_archive, write_archive
from epibar.files.atomic import write_atomically
from epibar.files.json_file import json_text
from epibar.lens.cameras_toml import load_cameras, write_cameras
from epibar.lens.intrinsics import Intrinsics
from epibar.runs import Run
from epibar.sources.mask_frames import MaskFrames

CORPUS = Path(__file__).parent / "corpus"
MOST = int(os.environ.get("EPIBAR_FUZZ", "0"))
"""Inputs of each kind, where a long run is asked for."""


def tried(usual):
    """Settings of a test; the same inputs in every short run."""
    return settings(
        max_examples=MOST or usual,
        derandomize=not MOST,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("properties")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    made = tmp_path_factory.mktemp("calibrated")
    epibar.calibrate_all(write_masks(made)[:2], made / "out", **{**FAST, "lines": 60})
    return made / "out"


def members(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def load(kind, path):
    """Read a file; anything but a result and an EpibarError is a failure."""
    try:
        return kind(path)
    except EpibarError as error:
        told = str(error)
    assert 0 < len(told) < 20_000
    return None


def look(recording):
    """Use what was read, in every way that a report or a user does."""
    if recording is not None:
        assert recording.segments.shape[1] == 4
        assert str(epibar.inspect(recording))
        recording.hulls(recording.frames - 1)
        assert repr(recording)


edits = st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.binary(max_size=8)), min_size=1, max_size=4)


def edited(data, changes):
    for place, piece in changes:
        at = int(place * len(data))
        data = data[:at] + piece + data[at + len(piece) :] if piece else data[:at]
    return data


@tried(60)
@given(which=st.integers(0, 1), changes=edits)
def test_damaged_archives(which, changes, calibrated, folder):
    source = calibrated / ("recordings/cam1.npz", "pairs/cam1_cam2.npz")[which]
    path = folder / "archive.npz"
    path.write_bytes(edited(source.read_bytes(), changes))
    look(load(Recording.load, path))
    load(Calibration.load, path)
    load(MaskFrames, path)


# Headers are short, and damage there is worth more than among the numbers.
spots = st.one_of(st.integers(0, 127), st.integers(0, 1 << 16))


@tried(80)
@given(
    which=st.integers(0, 1),
    name=st.integers(0, 100),
    changes=st.lists(st.tuples(spots, st.binary(min_size=1, max_size=9)), min_size=1, max_size=3),
)
def test_damaged_arrays(which, name, changes, calibrated, folder):
    found = members(calibrated / ("recordings/cam1.npz", "pairs/cam1_cam2.npz")[which])
    chosen = sorted(found)[name % len(found)]
    data = found[chosen]
    for at, piece in changes:
        at %= len(data)
        data = data[:at] + piece + data[at + len(piece) :]
    path = folder / "arrays.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for entry, content in {**found, chosen: data}.items():
            archive.writestr(entry, content)
    look(load(Recording.load, path))
    load(Calibration.load, path)


values = st.one_of(
    arrays.arrays(
        st.sampled_from(["f8", "u8", "i8", "u4", "u2", "u1", "?", "f4", "U5", "c16", "M8[s]"]),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
)


@tried(60)
@given(which=st.integers(0, 1), name=st.integers(0, 100), value=values)
def test_arrays_of_other_kinds(which, name, value, calibrated, folder):
    found = dict(np.load(calibrated / ("recordings/cam1.npz", "pairs/cam1_cam2.npz")[which]))
    np.savez(folder / "kinds.npz", **{**found, sorted(found)[name % len(found)]: value})
    look(load(Recording.load, folder / "kinds.npz"))
    load(Calibration.load, folder / "kinds.npz")


json_values = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(max_size=5),
        st.just(10**400),
        st.just(".."),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=3), inner, max_size=2)
    ),
    max_leaves=6,
)


def places(value, path=()):
    """Yield the path of every value in some JSON."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inner:
        yield from places(part, (*path, key))


def replaced(value, path, other):
    if not path:
        return other
    copy = dict(value) if isinstance(value, dict) else list(value)
    copy[path[0]] = replaced(copy[path[0]], path[1:], other)
    return copy


@tried(120)
@given(place=st.integers(0, 10**6), value=json_values)
def test_a_calibration_json_with_other_values(place, value, calibrated):
    whole = json.loads((calibrated / "calibration.json").read_text())
    paths = list(places(whole))
    changed = calibrated / "changed.json"
    changed.write_text(json.dumps(replaced(whole, paths[place % len(paths)], value)))
    run = load(Run.load, changed)
    if run is not None:
        for pair in run.pairs:
            assert pair.F is None or np.isfinite(pair.F).all()
            assert isinstance(pair.frames_b, np.ndarray)
        for write in (epibar.export.write_csv, epibar.export.write_npz, epibar.export.write_opencv):
            load(lambda path, write=write: write(run, path), calibrated / "exported")


@tried(200)
@given(place=st.integers(0, 10**6), value=json_values)
def test_a_network_json_with_other_values(place, value, folder):
    whole = json.loads(json_text(made_up().as_dict()))
    paths = list(places(whole))
    changed = folder / "network.json"
    changed.write_text(json.dumps(replaced(whole, paths[place % len(paths)], value)))
    network = load(Network.load, changed)
    if network is not None:
        assert repr(network)
        assert all(np.isfinite(one.matrix).all() for one in network.cameras.values() if one.accepted)
        load(lambda _: network.scaled(person_height=1.7), None)
        for kind in ("anipose", "opencv", "npz"):
            load(lambda path, kind=kind: network.export(path, kind), folder / "exported")


@tried(120)
@given(place=st.integers(0, 10**6), value=json_values)
def test_the_header_of_a_calibration_with_other_values(place, value, calibrated, folder):
    stored = dict(np.load(calibrated / "pairs" / "cam1_cam2.npz"))
    header = json.loads(str(stored["header"]))
    paths = list(places(header))
    text = json.dumps(replaced(header, paths[place % len(paths)], value))
    np.savez(folder / "header.npz", **{**stored, "header": text.replace("\x00", "")})
    found = load(Calibration.load, folder / "header.npz")
    if found is not None:
        assert repr(found)
        assert found.frontier_points.frame.ndim == 1


@tried(60)
@given(
    data=st.one_of(
        st.binary(max_size=300), edits.map(lambda e: edited(b"frame_a,x_a,y_a,x_b,y_b,residual\n" * 3, e))
    )
)
def test_any_bytes_as_any_file(data, folder):
    for name, kind in (
        ("a.npz", Recording.load),
        ("a.npz", Calibration.load),
        ("calibration.json", Run.load),
        ("network.json", Network.load),
        ("cameras.toml", load_cameras),
        ("m.npz", MaskFrames),
        ("m.npy", MaskFrames),
        ("image.png", lambda path: epibar.record(path, lines=5)),
        ("v.mp4", lambda path: epibar.record(path, lines=5)),
    ):
        (folder / name).write_bytes(data)
        load(kind, folder / name)


@pytest.mark.parametrize("path", sorted(CORPUS.glob("*")), ids=lambda path: path.name)
def test_what_was_found_before(path, folder):
    kinds = {".npz": (Recording.load, Calibration.load, MaskFrames), ".npy": (MaskFrames,)}
    for kind in {**kinds, ".json": (Run.load, Network.load), ".toml": (load_cameras,)}[path.suffix]:
        load(kind, path)


numbers = st.one_of(
    st.floats(), st.floats(-300, 300), st.integers(-3, 300), st.just(10**400), st.text(max_size=2)
)


@tried(60)
@given(
    masks=arrays.arrays(
        st.sampled_from(["?", "u1", "f8"]), arrays.array_shapes(min_dims=1, max_dims=4, max_side=9)
    ),
    fps=numbers,
    lines=st.one_of(st.integers(-2, 40), numbers),
    seed=st.one_of(st.integers(), numbers),
)
def test_any_masks_become_a_recording_or_an_error(masks, fps, lines, seed, folder):
    made = load(lambda _: Recording.from_masks(masks, fps=fps, lines=lines, seed=seed), None)
    look(made)
    if made is not None:
        made.save(folder / "made.npz")
        again = Recording.load(folder / "made.npz")
        assert all(
            np.array_equal(a, b)
            for a, b in zip(made.to_arrays().values(), again.to_arrays().values(), strict=True)
        )


@tried(40)
@given(
    seeds=st.tuples(st.integers(0, 99), st.integers(0, 99)),
    frames=st.tuples(st.integers(1, 80), st.integers(1, 80)),
    fps=st.tuples(*2 * [st.floats(1e-3, 1e4)]),
    offset=st.one_of(st.just("search"), numbers),
    limit=numbers,
    reach=numbers,
    method=st.sampled_from(["frontier", "lines", "other"]),
    upright=st.booleans(),
)
@example((1, 2), (60, 60), (1e4, 1e-3), "search", 3.0, 1e12, "lines", True)
def test_any_two_recordings_are_calibrated_or_refused(
    seeds, frames, fps, offset, limit, reach, method, upright
):
    recordings = []
    for seed, count, rate in zip(seeds, frames, fps, strict=True):
        random = np.random.default_rng(seed)
        masks = np.zeros((count, 20 + seed % 13, 24 + seed % 7), bool)
        for mask in masks:
            x, y = random.integers(0, 18, 2)
            mask[y : y + 6, x : x + 4] = True
        recordings.append(Recording.from_masks(masks, fps=rate, lines=60, seed=seed))
    found = load(
        lambda _: epibar.calibrate(
            *recordings,
            method=method,
            time_offset=offset,
            max_expected_error=limit,
            search_seconds=reach,
            upright=upright,
            candidates=20,
            draws=40,
        ),
        None,
    )
    if found is not None:
        assert not found.accepted or np.isfinite(found.F).all()


@tried(60)
@given(
    a=arrays.arrays("u8", arrays.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=5)),
    b=arrays.arrays("u8", arrays.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=5)),
    frames=st.one_of(st.integers(-1, 400), numbers),
    mutual=st.one_of(st.integers(-1, 9), numbers),
    limit=st.one_of(st.integers(-1, 9), numbers),
)
def test_any_barcodes_are_matched_or_refused(a, b, frames, mutual, limit):
    load(lambda _: epibar.match_barcodes(a, b, frames, mutual=mutual, limit=limit), None)


@tried(60)
@given(
    masks=arrays.arrays("?", arrays.array_shapes(min_dims=2, max_dims=4, min_side=0, max_side=9)),
    segments=arrays.arrays("f8", arrays.array_shapes(min_dims=1, max_dims=2, min_side=0, max_side=5)),
)
def test_any_segments_have_barcodes_or_are_refused(masks, segments):
    load(lambda _: epibar.barcodes(masks, segments), None)


@tried(60)
@given(
    F=arrays.arrays("f8", arrays.array_shapes(min_dims=1, max_dims=3, max_side=4)),
    points=arrays.arrays("f8", arrays.array_shapes(min_dims=1, max_dims=2, max_side=3)),
)
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value", "ignore:divide by zero")
def test_any_points_have_a_distance_or_are_refused(F, points):
    load(lambda _: epibar.symmetric_epipolar_distance(F, points, points), None)


names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12)
evil = st.sampled_from(
    [
        '=cmd|"/c calc"!A1',
        "<script>alert(1)</script>",
        "a: b\n- c",
        '"]\nx = 1',
        "\\",
        "'",
        "{{x}}",
        "%n",
        "-",
        "𝕏",
        "+1",
        "@a",
    ]
)


@tried(80)
@given(given_names=st.lists(st.one_of(names, evil), min_size=2, max_size=3, unique=True))
def test_names_are_text_in_toml_yaml_and_csv(given_names, folder):
    import csv

    import cv2

    cameras = [Intrinsics(name, (64, 48), np.eye(3)) for name in given_names]
    write_cameras(folder / "names.toml", cameras, {"notes": given_names})
    assert [camera.name for camera in load_cameras(folder / "names.toml")] == given_names
    placed = {"rotation": np.zeros(3), "translation": np.zeros(3)}
    posed = [Intrinsics(name, (64, 48), np.eye(3), **placed) for name in given_names]
    FORMATS["opencv"].write(posed, folder / "cameras.yml", World("metre", notes=tuple(given_names)))
    if all(name.isprintable() for name in given_names):
        storage = cv2.FileStorage(str(folder / "cameras.yml"), cv2.FILE_STORAGE_READ)
        read = storage.getNode("cameras")
        assert [read.at(index).getNode("name").string() for index in range(read.size())] == given_names
        storage.release()
    points = epibar.FrontierPoints(np.arange(2), np.ones((2, 2)), np.ones((2, 2)), np.ones(2))
    pair = epibar.runs.Pair(
        given_names[0], given_names[1], np.eye(3), True, "good", given_names[0], 1.0, 0.0, points
    )
    run = Run([epibar.runs.Camera(name, (64, 48)) for name in given_names], [pair])
    epibar.export.write_csv(run, folder / "names.csv")
    with open(folder / "names.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    assert len(rows) == 3
    for row in rows:
        assert not any(cell[:1] in "=+-@\t\r\n" for cell in row[:3] if cell)
    if all(name.isprintable() for name in given_names):
        epibar.export.write_opencv(run, folder / "names.yml")
        storage = cv2.FileStorage(str(folder / "names.yml"), cv2.FILE_STORAGE_READ)
        read = storage.getNode("cameras")
        assert [read.at(index).getNode("name").string() for index in range(read.size())] == given_names
        storage.release()


@tried(200)
@given(text=st.text(st.characters(), max_size=60))
def test_printable_text_is_printable_and_plain_text_stays(text):
    shown = printable(text)
    assert not any(ord(sign) < 32 and sign not in "\n\t" for sign in shown)
    shown.encode()
    assert printable(shown) == shown


@tried(200)
@given(
    user=st.text(string.ascii_letters + string.digits + "!$%&*()=+:;,.?/#@-_", min_size=4, max_size=12),
    rest=st.sampled_from(["", "/a", "/a?x=1", ":554/b.sdp"]),
)
def test_no_user_and_no_password_is_shown(user, rest):
    shown = without_secrets(f"no answer from rtsp://{user}{user}@host{rest}: sorry")
    assert user not in shown
    assert "host" in shown


@tried(60)
@given(
    stored=st.dictionaries(
        st.text(string.ascii_letters, min_size=1, max_size=5),
        arrays.arrays(
            st.sampled_from(["f8", "i8", "u2", "?", "U3"]),
            arrays.array_shapes(min_dims=0, min_side=0, max_side=4),
        ),
        max_size=4,
    )
)
def test_archives_come_back_as_they_were(stored, folder):
    write_archive(folder / "any.npz", stored)
    found = read_archive(folder / "any.npz", "an archive")
    assert found.keys() == stored.keys()
    for name, value in stored.items():
        np.testing.assert_array_equal(found[name], value)


@tried(60)
@given(data=st.binary(max_size=100), fail=st.booleans())
def test_a_file_is_whole_or_as_it_was(data, fail, folder):
    path = folder / "whole"
    path.write_bytes(b"before")

    def write(stream):
        stream.write(data)
        if fail:
            raise OSError(5, "Input/output error")

    load(lambda target: write_atomically(target, write), path)
    assert path.read_bytes() == (b"before" if fail else data)
