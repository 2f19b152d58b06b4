"""A part of a video: the same frames, whatever the kind of source, counted from the first of them."""

import cv2
import numpy as np
import pytest

import epibar
from epibar.errors import EpibarError
from epibar.sources.colour_frames import ColourFrames
from epibar.sources.frame_range import FrameRange
from epibar.sources.mask_frames import MaskFrames

COUNT = 30


def grey_of(index):
    return 20 + 7 * index


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sources")
    writer = cv2.VideoWriter(str(folder / "v.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10, (32, 24))
    (folder / "images").mkdir()
    for index in range(COUNT):
        frame = np.full((24, 32, 3), grey_of(index), np.uint8)
        writer.write(frame)
        cv2.imwrite(str(folder / "images" / f"{index}.png"), frame)
    writer.release()
    return [folder / "v.avi", folder / "images"]


@pytest.mark.parametrize(
    ("ends", "expected"),
    [((0, 7), range(7)), ((12, 20), range(12, 20)), ((25, None), range(25, 30)), ((28, 99), range(28, 30))],
)
def test_frames_of_a_part(sources, ends, expected):
    for path in sources:
        with ColourFrames(path, fps=10, frames=FrameRange(*ends)) as frames:
            assert (frames.first, frames.frame_count) == (ends[0], len(expected))
            for _ in range(2):
                found = list(frames)
                assert [index for index, _, _ in found] == list(range(len(expected)))
                assert np.allclose([time for _, time, _ in found], np.arange(len(expected)) / 10)
                greys = [frame.mean() for _, _, frame in found]
                assert np.allclose(greys, [grey_of(index) for index in expected], atol=2)
            assert not frames.warnings
            sampled = [frame.mean() for frame in frames.sample(3)]
            assert grey_of(expected[0]) - 2 <= min(sampled)
            assert max(sampled) <= grey_of(expected[-1]) + 2


def test_long_parts_are_sampled_by_seeking(sources):
    with ColourFrames(sources[0], frames=FrameRange(10, 28)) as frames:
        assert np.allclose([frame.mean() for frame in frames.sample(2)], [grey_of(10), grey_of(27)], atol=2)


def test_masks_of_a_part(sources, tmp_path):
    masks = np.zeros((COUNT, 6, 9), bool)
    masks[np.arange(COUNT), :, np.arange(COUNT) % 9] = True
    np.savez(tmp_path / "m.npz", masks=masks, fps=4.0)
    with MaskFrames(tmp_path / "m.npz", frames=FrameRange(5, 11)) as source:
        found = list(source)
        assert (source.first, source.frame_count, source.truncated) == (5, 6, False)
    assert [time for _, time, _ in found] == [index / 4 for index in range(6)]
    assert np.array_equal(np.stack([mask for *_, mask in found]), masks[5:11])
    with MaskFrames(sources[0], frames=FrameRange(14, 18)) as source:
        assert [bool(mask.any()) for *_, mask in source] == [grey_of(index) > 127 for index in range(14, 18)]
    rec = epibar.record(tmp_path / "m.npz", masks=True, frames=(5, 11), lines=50)
    rec.save(tmp_path / "r.npz")
    rec = epibar.Recording.load(tmp_path / "r.npz")
    assert (rec.frames, rec.first_frame) == (6, 5)
    assert np.array_equal(rec.heat, masks[5:11].sum(axis=0))


@pytest.mark.parametrize(
    ("ends", "message"),
    [
        ((5, 5), "frames 5:5: no frame is in it"),
        ((-1, 5), "no frame is in it"),
        ((0.5, 5), "0.5 is not a whole number"),
        ((1, 2, 3), "expected two numbers"),
        ((40, 50), r"frames 40:50 asked for, but it has only 30 frames"),
    ],
)
def test_bad_parts(sources, ends, message):
    with pytest.raises(EpibarError, match=message):
        epibar.record(sources[0], frames=ends)


def test_a_video_that_ends_before_the_part(sources, tmp_path):
    data = sources[0].read_bytes()
    (tmp_path / "cut.avi").write_bytes(data[: len(data) // 2])
    with (
        pytest.raises(EpibarError, match=r"cut\.avi: frames 28: asked for, but it "),
        ColourFrames(tmp_path / "cut.avi", frames=FrameRange(28)) as frames,
    ):
        list(frames)
