"""The compiled parts of the foreground beside OpenCV and numpy, which do the same at their leisure."""

import cv2
import numpy as np
import pytest

from epibar import _core
from epibar.errors import EpibarError
from epibar.foreground import Foreground, ForegroundOptions
from epibar.foreground.background_models import MixtureModel, OpenCvModel, new_model
from epibar.foreground.empty_scene import steady_background

SIZE = 96, 80
PRIMING = 20


def film(count, seed=1):
    """Noise before a coloured scene, a bright bar that passes with its shadow, and leaves that flutter."""
    random = np.random.default_rng(seed)
    width = SIZE[0]
    empty = cv2.resize(random.integers(40, 200, (8, 10, 3)).astype(np.uint8), SIZE)
    for t in range(count):
        frame = empty.astype(float)
        if t % 3:
            frame[60:, :30] = 255 - frame[60:, :30]
        if t >= PRIMING:
            x = 2 * (t - PRIMING) % width
            frame[10:50, x : x + 12] = (20, 230, 90)
            frame[50:58, x : x + 30] *= 0.6
        yield np.clip(frame + random.normal(0, 3.0, frame.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("options", [{}, {"shadows": False}, {"threshold": 16.0}, {"threshold": 5.0}])
def test_a_mixture_that_learns_from_every_row_is_mog2(options):
    options = ForegroundOptions(**options)
    ours, theirs = MixtureModel(options, SIZE), OpenCvModel(options)
    differing, moving = 0, 0
    for number, frame in enumerate(film(80)):
        if number < PRIMING:
            for model in (ours, theirs):
                model.learn(frame, number)
            continue
        rate = 0.05 if number % 7 == 0 else 0.012  # high enough for rows not to take turns
        masks = [model.moving(frame, rate) for model in (ours, theirs)]
        differing += np.count_nonzero(masks[0] != masks[1])
        moving += np.count_nonzero(masks[1])
    assert moving > 20_000
    assert differing < 1e-4 * moving  # single precision, in another order


def test_rows_in_turn_learn_as_much():
    """At a low rate each row is OpenCV's MOG2 at a higher one on some frames, and at none on the others."""
    rate, turns = 0.002, 5
    options = ForegroundOptions()
    ours = MixtureModel(options, SIZE)
    theirs = [OpenCvModel(options) for _ in range(turns)]
    differing, moving = 0, 0
    for number, frame in enumerate(film(100)):
        strips = [np.ascontiguousarray(frame[turn::turns]) for turn in range(turns)]
        if number < PRIMING:
            ours.learn(frame, number)
            for model, strip in zip(theirs, strips, strict=True):
                model.learn(strip, number)
            continue
        mask = ours.moving(frame, rate)
        for turn, (model, strip) in enumerate(zip(theirs, strips, strict=True)):
            now = (number - PRIMING) % turns == turn
            expected = model.moving(strip, turns * rate if now else 0.0)
            differing += np.count_nonzero(mask[turn::turns] != expected)
            moving += np.count_nonzero(expected)
    assert moving > 20_000
    assert differing < 1e-4 * moving


def test_the_mixture_is_the_default_at_every_size():
    assert ForegroundOptions().method == "auto"
    for width, method, kind in (
        (96, "auto", MixtureModel),
        (800, "auto", MixtureModel),
        (1920, "auto", MixtureModel),
        (1920, "mog2", OpenCvModel),
        (320, "mog2", OpenCvModel),
        (320, "knn", OpenCvModel),
        (320, "mixture", MixtureModel),
    ):
        assert isinstance(new_model(ForegroundOptions(method=method), (width, 40)), kind)


@pytest.mark.parametrize("period", [2, 4, 16])
def test_rows_in_turn_see_all_phases_of_a_flicker(period):
    """Rows that learn from every 16th frame would see one phase of a light alone, and forget the others."""
    random = np.random.default_rng(4)
    empty = cv2.resize(random.integers(150, 200, (8, 10, 3)).astype(np.uint8), SIZE).astype(float)

    def lit(t):
        bright = 1.0 if t % period < period // 2 else 0.87
        return np.clip(bright * empty + random.normal(0, 3.0, empty.shape), 0, 255).astype(np.uint8)

    foreground = Foreground(ForegroundOptions(shadows=False))
    foreground.prime(lit(t) for t in range(0, 1500, 25))
    shares = [foreground.moving(lit(t)).mean() for t in range(1500)]
    assert np.mean(shares[-300:]) < 0.001


def compressed(frame):
    return cv2.imdecode(cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, 20])[1], cv2.IMREAD_COLOR)


@pytest.mark.parametrize(
    "change",
    [
        lambda frame, t: frame,
        lambda frame, t: (frame * (1 - 0.2 * t / 300)).astype(np.uint8),
        lambda frame, t: (frame * (0.92, 1.0, 0.96)[t % 3]).astype(np.uint8),
        lambda frame, t: (frame * (1.0 if t < 150 else 0.2)).astype(np.uint8),
        lambda frame, t: compressed(frame),
    ],
    ids=["nothing", "daylight", "flicker", "switch", "compression"],
)
def test_rows_in_turn_see_in_small_images_what_mog2_sees(change):
    """What changes slowly, from frame to frame, or at once and stays, is learnt by rows in turn as well."""
    frames = [change(frame, t) for t, frame in enumerate(film(300))]
    ours, theirs = (Foreground(ForegroundOptions(method=method)) for method in ("auto", "mog2"))
    differing, moving = 0, 0
    for foreground in (ours, theirs):
        foreground.prime(frames[:150:3])
    for frame in frames:
        masks = [foreground.apply(frame) for foreground in (ours, theirs)]
        differing += np.count_nonzero(masks[0] != masks[1])
        moving += np.count_nonzero(masks[1])
    assert moving > 100_000
    assert differing < 0.03 * moving


def test_large_frames_without_priming_and_with():
    frames = [cv2.resize(frame, (1000, 300)) for frame in film(40)]
    foreground = Foreground(ForegroundOptions(warm_up=PRIMING))
    masks = [foreground.apply(frame) for frame in frames]
    assert not np.any(masks[:PRIMING])
    assert all(mask[40:180].mean() > 0.05 for mask in masks[PRIMING:])
    other = Foreground(ForegroundOptions(method="mog2", warm_up=PRIMING))
    for mask, frame in zip(masks, frames, strict=True):
        assert np.mean(mask != other.apply(frame)) < 0.003


def blobs(share, size=SIZE, seed=2):
    random = np.random.default_rng(seed)
    mask = (random.random(size[::-1]) < share).astype(np.uint8)
    for _ in range(6):
        x, y = random.integers(0, size)
        cv2.circle(mask, (int(x), int(y)), int(random.integers(3, 14)), 1, -1)
    return mask


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.6])
@pytest.mark.parametrize(("median", "closing"), [(5, 7), (11, 15), (3, 1), (1, 9), (23, 31)])
def test_cleaning_is_opencv_s(share, median, closing):
    for size in (SIZE, (200, 33), (37, 150)):
        mask = expected = blobs(share, size)
        ignore = np.zeros_like(mask)
        ignore[5:20, 10:30] = 7
        expected = expected * (ignore == 0)
        if median > 1:
            expected = cv2.medianBlur(expected, median)
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (closing, closing))
        expected = cv2.morphologyEx(expected, cv2.MORPH_CLOSE, disc) * (ignore == 0)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(expected, connectivity=8)
        kept = stats[:, cv2.CC_STAT_AREA] >= 30
        kept[0] = False
        found = _core.clean_mask(255 * mask, median, closing, 30, ignore)
        np.testing.assert_array_equal(found, kept[labels])


def test_too_wide_a_filter_is_refused():
    foreground = Foreground(ForegroundOptions(median_filter=99.0))
    with pytest.raises(EpibarError, match="median = 297: must be an odd number of pixels below 256"):
        foreground.clean(np.zeros((1440, 20), np.uint8))


def steadiest(samples):
    """The definition, pixel by pixel."""
    count, height, width = samples.shape[:3]
    found = np.empty(samples.shape[1:], np.uint8)
    for y, x in np.ndindex(height, width):
        colours = samples[:, y, x].astype(int)
        grey = (colours @ (1, 2, 1)) >> 2
        ordered = np.sort(grey)
        low = high = narrowest = None
        for share in (0.25, 0.375, 0.5, 0.625):
            window = min(count, max(2, round(count * share)))
            widths = ordered[window - 1 :] - ordered[: count - window + 1]
            first, width_ = ordered[widths.argmin()], widths.min()
            if narrowest is None:
                low, high, narrowest = first, first + width_, width_
            elif width_ <= 3 * narrowest + 6:
                low, high = first, first + width_
        found[y, x] = np.rint(colours[(grey >= low) & (grey <= high)].mean(axis=0))
    return found


@pytest.mark.parametrize("count", [3, 4, 17, 60])
def test_the_empty_scene_is_what_its_definition_says(count):
    random = np.random.default_rng(count)
    samples = random.normal(120, 4, (count, 9, 41, 3)) + random.integers(0, 2, (count, 9, 41, 1)) * 60
    samples[:, :2] = random.integers(0, 256, (count, 2, 41, 3))
    samples = np.clip(samples, 0, 255).astype(np.uint8)
    np.testing.assert_array_equal(steady_background(samples), steadiest(samples))
