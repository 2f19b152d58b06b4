"""What is written comes back, whole, whatever it is called; what is printed is harmless.

A short run with every test; ``make hostile`` tries ten thousand of each.
"""

import string

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from property_input import load, tried

import epibar
from epibar.camera_export.formats import CAMERA_FORMATS
from epibar.camera_export.world import World
from epibar.errors import printable, without_secrets
from epibar.files.archive import read_archive, write_archive
from epibar.files.atomic import write_atomically
from epibar.lens.cameras_toml import load_cameras, write_cameras
from epibar.lens.intrinsics import Intrinsics
from epibar.outcome import Run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("properties")


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
    CAMERA_FORMATS["opencv"].write(posed, folder / "cameras.yml", World("metre", notes=tuple(given_names)))
    if all(name.isprintable() for name in given_names):
        storage = cv2.FileStorage(str(folder / "cameras.yml"), cv2.FILE_STORAGE_READ)
        read = storage.getNode("cameras")
        assert [read.at(index).getNode("name").string() for index in range(read.size())] == given_names
        storage.release()
    points = epibar.FrontierPoints(np.arange(2), np.ones((2, 2)), np.ones((2, 2)), np.ones(2))
    pair = epibar.outcome.Pair(
        given_names[0], given_names[1], np.eye(3), True, "good", given_names[0], 1.0, 0.0, points
    )
    run = Run([epibar.outcome.RunCamera(name, (64, 48)) for name in given_names], [pair])
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
