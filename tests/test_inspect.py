"""What `inspect` says about one camera: every condition made on purpose, none where there is none."""

from __future__ import annotations

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.cli import main
from epibar.errors import EpibarError
from epibar.health.camera_findings import camera_findings
from epibar.health.camera_health import CameraHealth
from epibar.health.camera_motion import CameraMotion
from epibar.health.inspection import cause_of_refusal
from epibar.sources.colour_frames import ColourFrames

FRAMES = 240
SIZE = (320, 240)
DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="module")
def frames():
    scene = synthetic.people(seed=4, cameras=2, walkers=5, frames=FRAMES, size=SIZE)
    return list(synthetic.render_frames(scene, 0, seed=4, empty_frames=0))


def write(video, path):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25, SIZE)
    for frame in video:
        writer.write(frame)
    writer.release()
    return path


@pytest.fixture
def filmed(tmp_path):
    """Write frames as a video and record that."""
    return lambda video, **options: epibar.record(write(video, tmp_path / "cam1.avi"), lines=3000, **options)


@pytest.fixture(scope="module")
def door(frames, tmp_path_factory):
    """The video of a camera that moved, and the file it was recorded to."""
    moved = frames[:100] + [shifted(frame, 60) for frame in frames[100:]]
    video = write(moved, tmp_path_factory.mktemp("door") / "door.avi")
    epibar.record(video, lines=3000).save(video.with_suffix(".npz"))
    return video, video.with_suffix(".npz")


def watched(video):
    """What is found about the camera and the light alone, by kind."""
    health, nothing = CameraHealth(), np.zeros(SIZE[::-1], np.uint8)
    for index, frame in enumerate(video):
        health.update(index, frame, nothing)
    return {finding.kind: finding.text for finding in camera_findings(health.numbers)}


def shifted(frame, x, y=0.0):
    matrix = np.float32([[1, 0, x], [0, 1, y]])
    return cv2.warpAffine(frame, matrix, SIZE, borderMode=cv2.BORDER_REFLECT)


def kinds(diagnosis):
    return [finding.kind for finding in diagnosis.findings]


def told(diagnosis, kind):
    (finding,) = (finding for finding in diagnosis.findings if finding.kind == kind)
    return finding.text


# --- the camera and the light ---


def test_a_sound_camera(frames, filmed):
    rec = filmed(frames)
    seen = epibar.inspect(rec)
    assert seen.findings == ()
    assert seen.sound
    assert rec.health["moves"] == 0
    assert rec.health["motion_checks"] == FRAMES // 10 - 1
    assert rec.health["flicker"] < 1
    assert "nothing wrong was found" in str(seen)
    assert "stood still" in str(seen)


def test_a_camera_that_moved_for_good(frames, filmed):
    rec = filmed(frames[:153] + [shifted(frame, 5, -2) for frame in frames[153:]])
    seen = epibar.inspect(rec)
    text = told(seen, "moved")
    assert not seen.sound
    assert "by about 5 pixels, at or shortly before frame 160, and stayed there until the end" in text
    assert text.endswith("--frames 0:151")
    assert any(text in warning for warning in rec.warnings)
    # What is advised helps.
    assert epibar.inspect(filmed(frames[:153], frames=(0, 151))).sound


def test_frame_numbers_are_those_of_the_video(frames, filmed):
    rec = filmed(frames[:103] + [shifted(frame, 6) for frame in frames[103:]], frames=(50, 220))
    assert (rec.frames, rec.first_frame) == (170, 50)
    assert rec.health["moved_at"] == 110
    assert told(epibar.inspect(rec), "moved").endswith("--frames 110:220")


def test_a_camera_that_moved_and_came_back(frames):
    away = [shifted(frame, 8) if 63 <= index < 155 else frame for index, frame in enumerate(frames)]
    assert "was back by frame 160" in watched(away)["moved"]


def test_a_camera_that_moved_twice(frames):
    twice = [shifted(frame, 8 * (index >= 63) + 8 * (index >= 105)) for index, frame in enumerate(frames)]
    text = watched(twice)["moved"]
    assert "1 times more later" in text
    assert text.endswith(f"--frames 110:{FRAMES}")


def test_a_camera_that_drifts(frames):
    found = watched([shifted(frame, 0.04 * index) for index, frame in enumerate(frames)])
    assert list(found) == ["drift"]
    (far,) = (int(word) for word in found["drift"].split("pixels")[0].split() if word.isdigit())
    assert 4 <= far <= 10  # 9.6 pixels in all, seen in steps of more than one


def test_a_camera_that_shakes(frames):
    found = watched([shifted(frame, 4 * (index % 30 == 10)) for index, frame in enumerate(frames)])
    assert list(found) == ["shaken"]


@pytest.mark.parametrize("period", [2.7, 4.0])
def test_flickering_light(frames, period):
    gains = 1 + 0.05 * np.sin(2 * np.pi * np.arange(FRAMES) / period)
    lit = [cv2.convertScaleAbs(frame, alpha=gain) for frame, gain in zip(frames, gains, strict=True)]
    assert "shutter" in watched(lit)["flicker"]


def test_bands_of_a_rolling_shutter(frames):
    rows = np.arange(SIZE[1])[:, None, None]
    lit = [
        np.clip(frame * (1 + 0.06 * np.sin(rows / 20 + 2.1 * index)), 0, 255).astype(np.uint8)
        for index, frame in enumerate(frames)
    ]
    assert "flicker" in watched(lit)
    assert "light" not in watched(lit)


def test_slow_light_is_no_flicker(frames):
    fading = [cv2.convertScaleAbs(frame, alpha=1 - 0.2 * i / FRAMES) for i, frame in enumerate(frames)]
    assert watched(fading) == {}


def test_a_frozen_camera(frames):
    found = watched(frames[:150] + [frames[150]] * 90)
    assert list(found) == ["frozen"]
    assert "the frames 150 to 239 are one and the same" in found["frozen"]


def test_a_covered_lens(frames):
    random = np.random.default_rng(0)
    black = [random.integers(5, 9, frame.shape, np.uint8) for frame in frames[:180]]
    assert "is the lens covered" in watched(black + frames[180:])["dark"]


def test_flooded_frames(frames, filmed):
    lit = [cv2.add(frame, 90) if index % 12 == 5 else frame for index, frame in enumerate(frames)]
    seen = epibar.inspect(filmed(lit))
    assert "20 of 240 frames" in told(seen, "flooded")
    assert not seen.sound
    assert seen.flooded_frames == pytest.approx(20 / FRAMES)
    assert "light" in kinds(seen)


def test_nothing_moves(frames, filmed):
    empty = [cv2.add(frames[0], int(index % 3)) for index in range(60)]
    seen = epibar.inspect(filmed(empty))
    assert "nothing moves" in told(seen, "no_motion")
    assert seen.lines["crossed"] == 0
    assert math.isnan(seen.straightness)


# --- what moves ---


def of_scene(camera=0, lines=3000, **options):
    scene = synthetic.people(seed=1, cameras=2, **{"frames": 400, **options})
    return epibar.Recording.from_masks(scene.masks(camera), lines=lines, name="hall")


@pytest.fixture(scope="module")
def eight():
    return of_scene()


def test_lines_left_after_each_filter(eight):
    seen = epibar.inspect(eight)
    assert list(seen.lines) == ["drawn", "crossed", "free", "informative", "off_paths"]
    assert seen.lines["drawn"] == 3000
    assert seen.lines["informative"] == eight.informative
    assert sorted(seen.lines.values(), reverse=True) == list(seen.lines.values())
    assert seen.sound
    assert seen.health == {}
    assert "no images were seen" in str(seen)


def test_where_it_moves():
    masks = np.zeros((200, 90, 120), bool)
    for index in range(200):
        masks[index, 5:15, 85 + index % 20 : 95 + index % 20] = index % 4 > 0
    seen = epibar.inspect(epibar.Recording.from_masks(masks, lines=500))
    assert seen.where[0, 2] == 1
    assert seen.where.sum() == 1
    assert seen.moving_frames == 0.75
    assert seen.moving_area == pytest.approx(100 / 10800)
    assert seen.spread < 0.04
    assert "small_part" in kinds(seen)
    assert "most in the top right" in str(seen)


def test_everybody_on_one_path():
    seen = epibar.inspect(of_scene(one_path=True))
    assert "one straight path" in told(seen, "one_path")
    assert seen.paths > 0


def test_lines_along_a_path_are_counted_out():
    masks = np.zeros((400, 60, 80), bool)
    for index in np.flatnonzero(np.arange(400) % 20 < 10):
        masks[index, 28:31, index % 70 : index % 70 + 10] = True
    seen = epibar.inspect(epibar.Recording.from_masks(masks, lines=3000))
    assert seen.paths == 1
    # Lines are along it where the area between is below 3 image widths of 80 px: less than 3 px apart.
    assert 0 < seen.lines["informative"] - seen.lines["off_paths"] < 0.1 * seen.lines["informative"]


@pytest.mark.parametrize("camera", [0, 1])
@pytest.mark.parametrize("heights", [synthetic.HIGH_CAMERAS, synthetic.LOW_CAMERAS])
def test_people_who_walk_anywhere_are_not_on_one_path(camera, heights):
    assert "one_path" not in kinds(epibar.inspect(of_scene(camera, camera_height=heights)))


def test_a_crowd_that_leaves_no_line_free():
    random = np.random.default_rng(0)
    masks = np.zeros((200, 60, 80), bool)
    for mask in masks:
        for x, y in random.integers(0, (75, 55), (150, 2)):
            mask[y : y + 5, x : x + 5] = True
    seen = epibar.inspect(epibar.Recording.from_masks(masks, lines=500))
    assert "fewer people" in told(seen, "crowded")
    assert seen.flooded_frames < 0.05


def test_too_little_motion():
    masks = np.zeros((400, 60, 80), bool)
    masks[50:70, 20:40, 30:36] = True
    seen = epibar.inspect(epibar.Recording.from_masks(masks, lines=500))
    assert "something moves in 5% of the frames, and only 0 of 500" in told(seen, "little_motion")


def test_inverted_masks(eight):
    masks = np.ones((120, 60, 80), bool)
    masks[np.arange(120), 20:40, np.arange(120) % 60] = False
    assert "inverted" in told(epibar.inspect(epibar.Recording.from_masks(masks, lines=100)), "flooded")


def test_cut_and_short():
    masks = np.zeros((60, 60, 80), bool)
    for index in range(60):
        masks[index, 30:, index % 40 : index % 40 + 30] = True
    assert {"cut", "short"} <= set(kinds(epibar.inspect(epibar.Recording.from_masks(masks, lines=100))))


def test_the_argument_is_checked():
    with pytest.raises(EpibarError, match="expected a Recording"):
        epibar.inspect("cam1.mp4")


# --- files, verdicts, command line ---


def test_health_is_saved(frames, filmed, door, tmp_path):
    rec = filmed(frames[:60])
    rec.save(tmp_path / "cam1.npz")
    loaded = epibar.Recording.load(tmp_path / "cam1.npz")
    assert loaded.health == rec.health
    assert str(epibar.inspect(loaded)) == str(epibar.inspect(rec))
    with np.load(door[1]) as file:
        arrays = dict(file)
    older = {key: value for key, value in arrays.items() if "health" not in key and key != "first_frame"}
    np.savez(tmp_path / "older.npz", **older)
    loaded = epibar.Recording.load(tmp_path / "older.npz")
    assert loaded.health == {}
    assert "not known" in str(epibar.inspect(loaded))
    arrays["health_values"] = arrays["health_values"][:3]
    np.savez(tmp_path / "damaged.npz", **arrays)
    with pytest.raises(EpibarError, match="damaged"):
        epibar.Recording.load(tmp_path / "damaged.npz")


def test_the_verdict_names_the_camera_at_fault(door, eight):
    moved = epibar.Recording.load(door[1])
    cal = epibar.calibrate(moved, eight, method="lines")
    assert not cal.accepted
    assert "A possible cause: in door the camera moved" in cal.reason
    assert "hall" not in cal.reason
    assert cause_of_refusal("no_common_scene", eight, moved) in cal.reason
    assert cause_of_refusal("accepted", moved, eight) is None
    assert cause_of_refusal("no_common_scene", eight, eight) is None


def test_a_recording_is_inspected_once_for_all_its_pairs(monkeypatch):
    inspected = []

    def counting(recording):
        inspected.append(recording)
        return epibar.inspect(recording)

    monkeypatch.setattr("epibar.health.inspection.inspect", counting)
    still = [epibar.Recording.from_masks(np.zeros((40, 48, 64), bool), lines=50, name=name) for name in "abc"]
    for a, b in ((0, 1), (0, 2), (1, 2)):
        cause = cause_of_refusal("too_little_motion", still[a], still[b])
        assert f"in {'abc'[a]} nothing moves" in cause
        assert f"in {'abc'[b]} nothing moves" in cause
    assert inspected == still


def test_inspect_on_the_command_line(door, eight, tmp_path, capsys):
    eight.save(tmp_path / "hall.npz")
    words = ["inspect", str(door[0]), str(tmp_path / "hall.npz"), "--lines", "3000"]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "PROBLEM   the camera moved" in text
    assert text.count("informative") == 2
    assert main([*words[:2], "--frames", "0:90", "--lines", "3000"]) == 0
    text = capsys.readouterr().out
    assert "90 frames" in text
    assert "PROBLEM" not in text
    assert main([*words, "--background", "one.png"]) == 2
    assert main([*words[:1], words[2], "--frames", "0:90"]) == 2
    assert "recorded already" in capsys.readouterr().err


def test_inspect_for_programs(door, tmp_path, capsys):
    assert main(["inspect", str(door[1]), str(tmp_path / "none.mp4"), "--json"]) == 3
    captured = capsys.readouterr()

    def refuse(word):
        raise AssertionError(f"{word} in the output")

    (entry,) = json.loads(captured.out, parse_constant=refuse)
    assert (entry["name"], entry["sound"], entry["frames"]) == ("door", False, FRAMES)
    assert entry["findings"][0]["kind"] == "moved"
    assert np.shape(entry["where"]) == (3, 3)
    assert "none.mp4" in captured.err


def test_inspect_masks(tmp_path, capsys):
    masks = np.zeros((150, 60, 80), np.uint8)
    masks[np.arange(150), 20:30, np.arange(150) % 70] = 1
    np.savez(tmp_path / "m.npz", masks=masks, fps=5.0)
    assert main(["inspect", str(tmp_path / "m.npz"), "--masks", "--lines", "200"]) == 0
    assert "150 frames, 29.8 s at 5 frames a second" in capsys.readouterr().out


@pytest.mark.skipif(not DATA.exists(), reason=f"the real recordings are not at {DATA}")
@pytest.mark.parametrize(
    ("video", "moved_at"),
    [
        ("man_at_desk/cam_0.mp4", 50),
        ("man_at_desk/cam_1.mp4", None),
        ("man_at_desk/cam_2.mp4", None),
        ("man_at_desk/cam_3.mp4", None),
        ("hand_over_desk/cam0.mp4", None),
        ("hand_over_desk/cam1.mp4", None),
    ],
)
def test_real_cameras(video, moved_at):
    motion = CameraMotion()
    with ColourFrames(DATA / video) as frames:
        for index, _, frame in frames:
            if index % 10 == 0:
                motion.look(index, frame)
    assert [move.frame for move in motion.moves] == ([] if moved_at is None else [moved_at])
    assert motion.shaken == 0
    if moved_at is not None:
        assert motion.moves[0].distance == pytest.approx(5.1, abs=0.5)
        assert motion.returned_at is None
