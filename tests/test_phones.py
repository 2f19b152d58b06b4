"""Phones and action cameras: frame rates that vary, frames that are stored turned."""

from fractions import Fraction

import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.sources.colour_frames import ColourFrames

av = pytest.importorskip("av", reason="PyAV is not installed, which writes the videos of these tests")

SIZE = (320, 240)


def volume_error(scene, F):
    """Mean distance of true correspondences, pixels."""
    return epibar.symmetric_epipolar_distance(F, *scene.volume_correspondences(0, 1)).mean()


def write(path, frames, seconds, turned=0):
    """Grey images (T, H, W) as H.264 with B frames, each at its own time; ``turned`` by a flag, degrees."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.height, stream.width = frames[0].shape
        stream.pix_fmt = "yuv420p"
        stream.codec_context.time_base = Fraction(1, 90_000)
        stream.options = {"crf": "10", "bf": "2", "g": "30"}
        if turned:
            stream.set_display_rotation(turned)
        for image, second in zip(frames, seconds, strict=True):
            frame = av.VideoFrame.from_ndarray(np.repeat(image[..., None], 3, axis=2), "bgr24")
            frame.pts, frame.time_base = round(second * 90_000), Fraction(1, 90_000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


# --- frame rates that vary ---


def in_the_dark(length):
    """Times of a phone that films 30 frames a second in the light, 20 in the dark, and drops one at times."""
    rng = np.random.default_rng(2)
    seconds, time = [], 0.0
    while time < length:
        seconds.append(time)
        step = 1 / 20 if int(time / 4) % 2 else 1 / 30
        time += step * (2 if rng.random() < 0.01 else 1) + rng.uniform(-0.002, 0.002)
    return np.array(seconds)


@pytest.mark.parametrize("suffix", ["mp4", "mkv"])
def test_times_are_those_of_the_container(suffix, tmp_path):
    seconds = in_the_dark(10)
    images = np.array([np.full((64, 96), 20 + 2 * (index % 100), np.uint8) for index in range(len(seconds))])
    path = write(tmp_path / f"phone.{suffix}", images, seconds)
    with ColourFrames(path) as frames:
        found = [(index, time, frame.mean()) for index, time, frame in frames]
        assert "rate varies" in " ".join(frames.warnings)
    assert np.allclose([time for _, time, _ in found], seconds, atol=0.001)
    assert np.allclose([mean for *_, mean in found], images[:, 0, 0], atol=6)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """Masks of one scene: the first camera at 25 frames a second, the second as a phone films."""
    folder = tmp_path_factory.mktemp("masks")
    scene = synthetic.people(seed=5, cameras=2, walkers=6, frames=1200, size=SIZE, asymmetric=True)
    steady = np.arange(1000) / 25
    varying = in_the_dark(40)
    paths = [
        write(folder / f"{name}.mp4", 255 * scene.filmed_at(start + seconds, 25.0).masks(camera), seconds)
        for name, camera, start, seconds in (
            ("cam1", 0, 0.0, steady),
            ("cam2", 1, 0.0, steady),
            ("phone", 1, 0.0, varying),
            ("late1", 0, 2.0, varying),
        )
    ]
    recordings = [epibar.record(path, lines=8000, masks=True) for path in paths]
    return scene, dict(zip(("cam1", "cam2", "phone", "late1"), recordings, strict=True)), varying


@pytest.mark.parametrize("time_offset", [0.0, "search"])
def test_a_phone_is_calibrated_like_a_steady_camera(filmed, time_offset):
    scene, recordings, _ = filmed
    steady, varying = (
        epibar.calibrate(recordings["cam1"], recordings[b], time_offset=time_offset)
        for b in ("cam2", "phone")
    )
    assert steady.accepted, steady
    assert varying.accepted, varying
    errors = [volume_error(scene, cal.F) for cal in (steady, varying)]
    assert errors[0] < 1
    assert errors[1] < max(1.3 * errors[0], 0.5), errors
    assert abs(varying.time_offset) < 0.3


def test_two_phones_whose_rates_vary_alike(filmed):
    """Equal intervals on the whole, as of two phones of one kind; but started 2 s apart no number fits."""
    scene, recordings, _ = filmed
    phone, late = recordings["phone"], recordings["late1"]
    assert np.isclose(phone.times[-1], late.times[-1])
    cal = epibar.calibrate(late, phone, time_offset="search", search_seconds=5)
    assert cal.accepted, cal
    assert volume_error(scene, cal.F) < 1
    # Frame k of the first shows the moment 2 s + its own time of the second.
    positions = epibar.clocks.positions_in_b(late, phone, cal)
    there = np.isfinite(positions)
    times = np.interp(positions[there], np.arange(phone.frames), phone.times)
    assert np.abs(times - late.times[there] - 2.0).max() < 0.03


def test_without_its_times_a_phone_does_not_fit(filmed):
    """What a steady rate in place of the container's times costs, so that the tests above would notice."""
    scene, recordings, varying = filmed
    parts = recordings["phone"].to_arrays() | {"core_times": np.linspace(0, varying[-1], len(varying))}
    numbered = epibar.Recording.from_arrays(parts, "phone")
    cal = epibar.calibrate(recordings["cam1"], numbered, time_offset=0.0)
    assert not cal.accepted or volume_error(scene, cal.F) > 2


# --- frames that are stored turned ---


@pytest.mark.parametrize("turned", [0, 90, 180, 270])
def test_frames_are_upright(turned, tmp_path):
    """A white corner stays where a player shows it."""
    upright = np.full((64, 96), 60, np.uint8)
    upright[:16, :16] = 250
    upright[:16, -16:] = 160
    # The flag turns by so much anticlockwise what is stored.
    stored = np.ascontiguousarray(np.rot90(upright, -turned // 90))
    path = write(tmp_path / "phone.mp4", [stored] * 12, np.arange(12) / 30, turned)
    with ColourFrames(path) as frames:
        assert frames.size == (96, 64)
        shown = [frame[..., 1] for *_, frame in frames]
    assert len(shown) == 12
    for image in shown:
        assert np.abs(image.astype(int) - upright).mean() < 3


def test_a_turned_video_is_sampled_and_cut_upright(tmp_path):
    image = np.full((96, 64), 60, np.uint8)
    image[:20] = 250
    path = write(tmp_path / "phone.mp4", [image] * 300, np.arange(300) / 30, 90)
    with ColourFrames(path) as frames:
        for frame in frames.sample(10):
            assert frame.shape == (64, 96, 3)
        for _, _, frame in frames:
            assert frame.shape == (64, 96, 3)
