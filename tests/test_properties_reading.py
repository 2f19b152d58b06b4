"""Whatever readers are given, they return what they promise or raise EpibarError.

A short run with every test; ``make hostile`` tries ten thousand of each. What was found: ``tests/corpus``.
"""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from jobs_input import FAST, write_masks
from network_input import made_up
from property_input import load, look, tried

import epibar
from epibar import Calibration, Network, Recording
from epibar.files.json_file import json_text
from epibar.lens.cameras_toml import load_cameras
from epibar.outcome import Run
from epibar.sources.mask_frames import MaskFrames

CORPUS = Path(__file__).parent / "corpus"


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
        for keep in (False, True):
            load(lambda _, keep=keep: network.scaled(person_height=1.7, keep=keep), None)
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


@pytest.mark.parametrize("path", sorted(CORPUS.glob("*.*")), ids=lambda path: path.name)
def test_what_was_found_before(path, folder):
    kinds = {".npz": (Recording.load, Calibration.load, MaskFrames), ".npy": (MaskFrames,)}
    for kind in {**kinds, ".json": (Run.load, Network.load), ".toml": (load_cameras,)}[path.suffix]:
        load(kind, path)
