"""Pixels that are not square, as old video has them: the file says so, and networks count with it."""

from fractions import Fraction

import numpy as np
import pytest

import epibar
from epibar.network.knowledge import KnownCamera, knowledge_of
from epibar.sources.chapters import colour_frames
from epibar.sources.colour_frames import ColourFrames

SIZE = (64, 48)


def film(path, aspect, frames=20):
    """YUV4MPEG2, whose header says how wide pixels are."""
    width, height = SIZE
    with path.open("wb") as file:
        file.write(f"YUV4MPEG2 W{width} H{height} F25:1 Ip A{aspect} C420jpeg\n".encode())
        for t in range(frames):
            luma = np.full((height, width), 90, np.uint8)
            luma[10:30, 5 + t : 20 + t] = 220
            file.write(b"FRAME\n" + luma.tobytes() + np.full(width * height // 2, 128, np.uint8).tobytes())
    return path


@pytest.mark.parametrize(
    ("said", "found"), [("12:11", 12 / 11), ("10:11", 10 / 11), ("1:1", None), ("0:0", None), ("900:1", None)]
)
def test_a_video_says_how_wide_its_pixels_are(tmp_path, said, found):
    with ColourFrames(film(tmp_path / "cam1.y4m", said)) as frames:
        assert frames.pixel_aspect == (None if found is None else pytest.approx(found))
        assert any("times as wide as high" in text for text in frames.warnings) == (found is not None)


@pytest.mark.parametrize(("turned", "found"), [(0, 12 / 11), (90, 11 / 12), (180, 12 / 11), (270, 11 / 12)])
def test_pixels_of_a_film_that_is_shown_turned_are_turned(tmp_path, turned, found):
    av = pytest.importorskip("av", reason="PyAV is not installed, which writes the video")
    path = tmp_path / "phone.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        (stream.width, stream.height), stream.pix_fmt = SIZE, "yuv420p"
        stream.codec_context.sample_aspect_ratio = Fraction(12, 11)
        if turned:
            stream.set_display_rotation(turned)
        for level in range(5):
            image = np.full((*SIZE[::-1], 3), 40 * level, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, "bgr24")))
        container.mux(stream.encode())
    with ColourFrames(path) as frames:
        assert frames.size == (SIZE if turned % 180 == 0 else SIZE[::-1])
        assert frames.pixel_aspect == pytest.approx(found)


def test_chapters_and_masks_say_so_too(tmp_path):
    for number in (1, 2):
        film(tmp_path / f"cam1_{number}.y4m", "12:11").rename(tmp_path / f"cam1_{number}.avi")
    with colour_frames(tmp_path / "cam1_*.avi", None, None, True) as frames:
        assert frames.pixel_aspect == pytest.approx(12 / 11)
    masks = epibar.record(film(tmp_path / "cam2.y4m", "12:11"), lines=50, masks=True)
    assert masks.pixel_aspect == pytest.approx(12 / 11)


def test_a_recording_keeps_it_and_a_network_counts_with_it(tmp_path):
    wide = epibar.record(film(tmp_path / "cam1.y4m", "12:11"), lines=50)
    assert any("its pixels are 1.09 times as wide as high" in text for text in wide.warnings)
    wide.save(tmp_path / "cam1.npz")
    kept = epibar.Recording.load(tmp_path / "cam1.npz")
    square = epibar.record(film(tmp_path / "cam2.y4m", "1:1"), lines=50)
    assert (kept.pixel_aspect, square.pixel_aspect) == (wide.pixel_aspect, None)
    films = {"cam1": kept, "cam2": square}

    def aspects(known):
        return [one["aspect"] for one in knowledge_of(films, known)]

    assert aspects(None) == [pytest.approx(12 / 11), None]
    assert aspects({"cam1": KnownCamera(focal=60.0)}) == [pytest.approx(12 / 11), None]
    assert aspects({"cam1": KnownCamera(aspect=1.0)}) == [1.0, None]
    assert aspects({"cam1": KnownCamera(matrix=np.diag([60.0, 66.0, 1.0]))}) == [None, None]
    kept.matrix = np.array([[60.0, 0, 32], [0, 66, 24], [0, 0, 1]])
    assert aspects(None) == [None, None]


def test_how_wide_pixels_are_is_a_positive_number(tmp_path):
    square = epibar.record(film(tmp_path / "cam1.y4m", "1:1"), lines=50)
    for none in (-1.0, 0.0, np.nan, "12:11"):
        with pytest.raises(epibar.EpibarError, match="pixel_aspect"):
            epibar.Recording(square._core, pixel_aspect=none)
    arrays = square.to_arrays() | {"pixel_aspect": np.array(np.nan)}
    with pytest.raises(epibar.EpibarError, match=r"cam1.npz.*pixel_aspect"):
        epibar.Recording.from_arrays(arrays, "cam1.npz")
