"""Whatever public functions are given, they return what they promise or raise EpibarError.

A short run with every test; ``make hostile`` tries ten thousand of each.
"""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from property_input import load, look, tried

import epibar
from epibar import Recording


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("properties")


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
