"""Reading videos, folders and arrays, good ones and damaged ones."""

import subprocess
import sys
import threading

import cv2
import numpy as np
import pytest

from epibar.errors import EpibarError
from epibar.sources.colour_frames import ColourFrames
from epibar.sources.frame_range import FrameRange
from epibar.sources.mask_frames import MaskFrames
from epibar.sources.prefetch import prefetched
from epibar.sources.source import DEFAULT_FPS

WIDTH, HEIGHT, COUNT = 96, 64, 40


def grey_of(index):
    return 20 + 5 * index


@pytest.fixture
def write_video(tmp_path):
    """Write a video whose frame i has the grey level ``grey_of(i)``."""

    def write(name, fourcc="mp4v", count=COUNT, fps=30.0, size=(WIDTH, HEIGHT)):
        path = tmp_path / name
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*fourcc), fps, size)
        assert writer.isOpened()
        for index in range(count):
            writer.write(np.full((size[1], size[0], 3), grey_of(index), np.uint8))
        writer.release()
        return path

    return write


@pytest.mark.parametrize(("name", "fourcc"), [("a.mp4", "mp4v"), ("b.avi", "MJPG")])
def test_video(write_video, name, fourcc):
    with ColourFrames(write_video(name, fourcc)) as frames:
        assert (frames.name, frames.size, frames.fps, frames.frame_count) == (
            name[0],
            (WIDTH, HEIGHT),
            30,
            COUNT,
        )
        for _ in range(2):  # a source can be read again
            read = [(index, time, frame.mean()) for index, time, frame in frames]
            assert [index for index, _, _ in read] == list(range(COUNT))
            assert np.allclose([time for _, time, _ in read], np.arange(COUNT) / 30, atol=1e-3)
            assert np.allclose([mean for *_, mean in read], [grey_of(i) for i in range(COUNT)], atol=4)
        assert not frames.warnings
        assert not frames.truncated


def test_given_fps_wins(write_video):
    with ColourFrames(write_video("a.mp4"), fps=10) as frames:
        assert [time for _, time, _ in frames][:3] == [0.0, 0.1, 0.2]
    with pytest.raises(EpibarError, match="fps is -1"):
        ColourFrames(write_video("a.mp4"), fps=-1)


def test_sample_is_spread_over_the_video(write_video):
    with ColourFrames(write_video("a.avi", "MJPG")) as frames:
        means = [frame.mean() for frame in frames.sample(5)]
        assert np.allclose(means, [grey_of(i) for i in (0, 9, 19, 29, 39)], atol=3)
        assert 5 <= len(list(frames.sample(30))) <= COUNT
        assert len(list(frames)) == COUNT


def test_folder_in_natural_order(tmp_path):
    for index in (2, 10, 1):
        cv2.imwrite(str(tmp_path / f"frame{index}.png"), np.full((8, 12, 3), index, np.uint8))
    (tmp_path / "notes.txt").write_text("not an image")
    (tmp_path / ".frame0.png").write_bytes(b"hidden")
    with ColourFrames(tmp_path) as frames:
        assert [frame[0, 0, 0] for _, _, frame in frames] == [1, 2, 10]
        assert (frames.name, frames.size, frames.frame_count) == (tmp_path.name, (12, 8), 3)
        assert frames.fps == DEFAULT_FPS
        assert "no frame rate" in frames.warnings[0]
        assert len(list(frames.sample(2))) == 2
    with ColourFrames(tmp_path / "frame1.png", fps=5) as one:  # not the start of a sequence
        assert [frame[0, 0, 0] for _, _, frame in one] == [1]
        assert not one.warnings


def test_size_change_in_a_folder(tmp_path):
    cv2.imwrite(str(tmp_path / "1.png"), np.zeros((8, 12), np.uint8))
    cv2.imwrite(str(tmp_path / "2.png"), np.zeros((12, 8), np.uint8))
    with pytest.raises(EpibarError, match=r"2.png: 8x12, but the frames before it are 12x8"):
        list(ColourFrames(tmp_path))


def test_unusable_files(tmp_path, write_video):
    with pytest.raises(EpibarError, match=r"none.mp4: no such file"):
        ColourFrames(tmp_path / "none.mp4")
    (tmp_path / "empty.mp4").touch()
    with pytest.raises(EpibarError, match=r"empty.mp4: the file is empty"):
        ColourFrames(tmp_path / "empty.mp4")
    (tmp_path / "text.mp4").write_text("hello\n" * 1000)
    with pytest.raises(EpibarError, match=r"text.mp4: not a video"):
        ColourFrames(tmp_path / "text.mp4")
    whole = write_video("whole.mp4").read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(EpibarError, match=r"cut.mp4: not a video"):
        ColourFrames(tmp_path / "cut.mp4")
    with pytest.raises(EpibarError, match=r"none.avi: not"):
        ColourFrames(write_video("none.avi", "MJPG", count=0))
    (tmp_path / "folder").mkdir()
    with pytest.raises(EpibarError, match="no png, jpg, tif or bmp"):
        ColourFrames(tmp_path / "folder")
    (tmp_path / "folder" / "1.png").write_bytes(b"no image")
    with pytest.raises(EpibarError, match=r"1.png: not an image"):
        ColourFrames(tmp_path / "folder")
    np.save(tmp_path / "masks.npy", np.zeros((2, 3, 4), np.uint8))
    with pytest.raises(EpibarError, match="array of masks"):
        ColourFrames(tmp_path / "masks.npy")


def test_truncated_video_keeps_what_was_decoded(write_video):
    path = write_video("cut.avi", "MJPG")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with ColourFrames(path) as frames:
        announced = frames.frame_count
        decoded = len(list(frames))
        assert 0 < decoded < COUNT
        if announced == COUNT:
            assert frames.truncated
            assert f"decoded {decoded} of {COUNT}" in frames.warnings[0]
        assert frames.frame_count == decoded


def test_announced_frames_that_are_missing(write_video):
    with ColourFrames(write_video("a.mp4")) as frames:
        frames._announced = 2 * COUNT
        list(frames)
        assert frames.truncated
        assert "truncated, decoded 40 of 80 frames" in frames.warnings[0]


@pytest.mark.parametrize("announced", [0.0, float("nan"), -1.0, float("inf")])
def test_no_usable_frame_rate(write_video, announced):
    with ColourFrames(write_video("a.mp4")) as frames:
        frames._choose_fps(announced)
        assert frames.fps == DEFAULT_FPS
        assert "25 frames per second assumed" in frames.warnings[0]


def squares(count=5):
    masks = np.zeros((count, 6, 9), bool)
    for index in range(count):
        masks[index, 1:3, index : index + 2] = True
    return masks


@pytest.mark.parametrize("scale", [1, 255])
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_mask_archive(tmp_path, scale, save):
    masks = squares()
    save(tmp_path / "m.npz", masks=masks.astype(np.uint8) * np.uint8(scale), fps=4.0)
    with MaskFrames(tmp_path / "m.npz") as source:
        assert (source.name, source.size, source.fps, source.frame_count) == ("m", (9, 6), 4.0, 5)
        for index, time, mask in source:
            assert time == index / 4
            assert mask.dtype == np.uint8
            assert np.array_equal(mask, masks[index])
        assert not source.warnings


def test_bool_masks_without_rate(tmp_path):
    np.save(tmp_path / "m.npy", squares())
    with MaskFrames(tmp_path / "m.npy") as source:
        assert np.array_equal(np.stack([mask for *_, mask in source]), squares())
        assert source.fps == DEFAULT_FPS
        assert len(source.warnings) == 1


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"mask": squares()}, "no key 'masks'.*mask"),
        ({"masks": squares()[0]}, r"key 'masks' has shape \(6, 9\)"),
        ({"masks": squares()[..., None]}, r"key 'masks' has shape \(5, 6, 9, 1\)"),
        ({"masks": squares().astype(float)}, "key 'masks' has dtype float64"),
        ({"masks": squares().astype(object)}, "key 'masks' has dtype object"),
        ({"masks": squares()[:0]}, "no frames"),
        ({"masks": np.asfortranarray(squares())}, "Fortran"),
    ],
)
def test_bad_mask_archives(tmp_path, arrays, message):
    np.savez(tmp_path / "m.npz", **arrays)
    with pytest.raises(EpibarError, match=r"m\.npz: .*" + message):
        MaskFrames(tmp_path / "m.npz")


def test_damaged_mask_files(tmp_path):
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(EpibarError, match=r"text.npz: not a numpy archive"):
        MaskFrames(tmp_path / "text.npz")
    with pytest.raises(EpibarError, match=r"none.npz: no such file"):
        MaskFrames(tmp_path / "none.npz")
    np.save(tmp_path / "m.npy", squares())
    data = (tmp_path / "m.npy").read_bytes()
    (tmp_path / "m.npy").write_bytes(data[: -2 * 54 - 1])
    with MaskFrames(tmp_path / "m.npy") as source:
        assert len(list(source)) == 2
        assert source.truncated
        assert "read 2 of 5" in source.warnings[-1]


@pytest.mark.parametrize("white", [1, 255])
def test_mask_folder(tmp_path, white):
    masks = squares()
    for index, mask in enumerate(masks):
        cv2.imwrite(str(tmp_path / f"{index}.png"), mask.astype(np.uint8) * white)
    with MaskFrames(tmp_path, fps=5) as source:
        assert np.array_equal(np.stack([mask for *_, mask in source]), masks)
        assert not source.warnings


def test_masks_too_dark_to_count(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), squares()[0].astype(np.uint8) * 5)
    with MaskFrames(tmp_path, fps=5) as source:
        assert not any(mask.any() for *_, mask in source)
        assert "brighter than 127 (the brightest is 5)" in source.warnings[0]


def test_a_colour_video_is_not_one_of_masks(tmp_path):
    rng = np.random.default_rng(0)
    for index in range(12):
        cv2.imwrite(str(tmp_path / f"{index:02}.png"), rng.integers(40, 180, (30, 40, 3), np.uint8))
    with MaskFrames(tmp_path, fps=5) as source:
        assert len(list(source)) == 12
        (told,) = source.warnings
    assert "not black and white" in told
    assert "without --masks" in told


def test_mask_video_threshold(write_video):
    with MaskFrames(write_video("m.avi", "MJPG")) as source:
        found = np.array([mask.mean() for *_, mask in source])
    expected = np.array([grey_of(i) for i in range(COUNT)]) > 127
    assert np.array_equal(
        found[np.abs(np.arange(COUNT) - 21.5) > 2] > 0.5, expected[[*range(20), *range(24, COUNT)]]
    )


def test_prefetch_keeps_order_and_errors():
    assert list(prefetched(range(100), depth=3)) == list(range(100))

    def failing():
        yield 1
        raise EpibarError("frame 1 is damaged")

    ahead = prefetched(failing())
    assert next(ahead) == 1
    with pytest.raises(EpibarError, match="damaged"):
        next(ahead)
    with pytest.raises(EpibarError, match="depth"):
        next(prefetched([], depth=0))


def test_abandoned_prefetch_stops_its_thread():
    before = threading.active_count()
    ahead = prefetched(iter(range(10**9)), depth=2)
    assert next(ahead) == 0
    ahead.close()
    assert threading.active_count() == before


def run(code):
    path = [entry for entry in sys.path if entry]
    command = [sys.executable, "-c", f"import sys; sys.path = {path!r}\n{code}"]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def test_opencv_is_imported_late():
    done = run("import epibar.sources, epibar.foreground, epibar.lens; print('cv2' in sys.modules)")
    assert done.stdout == "False\n"


def test_opencv_does_not_chatter(tmp_path, write_video):
    whole = write_video("whole.mp4").read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])
    done = run(
        f"from epibar.sources.colour_frames import ColourFrames; ColourFrames({str(tmp_path / 'cut.mp4')!r})"
    )
    assert "EpibarError" in done.stderr
    assert "moov" not in done.stderr


def test_the_last_frame_of_a_file_that_breaks_off_is_sampled_once(write_video):
    """Seeks beyond what is there give it again and again: the background was learned mostly from it."""
    with ColourFrames(write_video("a.mp4")) as frames:
        frames.frame_count = 20 * COUNT
        found = [frame.tobytes() for frame in frames.sample(60)]
    assert len(set(found)) >= 0.9 * COUNT
    assert max(found.count(frame) for frame in found) <= 4


def test_of_a_part_no_other_frames_are_sampled(write_video, monkeypatch):
    """A seek goes by the mean rate, and where that varies to a frame outside the part."""

    class Unsought:
        def __init__(self, capture):
            self.capture = capture

        def set(self, what, value):
            raise AssertionError(f"a seek to {value}")

        def __getattr__(self, name):
            return getattr(self.capture, name)

    monkeypatch.setattr("epibar.sources.colour_frames.NEAR", 1)
    with ColourFrames(write_video("a.avi", "MJPG"), frames=FrameRange(10, 39)) as frames:
        used = {frame.tobytes() for _, _, frame in frames}
        opened = frames._capture
        monkeypatch.setattr(frames, "_capture", lambda: Unsought(opened()))
        found = [frame.tobytes() for frame in frames.sample(5)]
    assert len(found) == 5
    assert used.issuperset(found)


def test_images_that_are_missing_between_others_are_told(tmp_path):
    for number in (1, 2, 3, 5, 6, 9):
        cv2.imwrite(str(tmp_path / f"f_{number:04d}.png"), np.zeros((24, 32, 3), np.uint8))
    with ColourFrames(tmp_path, fps=25) as frames:
        assert "the numbers of 3 images are missing" in frames.warnings[0]
    for name in ("a.png", "take2_0001.png"):
        cv2.imwrite(str(tmp_path / name), np.zeros((24, 32, 3), np.uint8))
    with ColourFrames(tmp_path, fps=25) as frames:
        assert frames.warnings == []
