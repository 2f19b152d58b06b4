"""Figures: what is drawn is where F, the recordings and the verdicts say."""

import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest

import epibar
from epibar import plot, synthetic
from epibar.geometry.epipolar import symmetric_epipolar_distance

mpl.use("Agg")

from matplotlib import pyplot as plt


@pytest.fixture(scope="module")
def scene():
    return synthetic.people(seed=5, cameras=3, walkers=6, frames=400, size=(320, 240), asymmetric=True)


@pytest.fixture(scope="module")
def recordings(scene):
    return [
        epibar.Recording.from_masks(scene.masks(index), fps=scene.fps, lines=4000, seed=index, name=name)
        for index, name in ((0, "left"), (2, "right"))
    ]


@pytest.fixture(scope="module")
def calibration(recordings):
    found = epibar.calibrate(*recordings)
    assert found.accepted
    return found


@pytest.fixture(scope="module")
def refused(calibration):
    none = epibar.FrontierPoints(np.empty(0, int), np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
    return replace(
        calibration,
        F=None,
        accepted=False,
        kind="no_common_scene",
        reason="Nothing in common.",
        expected_error=None,
        frontier_points=none,
        shift_curve=(np.empty(0), np.empty(0)),
        candidates=epibar.Candidates(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0, bool)),
        error_maps=None,
    )


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def drawn(axes):
    """Draw the whole figure, which is where matplotlib finds most of what is wrong with it."""
    figure = (axes[0] if isinstance(axes, tuple) else axes).figure
    figure.canvas.draw()
    return axes


def lines_of(ax):
    """Ends of the epipolar lines and their colours."""
    return {line.get_color(): line.get_xydata() for line in ax.lines if line.get_linestyle() == "-"}


def dots_of(ax):
    return {line.get_color(): line.get_xydata()[0] for line in ax.lines if line.get_marker() == "o"}


def test_lines_of_one_colour_correspond(recordings, calibration):
    left, right = drawn(plot.epipolar_lines(calibration, *recordings))
    segments_a, segments_b = lines_of(left), lines_of(right)
    assert len(segments_a) == 8
    assert segments_a.keys() == segments_b.keys()
    for colour, ends_a in segments_a.items():
        a, b = ends_a.mean(axis=0), segments_b[colour].mean(axis=0)
        assert symmetric_epipolar_distance(calibration.F, a[None], b[None])[0] < 3
    dots_a, dots_b = dots_of(left), dots_of(right)
    points = calibration.frontier_points
    pairs = {(*a, *b) for a, b in zip(points.a.tolist(), points.b.tolist(), strict=True)}
    assert dots_a
    assert all((*dots_a[colour], *dots_b[colour]) in pairs for colour in dots_a)
    assert left.get_title().startswith("left, frame ")


def test_silhouettes_or_an_image_lie_below(recordings, calibration, scene):
    left, right = plot.epipolar_lines(calibration, *recordings, frame=30)
    assert len(left.collections[0].get_paths()) == len(recordings[0].hulls(30))
    assert (left.get_ylim(), right.get_xlim()) == ((239.5, -0.5), (-0.5, recordings[1].width - 0.5))
    frames = [np.zeros((recording.height, recording.width, 3), np.uint8) for recording in recordings]
    left, _ = drawn(plot.epipolar_lines(calibration, *recordings, images=frames))
    assert left.images[0].get_array().shape == frames[0].shape
    with pytest.raises(epibar.EpibarError, match="the image for right has 320x240 pixels"):
        plot.epipolar_lines(calibration, *recordings, images=(None, frames[0]))


def test_a_time_offset_moves_the_other_view(recordings, calibration):
    shifted = replace(calibration, time_offset=5.0)
    _, right = plot.epipolar_lines(shifted, *recordings, frame=30)
    assert right.get_title() == "right, frame 35"
    with pytest.raises(epibar.EpibarError, match="frame = 398"):
        plot.epipolar_lines(shifted, *recordings, frame=398)


@pytest.mark.parametrize("colour", ["frame", "residual"])
def test_frontier_points(recordings, calibration, colour):
    points = calibration.frontier_points
    left, right = drawn(plot.frontier_points(calibration, *recordings, colour=colour))
    np.testing.assert_array_equal(left.collections[0].get_offsets(), points.a)
    np.testing.assert_array_equal(right.collections[0].get_offsets(), points.b)
    value = points.frame if colour == "frame" else points.residual
    np.testing.assert_array_equal(right.collections[0].get_array(), value)


def test_what_is_drawn_is_one_of_some_words(recordings, calibration):
    with pytest.raises(epibar.EpibarError, match="kind = 'both': it must be one of epipolar, matched"):
        plot.barcode_strips(calibration, *recordings, kind="both")
    with pytest.raises(epibar.EpibarError, match="colour = None: it must be one of frame, residual"):
        plot.frontier_points(calibration, *recordings, colour=None)


def test_heat_map_is_the_share_of_frames(recordings):
    recording = recordings[0]
    ax = drawn(plot.heat_map(recording))
    np.testing.assert_allclose(ax.images[0].get_array(), recording.heat / recording.frames)
    assert "motion line" in ax.get_title()


def test_motion_lines_are_drawn():
    """Everybody on one straight path leaves a line."""
    scene = synthetic.people(seed=4, cameras=1, walkers=5, one_path=True, frames=300, size=(320, 240))
    recording = epibar.Recording.from_masks(scene.masks(0), lines=2000)
    expected = epibar._core.motion_lines(recording._core)
    assert len(expected)
    ax = drawn(plot.heat_map(recording))
    for line, (a, b, c) in zip(ax.lines, expected, strict=True):
        np.testing.assert_allclose(line.get_xydata() @ [a, b] + c, 0, atol=1e-6)
    assert not plot.heat_map(recording, motion_lines=False).lines


@pytest.mark.parametrize("kind", ["matched", "epipolar"])
def test_barcode_strips(recordings, calibration, kind):
    ax = drawn(plot.barcode_strips(calibration, *recordings, kind=kind))
    strips = [image.get_array()[0] for image in ax.images]
    texts = [text.get_text() for text in ax.texts if text.get_text().startswith("r = ")]
    assert len(strips) == 2 * len(texts) > 0
    agree = []
    for text, bits_a, bits_b in zip(texts, strips[::2], strips[1::2], strict=True):
        if bits_b.all() or not bits_b.any():
            assert text == "r = –"
            continue
        agree.append(np.corrcoef(bits_a, bits_b)[0, 1])
        assert text == f"r = {agree[-1]:.2f}"
    # The barcodes of matched lines agree: this is what the method rests on.
    assert np.median(agree) > 0.7


def test_time_shift_curve(calibration):
    ax = drawn(plot.time_shift_curve(calibration))
    shifts, scores = calibration.shift_curve
    own = next(line for line in ax.lines if line.get_marker() == "o")
    assert own.get_xydata().tolist() == [[shifts[0], scores[0]]]
    assert shifts[0] == 0


def test_residual_histogram_counts_every_point(calibration):
    ax = drawn(plot.residual_histogram(calibration))
    assert sum(bar.get_height() for bar in ax.patches) == len(calibration.frontier_points)
    assert ax.lines[0].get_xdata()[0] == np.median(calibration.frontier_points.residual)


def test_expected_error_map(recordings, calibration):
    maps = np.full((24, 32), 0.5), np.geomspace(0.1, 10, 30 * 40).reshape(30, 40)
    known = SimpleNamespace(error_maps=maps, reason="")
    left, right = drawn(plot.expected_error_map(known, *recordings))
    np.testing.assert_array_equal(right.images[0].get_array(), maps[1])
    assert right.images[0].get_extent() == [-0.5, recordings[1].width - 0.5, recordings[1].height - 0.5, -0.5]
    assert left.images[0].norm is right.images[0].norm
    unknown = SimpleNamespace(error_maps=None, reason="Too little motion.")
    with pytest.raises(epibar.EpibarError, match="Too little motion"):
        plot.expected_error_map(unknown, *recordings)


def test_pair_matrix(calibration, refused):
    names = ["left", "middle", "right"]
    pairs = {("left", "right"): calibration, ("middle", "left"): refused}
    ax = drawn(plot.pair_matrix(names, pairs))
    texts = {tuple(text.get_position()): text.get_text() for text in ax.texts}
    assert texts == {(2, 0): f"{calibration.expected_error:.2g} px", (1, 0): "no\ncommon\nscene"}
    shades = np.ma.filled(ax.images[0].get_array(), np.nan)
    assert shades[0, 2] == calibration.expected_error
    assert np.isfinite(shades).sum() == 1
    with pytest.raises(epibar.EpibarError, match="nobody"):
        plot.pair_matrix(names, {("left", "nobody"): calibration})


def test_axes_of_the_caller_are_used(recordings, calibration):
    figure, axes = plt.subplots(2, 2)
    assert plot.residual_histogram(calibration, ax=axes[0, 0]) is axes[0, 0]
    assert plot.heat_map(recordings[0], ax=axes[0, 1]) is axes[0, 1]
    assert plot.epipolar_lines(calibration, *recordings, ax=axes[1]) == tuple(axes[1])
    figure.canvas.draw()
    with pytest.raises(epibar.EpibarError, match="expected two"):
        plot.epipolar_lines(calibration, *recordings, ax=axes[0, :1])


@pytest.mark.parametrize(
    "draw",
    [
        lambda cal, recs: plot.epipolar_lines(cal, *recs),
        lambda cal, recs: plot.barcode_strips(cal, *recs),
        lambda cal, recs: plot.time_shift_curve(cal),
        lambda cal, recs: plot.residual_histogram(cal),
        lambda cal, recs: plot.expected_error_map(cal, *recs),
    ],
)
def test_nothing_to_draw_is_said_with_the_reason(recordings, refused, draw):
    with pytest.raises(epibar.EpibarError, match="Nothing in common"):
        draw(refused, recordings)


def test_no_frontier_points_is_an_empty_picture(recordings, refused):
    left, _ = drawn(plot.frontier_points(refused, *recordings))
    assert left.get_title() == "left, 0 frontier points"


def test_matplotlib_is_imported_late_and_named_when_missing(calibration, monkeypatch):
    code = "import sys, epibar; epibar.plot.heat_map; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(epibar.EpibarError, match=r"epibar\[plot\]"):
        plot.residual_histogram(calibration)
