"""Masks of moving things in noisy synthetic video, and what the health check says about the camera."""

import inspect
from typing import get_args

import cv2
import numpy as np
import pytest

import epibar
from epibar import _core
from epibar.errors import EpibarError
from epibar.foreground import Foreground, options
from epibar.foreground.empty_scene import collect, median_background, samples_in_memory, steady_background
from epibar.foreground.options import ForegroundMethod, ForegroundOptions
from epibar.health.camera_health import CameraHealth
from epibar.jobs.inputs import RecordOptions
from epibar.sources.colour_frames import ColourFrames

HEIGHT, WIDTH, COUNT = 120, 160, 60
METHODS = ["mog2", "mixture", "knn", "median"]


def scenery(height=HEIGHT, width=WIDTH):
    """A smooth, textured, coloured empty scene."""
    coarse = np.random.default_rng(1).integers(60, 180, (height // 10, width // 10, 3)).astype(np.uint8)
    return cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)


def walkers(index, height=HEIGHT, width=WIDTH):
    """True silhouettes: one who walks, and one who arrives at frame 20 and stands until frame 40."""
    mask = np.zeros((height, width), np.uint8)
    cv2.ellipse(mask, (20 + 2 * index, 60), (8, 22), 0, 0, 360, 1, -1)
    if 20 <= index < 40:
        cv2.ellipse(mask, (120, 50), (7, 20), 0, 0, 360, 1, -1)
    return mask


def noisy(frame, index, sigma=4.0):
    noise = np.random.default_rng(index).normal(0, sigma, frame.shape)
    return np.clip(frame + noise, 0, 255).astype(np.uint8)


def frame_of(index, shadow=False):
    frame = scenery()
    if shadow:
        cast = np.zeros((HEIGHT, WIDTH), np.uint8)
        cv2.ellipse(cast, (35 + 2 * index, 90), (20, 6), 0, 0, 360, 1, -1)
        frame[cast > 0] = (frame[cast > 0] * 0.65).astype(np.uint8)
    frame[walkers(index) > 0] = (30, 20, 230)
    return noisy(frame, index)


def overlap(mask, truth):
    return (mask & truth).sum() / max(1, (mask | truth).sum())


def primed(method="mog2", **options):
    foreground = Foreground(ForegroundOptions(method=method, **options))
    foreground.prime(frame_of(index) for index in range(COUNT))
    return foreground


@pytest.mark.parametrize("method", METHODS)
def test_silhouettes_from_the_first_frame_to_the_last(method):
    foreground = primed(method)
    scores = []
    for index in range(COUNT):
        mask = foreground.apply(frame_of(index))
        assert mask.dtype == np.uint8
        assert set(np.unique(mask)) <= {0, 1}
        scores.append(overlap(mask, walkers(index)))
    assert min(scores) > 0.8
    assert np.mean(scores) > 0.88


@pytest.mark.parametrize("sigma", [3.0, 9.0])
@pytest.mark.parametrize("method", METHODS)
def test_outlines_are_neither_fat_nor_thin(method, sigma):
    empty, foreground = scenery(360, 480), Foreground(ForegroundOptions(method=method))

    def filmed(index):
        frame, truth = empty.copy(), np.zeros(empty.shape[:2], np.uint8)
        cv2.circle(truth, (60 + 12 * index, 180), 40, 1, -1)
        frame[truth > 0] = (30, 20, 230)
        return noisy(frame, index, sigma), truth

    foreground.prime(filmed(index)[0] for index in range(30))
    for index in range(0, 30, 5):
        frame, truth = filmed(index)
        areas = [mask.sum() for mask in (foreground.apply(frame), truth)]
        assert abs(np.diff(np.sqrt(np.array(areas) / np.pi))[0]) < 0.2  # radius, pixels


@pytest.mark.parametrize("method", METHODS)
def test_shadows_are_dropped(method):
    shares = []
    for shadows in (True, False):
        foreground = primed(method, shadows=shadows)
        masks = [foreground.apply(frame_of(index, shadow=True)) for index in range(COUNT)]
        shares.append(np.mean([overlap(mask, walkers(index)) for index, mask in enumerate(masks)]))
    assert shares[0] > 0.8
    assert shares[1] < 0.75


@pytest.mark.parametrize("method", METHODS)
def test_without_priming_the_first_frames_teach(method):
    foreground = Foreground(ForegroundOptions(method=method, warm_up=15))
    for index in range(15):
        assert not foreground.apply(noisy(scenery(), 1000 + index)).any()
    assert overlap(foreground.apply(frame_of(0)), walkers(0)) > 0.75


@pytest.mark.parametrize("method", METHODS)
def test_learning_anew_after_the_light_was_switched(method):
    foreground = primed(method)
    dark = [noisy((scenery() * 0.25).astype(np.uint8), index) for index in range(60)]
    shares = [foreground.apply(frame).mean() for frame in dark]
    assert shares[0] > 0.6
    assert max(shares[-10:]) < 0.05


@pytest.mark.parametrize("method", METHODS)
def test_background_clip(tmp_path, method):
    for index in range(5):
        cv2.imwrite(str(tmp_path / f"{index}.png"), noisy(scenery(), 500 + index))
    film = tmp_path / "film"
    film.mkdir()
    standing = scenery()
    standing[walkers(30) > 0] = (30, 20, 230)
    for index in range(20):  # nobody moves at all
        cv2.imwrite(str(film / f"{index}.png"), noisy(standing, index))
    options = ForegroundOptions(method=method, background=tmp_path)
    with ColourFrames(film, fps=10) as frames:
        foreground = Foreground.for_frames(frames, options)
        scores = [overlap(foreground.apply(frame), walkers(30)) for _, _, frame in frames]
    assert min(scores) > 0.8
    cv2.imwrite(str(film / "other.png"), np.zeros((10, 10, 3), np.uint8))
    with (
        ColourFrames(film, fps=10) as frames,
        pytest.raises(EpibarError, match=r"other.png: 10x10, but .*film is 160x120"),
    ):
        Foreground.for_frames(frames, ForegroundOptions(background=film / "other.png"))


def test_ignore_mask():
    ignore = np.zeros((HEIGHT, WIDTH), bool)
    ignore[:, 80:] = True
    foreground = primed(ignore=ignore)
    masks = np.stack([foreground.apply(frame_of(index)) for index in range(COUNT)])
    assert masks[:, :, :80].any()
    assert not masks[:, :, 80:].any()
    with pytest.raises(EpibarError, match="ignore mask: 5x4, but the frames are 160x120"):
        primed(ignore=np.zeros((4, 5), bool))


def test_small_things_are_removed_at_every_resolution():
    for scale in (1, 3):
        foreground = Foreground()
        empty = cv2.resize(scenery(), None, fx=scale, fy=scale)
        foreground.prime(noisy(empty, index) for index in range(10))
        frame = empty.copy()
        frame[10 * scale : 13 * scale, 10 * scale : 12 * scale] = (0, 0, 255)
        frame[50 * scale : 80 * scale, 60 * scale : 75 * scale] = (0, 0, 255)
        mask = foreground.apply(noisy(frame, 77))
        assert not mask[: 30 * scale].any()
        assert mask[50 * scale : 80 * scale, 60 * scale : 75 * scale].mean() > 0.95


def test_what_is_small_is_what_opencv_counts():
    mask = (np.random.default_rng(1).random((90, 133)) < 0.3).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    area = stats[:, cv2.CC_STAT_AREA]
    area[0] = 0
    for least in (1, 2, 5, 30, 100_000):
        kept = _core.clean_mask(mask, 1, 1, least)
        assert kept.dtype == np.uint8
        np.testing.assert_array_equal(kept, area[labels] >= least)
    assert (area >= 30).any()
    assert (area[1:] < 30).any()


def test_ready_masks_are_cleaned_alike():
    truth = walkers(30, 480, 640)
    dirty = truth.astype(bool)
    dirty[55:57, 79:82] = False
    dirty[5:8, 5:8] = True
    foreground = Foreground()
    cleaned = foreground.clean(dirty)
    assert cleaned.dtype == np.uint8
    assert not cleaned[:15].any()
    assert overlap(cleaned, truth) > 0.97
    assert cleaned[55:57, 79:82].all()
    assert np.array_equal(cleaned, foreground.clean(dirty.astype(np.uint8) * 255))
    bare = Foreground(ForegroundOptions(median_filter=0.0, closing=0.0))
    assert np.array_equal(bare.clean(np.asfortranarray(dirty)), bare.clean(dirty))
    with pytest.raises(EpibarError, match="10x10 after frames of 640x480"):
        foreground.clean(np.zeros((10, 10), bool))
    with pytest.raises(EpibarError, match="not float64"):
        foreground.clean(np.zeros((HEIGHT, WIDTH)))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"method": "magic"},
            "foreground method = 'magic': it must be one of auto, mog2, mixture, knn, median",
        ),
        ({"method": 3}, "foreground method = 3: it must be one of auto, mog2, mixture, knn, median"),
        ({"warm_up": 0}, "warm_up = 0: it must be at least 1"),
        ({"warm_up": 2.5}, "warm_up = 2.5: expected a whole number"),
        ({"memory": None}, "memory = None: expected a whole number"),
        ({"min_area": 1.5}, "min_area = 1.5: it must be a share of the image, from 0 to below 1"),
        ({"min_area": "x"}, "min_area = 'x': it must be a share of the image"),
        ({"closing": -1}, r"closing = -1: it must be 0 \(off\) or more, and below 100"),
        ({"median_filter": 100}, r"median_filter = 100: it must be 0 \(off\) or more, and below 100"),
        (
            {"threshold": float("nan")},
            "threshold = nan: it must be positive, or 0 for the method's default",
        ),
        ({"ignore": np.zeros(5, bool)}, r"ignore mask has shape \(5,\)"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(EpibarError, match=message):
        ForegroundOptions(**options)


def test_bad_frames():
    foreground = primed()
    with pytest.raises(EpibarError, match="a frame of 10x10 after frames of 160x120"):
        foreground.apply(np.zeros((10, 10, 3), np.uint8))
    with pytest.raises(EpibarError, match="not float64"):
        foreground.apply(np.zeros((HEIGHT, WIDTH, 3)))
    with pytest.raises(EpibarError, match="no frames"):
        Foreground().prime([])
    with pytest.raises(EpibarError, match="10x8 after frames of 8x8"):
        collect([np.zeros((8, 8, 3), np.uint8), np.zeros((8, 10, 3), np.uint8)], 5)


def test_steady_background_where_the_median_fails():
    samples = np.stack([noisy(scenery(), index, 1.0) for index in range(40)])
    for index in range(24):  # 60 % of the samples show something else, never twice the same
        samples[index, 30:60, 30:60] = 200 + 2 * index
    truth = scenery()[30:60, 30:60].astype(int)
    assert np.abs(steady_background(samples)[30:60, 30:60] - truth).mean() < 3
    assert np.abs(median_background(samples)[30:60, 30:60] - truth).mean() > 10


def test_collect_spreads_its_samples():
    kept = collect((np.full((4, 4, 3), index, np.uint8) for index in range(200)), 10)
    levels = kept[:, 0, 0, 0].astype(int)
    assert 5 <= len(levels) <= 10
    assert len(set(np.diff(levels))) == 1
    assert levels[-1] > 150


def test_no_more_is_sampled_than_is_kept():
    assert samples_in_memory(60, 3 * 640 * 480) == 60
    assert samples_in_memory(60, 3 * 1920 * 1080) == 30
    assert samples_in_memory(60, 10**9) == 4
    for limit, memory in ((60, 1000), (37, 480), (9, 48)):
        count = samples_in_memory(limit, 48, memory)
        assert len(collect(np.zeros((limit, 4, 4, 3), np.uint8), limit, memory)) == count


def big_scene(index=0, shift=0, gain=1.0):
    random = np.random.default_rng(3)
    frame = np.full((240, 320, 3), 90, np.uint8)
    for _ in range(60):
        x, y, w, h = random.integers((0, 0, 8, 8), (310, 230, 60, 60))
        cv2.rectangle(
            frame, (int(x), int(y)), (int(x + w), int(y + h)), random.integers(30, 220, 3).tolist(), -1
        )
    moved = cv2.warpAffine(
        frame, np.float32([[1, 0, shift], [0, 1, shift / 2]]), (320, 240), borderMode=cv2.BORDER_REFLECT
    )
    return noisy(moved * gain, index)


def watch(frames, masks=None):
    health = CameraHealth("cam1", every=5)
    out = [
        health.update(index, frame, np.zeros(frame.shape[:2], np.uint8) if masks is None else masks[index])
        for index, frame in enumerate(frames)
    ]
    return health, out


def test_a_camera_that_stood_still():
    frames = [big_scene(index) for index in range(50)]
    for index, frame in enumerate(frames):  # half of the picture is somebody who walks
        frame[:, 2 * index : 2 * index + 120] = (index, 50, 200 - index)
    health, _ = watch(frames)
    assert health.moved_at is None
    assert health.warnings == []


def test_noise_is_no_light_switch():
    health, _ = watch([noisy(big_scene(), 100 + index, 15.0) for index in range(30)])
    assert health.warnings == []


@pytest.mark.parametrize(("shift", "said"), [(2, "by about 2 pixels"), (90, "by a lot")])
def test_a_camera_that_moved(shift, said):
    health, _ = watch([big_scene(index, shift if index >= 22 else 0) for index in range(60)])
    assert health.moved_at == 25
    moved = [remark for remark in health.warnings if "the camera moved" in remark]
    assert said in moved[0]
    assert "frame 25" in moved[0]


def test_a_light_switch_is_blanked_and_reported():
    masks = np.zeros((30, 240, 320), np.uint8)
    masks[:, 100:140, 100:140] = 1
    masks[15:19] = 1
    health, out = watch([big_scene(index, gain=1.0 if index < 15 else 0.6) for index in range(30)], masks)
    assert health.light_switches == [15]
    assert health.blanked == 4
    assert [mask.any() for mask in out] == [not 15 <= index < 19 for index in range(30)]
    assert "light changed suddenly at frame 15" in health.warnings[0]
    assert "4 of 30 frames" in health.warnings[1]
    assert health.moved_at is None


def boxed(frame):
    """A narrow picture with black beside it, as a phone held upright gives."""
    whole = np.zeros((HEIGHT, 3 * WIDTH, 3), np.uint8)
    whole[:, WIDTH : 2 * WIDTH] = frame
    return whole


def test_another_light_floods_a_picture_that_fills_a_part_of_the_image():
    frames = [noisy(frame_of(index), index) for index in range(60)]
    foreground = Foreground()
    foreground.prime([boxed(frame) for frame in frames[::2]])
    assert foreground.counted is not None
    assert np.array_equal(np.flatnonzero(foreground.counted.all(axis=0)), np.arange(WIDTH, 2 * WIDTH))
    health = CameraHealth()
    health.count(foreground.counted)
    blanked = []
    for index, frame in enumerate(frames):
        bright = np.clip(frame.astype(np.int16) + 60 * (index >= 20), 0, 255).astype(np.uint8)
        image = boxed(bright)
        blanked.append(not health.update(index, image, foreground.apply(image)).any())
    assert not any(blanked[5:20])
    assert blanked[20]
    assert health.light_switches == [20]


def test_before_a_dark_background_all_counts():
    dark = [
        np.where(walkers(index)[..., None], 200, 5).astype(np.uint8) * np.ones(3, np.uint8)
        for index in range(40)
    ]
    foreground = Foreground()
    foreground.prime(dark)
    assert foreground.counted is None


def test_a_light_that_goes_out_is_no_camera_that_moved():
    out = np.full((240, 320, 3), 6, np.uint8)
    health, _ = watch([out if 40 <= index < 90 else big_scene(index) for index in range(120)])
    assert health.moved_at is None
    assert health.numbers["dark"] == 50


def test_the_words_of_a_method_are_one_type():
    """So that a type checker refuses a wrong one, wherever it is given; at run time an error names it."""
    words = ("auto", "mog2", "mixture", "knn", "median")
    assert get_args(ForegroundMethod) == options.METHODS == words
    for owner, name in (
        (ForegroundOptions, "method"),
        (RecordOptions, "foreground"),
        (epibar.calibrate_all, "foreground"),
    ):
        assert inspect.get_annotations(owner)[name] == "ForegroundMethod", owner
    assert inspect.get_annotations(epibar.record)["foreground"] == "ForegroundMethod | ForegroundOptions"
    with pytest.raises(EpibarError, match=r"^foreground method = 'gmm': it must be one of auto, mog2"):
        ForegroundOptions(method="gmm")
    with pytest.raises(EpibarError, match=r"^foreground = 'gmm': it must be one of auto, mog2"):
        RecordOptions(foreground="gmm")
