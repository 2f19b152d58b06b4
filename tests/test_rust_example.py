"""The Rust program of `examples/rust`, built as a user's own, and files between Rust and Python."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import epibar
from epibar import synthetic

ROOT = Path(__file__).parent.parent
EXAMPLE = ROOT / "examples/rust"

pytestmark = pytest.mark.skipif(
    shutil.which("cargo") is None or not EXAMPLE.exists(), reason="no cargo, or not a checkout"
)


@pytest.fixture(scope="module")
def program():
    """Build it beside the crates of the workspace, of which it shares what is built already."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    command = ["cargo", "build", "--quiet", "--locked", "--manifest-path", EXAMPLE / "Cargo.toml"]
    subprocess.run([*command, "--target-dir", target], check=True)
    return target / "debug/epibar-example"


def run(program, *arguments):
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


def test_files_of_rust_are_files_of_python(program, tmp_path):
    printed = run(program, tmp_path)
    recordings = [epibar.Recording.load(tmp_path / f"{name}.npz") for name in "ab"]
    assert [recording.size for recording in recordings] == [(160, 140), (180, 140)]
    assert [(recording.frames, len(recording.segments)) for recording in recordings] == [(200, 2000)] * 2
    loaded = epibar.Calibration.load(tmp_path / "pair.npz")
    assert loaded.accepted
    assert printed.startswith(f"accepted: {loaded.reason}")
    # Python finds the same in the same recordings, to the last bit.
    found = epibar.calibrate(*recordings)
    assert_equal(loaded, found)


def test_files_of_python_are_files_of_rust(program, tmp_path):
    scene = synthetic.people(1, walkers=3, frames=120, size=(320, 240))
    paths = [tmp_path / "camera one.npz", tmp_path / "camera two.npz"]
    for camera, path in enumerate(paths):
        masks, matrix = scene.masks(camera), scene.cameras[camera].K
        epibar.Recording.from_masks(masks, lines=1500, seed=camera, name="é", matrix=matrix).save(path)
    run(program, *paths, tmp_path)
    found = epibar.calibrate(*(epibar.Recording.load(path) for path in paths))
    assert_equal(epibar.Calibration.load(tmp_path / "pair.npz"), found)


def assert_equal(loaded, found):
    """Every number is what it was."""
    assert (loaded.kind, loaded.reason, loaded.expected_error) == (
        found.kind,
        found.reason,
        found.expected_error,
    )
    assert (loaded.counts, loaded.evidence, loaded.source) == (found.counts, found.evidence, found.source)
    assert (loaded.timing, loaded.time_offset, loaded.seed) == (found.timing, found.time_offset, found.seed)
    for name in ("F", "floor"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(found, name))
    for name in ("lines_a", "lines_b", "correlation", "inliers"):
        np.testing.assert_array_equal(getattr(loaded.candidates, name), getattr(found.candidates, name))
    for name in ("frame", "a", "b", "residual"):
        np.testing.assert_array_equal(
            getattr(loaded.frontier_points, name), getattr(found.frontier_points, name)
        )
    np.testing.assert_array_equal(loaded.shift_curve, found.shift_curve)
    np.testing.assert_array_equal(loaded.error_maps, found.error_maps)
    assert len(loaded.rivals) == len(found.rivals)
    for one, other in zip(loaded.rivals, found.rivals, strict=True):
        np.testing.assert_array_equal(one["F"], other["F"])
        assert {k: v for k, v in one.items() if k != "F"} == {k: v for k, v in other.items() if k != "F"}
