"""Pictures are taken while a video is recorded, and no frame is decoded for them afterwards."""

import pickle
from collections import Counter

import cv2
import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.cli import main
from epibar.files.archive import read_archive, write_archive
from epibar.foreground.options import ForegroundOptions
from epibar.sources.picture_taking import BUDGET, MOST, RUNS, PicturePlan, PictureTaker
from epibar.sources.pictures import Pictures, decoded

FRAMES, SIZE = 300, (320, 240)
WORDS = ["--lines", "3000", "--method", "lines", "--quiet"]


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """Videos of two cameras, and of the empty scene as each sees it."""
    folder = tmp_path_factory.mktemp("videos")
    scene = synthetic.people(seed=5, cameras=2, walkers=4, frames=FRAMES, size=SIZE, asymmetric=True)
    videos = [
        synthetic.render_video(scene, index, folder / f"cam{index + 1}.avi", empty_frames=0)
        for index in range(2)
    ]
    empty = synthetic.people(seed=5, cameras=2, walkers=0, frames=20, size=SIZE, asymmetric=True)
    clips = [synthetic.render_video(empty, index, folder / f"empty{index + 1}.avi") for index in range(2)]
    return [str(path) for path in videos], [str(path) for path in clips]


@pytest.fixture
def decoded_frames(monkeypatch):
    """How many frames OpenCV decoded, by the stem of the video, since the test began."""
    count, capture = Counter(), cv2.VideoCapture

    class Counting:
        def __init__(self, path):
            self._capture, self._stem = capture(path), path.rpartition("/")[2].partition(".")[0]

        def read(self):
            ok, frame = self._capture.read()
            count[self._stem] += ok
            return ok, frame

        def grab(self):
            ok = self._capture.grab()
            count[self._stem] += ok
            return ok

        def __getattr__(self, name):
            return getattr(self._capture, name)

    monkeypatch.setattr(cv2, "VideoCapture", Counting)
    return count


def images_in(out):
    text = (out / "report.html").read_text()
    return text.count("data:image/jpeg;base64,")


# --- decoded once ---


def test_a_run_decodes_each_frame_once_and_the_next_run_none(filmed, decoded_frames, tmp_path):
    videos, clips = filmed
    words = ["calibrate", *videos, "--background", *clips, "--out", str(tmp_path / "out"), *WORDS]
    assert main(words) in (0, 1)
    assert decoded_frames["cam1"] == decoded_frames["cam2"] == FRAMES
    pictures = images_in(tmp_path / "out")
    assert pictures >= 2 * 16
    decoded_frames.clear()
    assert main(words) in (0, 1)
    assert not decoded_frames
    assert images_in(tmp_path / "out") == pictures


def test_only_the_empty_scene_costs_more_than_one_pass(filmed, decoded_frames, tmp_path):
    """Without a clip of the empty scene it is learned from frames of the video, before the first of them."""
    videos, _ = filmed
    epibar.record(videos[0], lines=100)
    alone = decoded_frames["cam1"]
    assert FRAMES < alone <= 2 * FRAMES
    decoded_frames.clear()
    assert main(["calibrate", *videos, "--out", str(tmp_path / "out"), *WORDS]) in (0, 1)
    assert decoded_frames == {"cam1": alone, "cam2": alone}
    assert images_in(tmp_path / "out") >= 2 * 16


# --- which frames ---


def taken(frames, fps, motion=lambda index: 1 + index % 7, announced=True):
    blank, pixels = np.zeros((9, 16, 3), np.uint8), np.arange(1000)[None]
    taker = PictureTaker(frames if announced else None, fps)
    for index in range(frames):
        taker.look(index, index / fps, (pixels < motion(index)).astype(np.uint8), lambda: blank)
    return taker.pictures()


@pytest.mark.parametrize(
    ("seconds", "fps_a", "fps_b"), [(12, 25, 25), (40, 25, 30), (60, 30, 30), (200, 50, 25)]
)
def test_whatever_the_offset_both_cameras_have_pictures_of_some_moments(seconds, fps_a, fps_b):
    rng = np.random.default_rng(0)
    busy = rng.integers(1, 1000, 20_000)
    a = taken(seconds * fps_a, fps_a, lambda index: int(busy[index]))
    b = taken(seconds * fps_b, fps_b, lambda index: int(busy[-index]))
    assert PicturePlan.of(seconds, fps_a).runs >= 2
    for offset in rng.uniform(0, min(5, seconds / 4), 40):
        shown = [frame for frame in a if round((frame / fps_a + offset) * fps_b) in b]
        assert len(shown) >= min(RUNS, PicturePlan.of(seconds, fps_a).runs), offset
    together = [frame for frame in a if round(frame / fps_a * fps_b) in b]
    assert len(together) >= 16


@pytest.mark.parametrize("announced", [True, False])
@pytest.mark.parametrize(("frames", "fps"), [(1, 25), (50, 25), (18_000, 30), (100_000, 5), (30_000, 1000)])
def test_there_are_never_many(frames, fps, announced):
    most = MOST if announced else MOST * 3 // 2
    assert 1 <= len(taken(frames, fps, announced=announced)) <= most + 2


def test_a_picture_of_noise_is_not_large():
    rng = np.random.default_rng(0)
    taker, mask = PictureTaker(4, 1.0), np.ones((9, 16), np.uint8)
    for index in range(4):
        taker.look(index, float(index), mask, lambda: rng.integers(0, 256, (1080, 1920, 3), dtype=np.uint8))
    assert all(len(jpeg) <= BUDGET for jpeg in taker.pictures().values())


def test_runs_are_where_much_moves():
    pictures = taken(3000, 25, lambda index: 500 if 1130 <= index < 1200 else 1)
    assert sum(1130 <= frame < 1200 for frame in pictures) >= 20


def test_pictures_are_of_the_frames_they_claim(tmp_path):
    """Also where the first frames are left out; the brightness tells the frame."""
    (tmp_path / "cam").mkdir()
    for index in range(120):
        image = np.full((48, 64, 3), 2 * index, np.uint8)
        image[10:20, index // 3 : index // 3 + 8] = 255 - 2 * index
        cv2.imwrite(str(tmp_path / "cam" / f"{index:04d}.png"), image)
    recording = epibar.record(tmp_path / "cam", lines=50, frames=(15, None), pictures=True)
    assert recording.frames == 105
    assert len(recording.pictures) > 20
    for frame, jpeg in recording.pictures.items():
        assert abs(np.median(decoded(jpeg)) - 2 * (frame + 15)) <= 1.5


def test_taking_pictures_changes_no_recording(filmed):
    plain, with_pictures = (epibar.record(filmed[0][0], lines=500, pictures=asked) for asked in (False, True))
    assert plain.pictures is None
    assert len(with_pictures.pictures) > 0
    arrays, others = plain.to_arrays(), with_pictures.to_arrays()
    assert arrays.keys() == others.keys()
    assert all(np.array_equal(arrays[name], others[name]) for name in arrays)


# --- where they are kept ---


def test_a_saved_recording_holds_no_image(filmed, tmp_path):
    recording = epibar.record(
        filmed[0][0], lines=100, pictures=True, foreground=ForegroundOptions(background=filmed[1][0])
    )
    recording.save(tmp_path / "cam1.npz")
    assert epibar.Recording.load(tmp_path / "cam1.npz").pictures is None
    assert b"\xff\xd8\xff" not in b"".join(
        array.tobytes()
        for array in read_archive(tmp_path / "cam1.npz", "").values()
        if array.dtype.kind != "U"
    )
    again = pickle.loads(pickle.dumps(recording))
    assert dict(again.pictures) == dict(recording.pictures)


def test_a_run_goes_on_without_its_pictures(filmed, tmp_path, capsys):
    videos, clips = filmed
    out = tmp_path / "out"
    words = ["calibrate", *videos, "--background", *clips, "--out", str(out), *WORDS[:-1]]
    code = main(words)
    before = (out / "calibration.json").read_bytes()
    kept = sorted((out / "pictures").iterdir())
    assert [path.name for path in kept] == ["cam1.npz", "cam2.npz"]
    kept[0].unlink()
    kept[1].write_bytes(b"no archive")
    (out / "cam1_cam2.png").unlink()
    capsys.readouterr()
    assert main(words) == code
    assert "cam2.npz: not pictures kept by epibar, or damaged; silhouettes" in capsys.readouterr().err
    assert images_in(out) == 2  # the heat maps of the cards
    assert (out / "cam1_cam2.png").exists()
    assert (out / "calibration.json").read_bytes() == before


@pytest.mark.parametrize(
    "change",
    [
        {"frames": np.array([-1, 4])},
        {"frames": np.array([4, 3])},
        {"frames": np.array([0.0, 1.0])},
        {"starts": np.array([0, 2, 9])},
        {"starts": np.array([0, 4])},
        {"starts": np.array([0, 0, 8])},
        {"bytes": np.zeros(8, np.uint8)},
        {"bytes": np.zeros((8, 1), np.uint8)},
        {"epibar_pictures": np.array(2)},
    ],
)
def test_pictures_that_cannot_be(change, tmp_path):
    jpeg = b"\xff\xd8\xff\xe0"
    pictures = Pictures({3: jpeg, 0: jpeg})
    assert list(pictures) == [0, 3]
    arrays = pictures.to_arrays()
    assert dict(Pictures.from_arrays(arrays, "file")) == dict(pictures)
    write_archive(tmp_path / "file.npz", {**arrays, **change})
    with pytest.raises(epibar.EpibarError, match=r"file\.npz: "):
        Pictures.from_arrays(read_archive(tmp_path / "file.npz", "pictures"), str(tmp_path / "file.npz"))
