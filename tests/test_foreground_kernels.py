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


@pytest.mark.parametrize(("count", "margin"), [(1, 3), (4, 5), (7, 9)])
def test_people_are_painted_over_as_opencv_does(count, margin):
    samples = np.stack(list(film(PRIMING + count))[PRIMING:])
    background = steady_background(np.stack(list(film(PRIMING))))
    painted = samples.copy()
    _core.paint_over(painted, background, 30, (5, 7, 30), margin)
    for sample, found in zip(samples, painted, strict=True):
        far = (cv2.absdiff(sample, background).max(axis=2) > 30).astype(np.uint8)
        people = _core.clean_mask(far, 5, 7, 30)
        assert people.any()
        around = cv2.dilate(people, np.ones((margin, margin), np.uint8))
        np.testing.assert_array_equal(found, np.where(around[..., None] > 0, background, sample))


def test_priming_is_learning_one_sample_after_the_other():
    samples = np.stack(list(film(30)))
    order = [*np.random.default_rng(0).permutation(30).tolist(), 3, 4]
    at_once, one_by_one = (MixtureModel(ForegroundOptions(), SIZE) for _ in range(2))
    at_once.prime(samples, order)
    for number, sample in enumerate(order):
        one_by_one.learn(samples[sample], number)
    moving = 0
    for frame in film(60, seed=4):
        expected = one_by_one.moving(frame, 0.002)
        np.testing.assert_array_equal(at_once.moving(frame, 0.002), expected)
        moving += np.count_nonzero(expected)
    assert moving > 5000
    with pytest.raises(EpibarError, match="samples must be whole frames"):
        at_once.prime(samples[:3], order)


def test_dark_borders_are_left_out_as_by_definition():
    """Which pixels count is decided by all samples, also where the background alone says enough."""
    for border, left_out in ((0, 0), (1, 0), (12, 11)):
        samples = np.stack(list(film(10)))
        samples[:, :, :border] = 9
        samples[7, :, :1] = 30  # a background that is dark, and a sample that is not
        foreground = Foreground()
        foreground.prime(iter(samples))
        if left_out:
            np.testing.assert_array_equal(foreground.counted, samples.max(axis=(0, 3)) >= 24)
            assert np.count_nonzero(~foreground.counted) == left_out * SIZE[1]
        else:
            assert foreground.counted is None


@pytest.mark.parametrize("size", [(8, 8), (64, 48), (640, 360), (1928, 80)])
def test_shrunk_green_is_opencv_s(size):
    random = np.random.default_rng(size[0])
    frame = random.integers(0, 256, (*size[::-1], 3)).astype(np.uint8)
    frame[:8, :8] = 0
    frame[:4, :8, 1] = 5  # half of them: 2.5, which is 2
    green = cv2.extractChannel(frame, 1)
    expected = cv2.resize(green, (size[0] // 8, size[1] // 8), interpolation=cv2.INTER_AREA)
    np.testing.assert_array_equal(_core.shrunk_green(frame), expected)
    assert expected[0, 0] == 2
    with pytest.raises(ValueError, match="must be a multiple of 8 pixels each way"):
        _core.shrunk_green(np.zeros((8, 12, 3), np.uint8))


@pytest.mark.parametrize("shape", [(1, 1), (5, 9), (30, 40), (61, 80)])
@pytest.mark.parametrize("counted_share", [None, 0.0, 0.7])
def test_light_is_compared_as_numpy_does(shape, counted_share):
    random = np.random.default_rng(shape[0])
    first = random.integers(0, 256, shape).astype(np.uint8)
    before = np.clip(first + random.normal(0, 6, shape), 0, 255).astype(np.uint8)
    now = np.clip(first + random.normal(4, 8, shape), 0, 255).astype(np.uint8)
    counted = None if counted_share is None else (random.random(shape) < counted_share).astype(np.uint8)
    variance, changed, jumped, compared, levels = _core.compare_light(now, before, first, 8, counted)
    change = np.abs(now.astype(int) - before)
    those = change if counted is None else change[counted > 0]
    assert variance == pytest.approx(now.std() ** 2, rel=1e-12)
    assert (changed, jumped, compared) == (change.any(), np.count_nonzero(those > 8), those.size)
    for level, rows in zip(levels, np.array_split(now.astype(np.int16) - first, 8), strict=True):
        values = np.sort(rows, axis=None)
        quarter = len(values) // 4
        assert level == (values[quarter : len(values) - quarter].mean() if len(values) else 0.0)
    assert _core.compare_light(now, now, first, 8)[1:3] == (False, 0)
    with pytest.raises(ValueError, match="grids of one size"):
        _core.compare_light(now, before[1:], first, 8)
