"""Several files of one camera as one."""

import cv2
import numpy as np
import pytest

import epibar
from epibar.cli import main
from epibar.errors import EpibarError
from epibar.jobs.keys import fingerprint
from epibar.sources.chapters import ChapterFrames, chapter_files, colour_frames
from epibar.sources.frame_range import FrameRange
from epibar.sources.source import source_name

SIZE, FPS = (96, 64), 25.0


def write(path, first, count, size=SIZE, fps=FPS):
    """Frames of grey 2 i, with a bright square that moves, as motion JPEG."""
    path.parent.mkdir(exist_ok=True)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), fps, size)
    for index in range(first, first + count):
        image = np.full((size[1], size[0], 3), 2 * index, np.uint8)
        image[20:40, index // 2 % 70 : index // 2 % 70 + 12] = 255 - 2 * index
        writer.write(image)
    writer.release()
    return path


@pytest.fixture
def camera(tmp_path):
    """Three chapters, of which the tenth comes last, and the same in one file."""
    for name, first, count in (("cam1_8", 0, 40), ("cam1_9", 40, 30), ("cam1_10", 70, 30)):
        write(tmp_path / "cam1" / f"{name}.avi", first, count)
    return tmp_path / "cam1", write(tmp_path / "whole.avi", 0, 100)


def moments(frames):
    with frames:
        return [(index, round(time, 9), int(np.median(frame))) for index, time, frame in frames]


def test_chapters_follow_one_another(camera):
    folder, whole = camera
    expected = moments(colour_frames(whole))
    assert len(expected) == 100
    for path in (folder, folder / "cam1_*.avi", str(folder / "*")):
        frames = ChapterFrames(path)
        assert (frames.size, frames.fps, frames.frame_count, frames.warnings) == (SIZE, FPS, 100, [])
        assert moments(frames) == expected
        assert not frames.truncated


@pytest.mark.parametrize("part", [(0, 40), (39, 41), (55, None), (70, 100), (0, None)])
def test_a_part_of_chapters_is_that_of_the_whole(camera, part):
    folder, whole = camera
    frames = ChapterFrames(folder, frames=FrameRange(*part))
    alone = colour_frames(whole, frames=FrameRange(*part))
    assert frames.frame_count == alone.frame_count
    assert moments(frames) == moments(alone)
    assert np.median(next(iter(frames))[2]) == pytest.approx(2 * part[0], abs=2)


def test_samples_are_spread_over_all_chapters(camera):
    greys = [int(np.median(frame)) for frame in ChapterFrames(camera[0]).sample(10)]
    assert greys == sorted(greys)
    assert len(greys) >= 10
    assert greys[0] <= 8
    assert greys[-1] >= 180
    greys = [int(np.median(frame)) for frame in ChapterFrames(camera[0], frames=FrameRange(75, 85)).sample(5)]
    assert min(greys) >= 148
    assert max(greys) <= 170


def test_a_recording_of_chapters_is_that_of_the_whole(camera):
    folder, whole = camera
    options = {"lines": 300, "background": whole}
    joined, alone = epibar.record(folder, chapters=True, **options), epibar.record(whole, **options)
    assert (joined.name, joined.frames) == ("cam1", 100)
    assert np.allclose(joined.times, alone.times, atol=1e-9)
    assert np.array_equal(joined.barcodes, alone.barcodes)
    assert np.array_equal(joined.heat, alone.heat)


def test_masks_in_chapters(tmp_path):
    for number in range(2):
        write(tmp_path / "cam" / f"m{number}.avi", 64 * number, 60)
    recording = epibar.record(tmp_path / "cam", lines=50, masks=True, chapters=True)
    assert recording.frames == 120


def test_on_the_command_line(camera, tmp_path):
    pattern = str(camera[0] / "cam1_*.avi")
    out = tmp_path / "cam.npz"
    assert main(["record", pattern, "--chapters", "--lines", "50", "--out", str(out), "--quiet"]) == 0
    assert epibar.Recording.load(out).frames == 100
    assert epibar.Recording.load(out).name == "cam1"


def test_without_being_asked_nothing_is_joined(camera, tmp_path, capsys):
    for path in (camera[0], camera[0] / "cam1_*.avi"):
        with pytest.raises(EpibarError, match="give --chapters"):
            epibar.record(path)
    assert main(["record", str(camera[0]), "--out", str(tmp_path / "cam.npz")]) == 2
    assert "--chapters" in capsys.readouterr().err


def test_the_key_changes_with_any_chapter(camera):
    for path in (str(camera[0]), str(camera[0] / "cam1_*.avi")):
        before = fingerprint(path)
        assert before is not None
        write(camera[0] / "cam1_9.avi", 40, 20)
        assert fingerprint(path) not in (None, before)
        write(camera[0] / "cam1_9.avi", 40, 30)


@pytest.mark.parametrize(
    ("names", "order"),
    [
        (["GX020123.MP4", "GX010123.MP4", "GX100123.MP4"], None),
        (["GH020123.MP4", "GH010123.MP4"], ["GH010123.MP4", "GH020123.MP4"]),
        (["a10.mov", "a9.mov", "a11.mov"], ["a9.mov", "a10.mov", "a11.mov"]),
        (["2024_1_b.mp4", "2024_2_b.mp4"], ["2024_1_b.mp4", "2024_2_b.mp4"]),
        (["only.mp4"], ["only.mp4"]),
        (["one.mp4", "two.mp4"], None),
        (["a1b1.mp4", "a2b2.mp4"], None),
        (["a1.mp4", "a3.mp4"], None),
        (["a1.mp4", "a01.mp4"], None),
        (["GX010123.MP4", "GX010124.MP4"], None),
    ],
)
def test_the_order_is_that_of_the_numbers(names, order, tmp_path):
    for name in names:
        (tmp_path / name).touch()
    if order is None:
        with pytest.raises(EpibarError, match=r"no order|are missing|same number|different films"):
            chapter_files(tmp_path)
    else:
        assert [file.name for file in chapter_files(tmp_path)] == order


def test_names_of_patterns():
    assert source_name("films/cam1_*.mp4") == "cam1"
    assert source_name("films/left/*.mp4") == "left"
    assert source_name("films/GX*0123.MP4") == "GX"


def test_what_cannot_be_joined(camera, tmp_path):
    folder = camera[0]
    with pytest.raises(EpibarError, match="nothing to join"):
        chapter_files(tmp_path / "none_*.mp4")
    write(folder / "cam1_11.avi", 0, 5, size=(64, 96))
    with pytest.raises(EpibarError, match=r"cam1_11\.avi: 64x96, but cam1_8\.avi is 96x64"):
        ChapterFrames(folder)
    write(folder / "cam1_11.avi", 0, 5, fps=50)
    with pytest.raises(EpibarError, match=r"cam1_11\.avi: 50 frames per second, but cam1_8\.avi has 25"):
        ChapterFrames(folder)
    (folder / "cam1_11.avi").write_bytes(b"")
    with pytest.raises(EpibarError, match=r"cam1_11\.avi: the file is empty"):
        ChapterFrames(folder)
    (folder / "cam1_11.avi").unlink()
    with pytest.raises(EpibarError, match="frames 100: asked for"):
        moments(ChapterFrames(folder, frames=FrameRange(100)))


def test_a_chapter_that_breaks_off(camera):
    """What follows it would be at nobody knows which time; only the last may break off."""
    files = chapter_files(camera[0])
    for file, wrong in ((files[2], False), (files[0], True)):
        whole = file.read_bytes()
        file.write_bytes(whole[: len(whole) // 2])
        frames = ChapterFrames(camera[0])
        if wrong:
            with pytest.raises(EpibarError, match=r"cam1_8\.avi: it breaks off"):
                moments(frames)
        else:
            assert 70 < len(moments(frames)) < 100
        file.write_bytes(whole)


def test_the_background_is_learned_from_the_seconds_that_are_used(camera):
    """Of 100 frames 45 are used: all of the first chapter, five of the second, none of the third."""
    with ChapterFrames(camera[0], frames=FrameRange(seconds=1.8)) as frames:
        grey = [int(np.median(frame)) // 2 for frame in frames.sample(45)]
    assert max(grey) <= 46
    assert len(grey) >= 40
