"""The job of all pairs: the same result on any executor, kept work is reused, failures stay local."""

import json
import multiprocessing
import os
import pickle
import shutil
import sys
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import fields

import numpy as np
import pytest
from jobs_input import FAST, Hasty, Heard, content, write_masks

import epibar
from epibar import Calibration, EpibarError, Recording
from epibar.jobs import dask_executor
from epibar.jobs import tasks as job_tasks


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))


@pytest.fixture(scope="module")
def done(masks, tmp_path_factory):
    """Three cameras, all pairs, by threads of this process."""
    out = tmp_path_factory.mktemp("done")
    return out, epibar.calibrate_all(masks[:3], out, **FAST)


@pytest.fixture
def again(done, tmp_path):
    """A folder in which those three cameras are done."""
    return shutil.copytree(done[0], tmp_path / "again")


class Counting(ThreadPoolExecutor):
    """Threads that note what they are given to do."""

    def __init__(self):
        super().__init__(2)
        self.tasks = []

    def submit(self, function, *arguments):
        names = [getattr(argument, "name", "") for argument in arguments[: 2 if len(arguments) > 2 else 1]]
        self.tasks.append("-".join(names))
        return super().submit(function, *arguments)


def run(cameras, out, **options):
    """Run a job; returns its result, the tasks it needed and what it told."""
    heard = Heard()
    with Counting() as executor:
        found = epibar.calibrate_all(cameras, out, executor=executor, watch=heard, **{**FAST, **options})
    return found, sorted(executor.tasks), heard


# --- the same result wherever it is computed ---


def test_there_is_something_to_compare(done):
    out, found = done
    assert sum(calibration.accepted for calibration in found.calibrations.values()) >= 2
    assert json.loads(content(out))["pairs"][1]["F"] is not None
    assert b"seconds" not in content(out)


def test_processes_give_the_same_file(masks, done, tmp_path):
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        epibar.calibrate_all(masks[:3], tmp_path, executor=executor, **FAST)
    assert content(tmp_path) == content(done[0])


def test_the_order_of_completion_does_not_matter(masks, done, tmp_path):
    class Backwards(Executor):
        """Does the latest task first."""

        def __init__(self):
            self.waiting = []
            self.timer = None

        def submit(self, function, *arguments):
            future = Future()
            self.waiting.append((future, function, arguments))
            if self.timer is None:
                self.timer = threading.Timer(0.3, self.work)
                self.timer.start()
            return future

        def work(self):
            while self.waiting:
                future, function, arguments = self.waiting.pop()
                future.set_result(function(*arguments))
            self.timer = None

    epibar.calibrate_all(masks[:3], tmp_path, executor=Backwards(), **FAST)
    assert content(tmp_path) == content(done[0])


def test_a_pair_starts_as_soon_as_both_its_recordings_are_there(masks, tmp_path):
    started, last_may_go = [], threading.Event()

    class Held(ThreadPoolExecutor):
        def submit(self, function, *arguments):
            return super().submit(self.held, function, arguments)

        def held(self, function, arguments):
            names = [one.name for one in arguments if hasattr(one, "name")]
            if names == ["cam3"]:
                assert last_may_go.wait(60)
            started.append("-".join(names))
            if names == ["cam1", "cam2"]:
                last_may_go.set()
            return function(*arguments)

    with Held(4) as executor:
        epibar.calibrate_all(masks[:3], tmp_path, executor=executor, **FAST)
    assert started.index("cam1-cam2") < started.index("cam3")


def test_a_recording_and_its_file_say_the_same(done):
    out, found = done
    recording = pickle.loads(pickle.dumps(found.recordings["cam1"]))
    kept = Recording.load(out / "recordings" / "cam1.npz")
    for one in (recording, kept):
        assert one.name == "cam1"
        assert np.array_equal(one.barcodes, found.recordings["cam1"].barcodes)
        assert np.array_equal(one.heat, found.recordings["cam1"].heat)


# --- what is kept ---


def test_a_second_run_does_nothing(masks, done, again):
    found, tasks, heard = run(masks[:3], again)
    assert tasks == []
    assert content(again) == content(done[0])
    assert "3 of 3 recordings, 3 of 3 pairs" in heard.notes[0]
    assert found.calibrations.keys() == done[1].calibrations.keys()


def test_a_camera_more_does_only_what_is_missing(masks, again, tmp_path):
    _, tasks, heard = run(masks, again)
    assert tasks == ["cam1-cam4", "cam2-cam4", "cam3-cam4", "cam4"]
    assert "3 of 4 recordings, 3 of 6 pairs" in heard.notes[0]
    epibar.calibrate_all(masks, tmp_path / "whole", **FAST)
    assert content(again) == content(tmp_path / "whole")


def test_an_interrupted_run_goes_on(masks, done, tmp_path):
    class OnePair(Executor):
        """Does all recordings and one pair, and leaves the others waiting."""

        paired = False

        def submit(self, function, *arguments):
            future = Future()
            if not (self.paired and function is job_tasks.calibrate_pair):
                self.paired = self.paired or function is job_tasks.calibrate_pair
                future.set_result(function(*arguments))
            return future

    with pytest.raises(KeyboardInterrupt):
        epibar.calibrate_all(masks[:3], tmp_path, executor=OnePair(), watch=Hasty(), **FAST)
    assert len(json.loads(content(tmp_path))["pairs"]) == 1
    _, tasks, _ = run(masks[:3], tmp_path)
    assert len(tasks) == 2
    assert not {"cam1", "cam2", "cam3"} & set(tasks)
    assert content(tmp_path) == content(done[0])


def test_threads_that_are_interrupted_lose_nothing(masks, done, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        epibar.calibrate_all(masks[:3], tmp_path, watch=Hasty(), **FAST)
    kept = len(json.loads(content(tmp_path))["pairs"])
    assert kept >= 1  # others may have ended while the first was told
    _, tasks, _ = run(masks[:3], tmp_path)
    assert sum("-" in task for task in tasks) == 3 - kept
    assert len(tasks) <= 3
    assert not {"cam1", "cam2"} <= set(tasks)
    assert content(tmp_path) == content(done[0])


def test_an_interruption_while_reusing_loses_nothing(masks, done, again):
    class Impatient(Heard):
        def note(self, text):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        epibar.calibrate_all(masks[:3], again, watch=Impatient(), **FAST)
    assert content(again) == content(done[0])


def test_a_changed_video_is_recorded_again(masks, again, tmp_path):
    moved = [shutil.copy2(path, tmp_path) for path in masks[:3]]
    run(moved, again)
    os.utime(moved[1], ns=(1, 1))
    _, tasks, _ = run(moved, again)
    assert tasks == ["cam1-cam2", "cam2", "cam2-cam3"]


def test_other_options_are_other_results(masks, again):
    pairs = ["cam1-cam2", "cam1-cam3", "cam2-cam3"]
    assert run(masks[:3], again, upright=False)[1] == pairs
    assert run(masks[:3], again, essential=False)[1] == pairs
    assert run(masks[:3], again, lines=1000)[1] == sorted([*pairs, "cam1", "cam2", "cam3"])


def test_fresh_does_everything_again(masks, done, again):
    _, tasks, _ = run(masks[:3], again, fresh=True)
    assert len(tasks) == 6
    assert content(again) == content(done[0])


def test_damaged_files_are_made_again(masks, done, again):
    for name in ("recordings/cam1.npz", "pairs/cam2_cam3.npz"):
        path = again / name
        path.write_bytes(path.read_bytes()[:-200])
    _, tasks, heard = run(masks[:3], again)
    assert tasks == ["cam1", "cam2-cam3"]
    assert "cam1.npz" in heard.warnings[0]
    assert "cam2_cam3.npz" in heard.warnings[1]
    assert content(again) == content(done[0])
    assert run(masks[:3], again)[1] == []


def test_missing_pictures_and_points_are_made_again(masks, again):
    expected = {name: (again / name).read_bytes() for name in ("cam1_cam2.png", "cam1_cam3_frontier.csv")}
    for name in expected:
        (again / name).unlink()
    assert run(masks[:3], again)[1] == []
    assert {name: (again / name).read_bytes() for name in expected} == expected


def test_names_that_would_share_a_file(masks, tmp_path):
    cameras = dict(zip(("a_b", "c", "a", "b_c"), masks, strict=True))
    found = epibar.calibrate_all(cameras, tmp_path, **FAST)
    files = [pair["picture"] for pair in found.content["pairs"]]
    assert len(set(files)) == 6
    assert len(list((tmp_path / "pairs").iterdir())) == 6


# --- what can go wrong ---


def test_a_bad_camera_does_not_stop_the_others(masks, done, tmp_path):
    found, _, heard = run([*masks[:2], "nowhere.npz", masks[2]], tmp_path)
    assert list(found.calibrations) == list(done[1].calibrations)
    assert [error["camera"] for error in found.errors] == ["nowhere"]
    assert "nowhere.npz" in heard.errors[0]


def test_a_bug_is_raised_after_the_rest_is_done(masks, tmp_path, monkeypatch):
    def broken(a, b, *_):
        if (a.name, b.name) == ("cam1", "cam2"):
            raise ZeroDivisionError("a bug")
        return right(a, b, *_)

    right = job_tasks.calibrate_pair
    monkeypatch.setattr("epibar.jobs.runner.calibrate_pair", broken)
    with pytest.raises(ZeroDivisionError):
        run(masks[:3], tmp_path)
    result = json.loads(content(tmp_path))
    assert [(pair["a"], pair["b"]) for pair in result["pairs"]] == [("cam1", "cam3"), ("cam2", "cam3")]
    assert "a bug" in result["errors"][0]["message"]


def test_a_broken_executor_keeps_what_is_done(masks, tmp_path):
    class Failing(Counting):
        def submit(self, function, *arguments):
            if function is job_tasks.calibrate_pair:
                raise BrokenProcessPool("a child process terminated abruptly")
            return super().submit(function, *arguments)

    with Failing() as executor, pytest.raises(EpibarError, match=r"terminated abruptly.*goes on"):
        epibar.calibrate_all(masks[:2], tmp_path, executor=executor, **FAST)
    _, tasks, _ = run(masks[:2], tmp_path)
    assert tasks == ["cam1-cam2"]


def test_a_file_that_cannot_be_replaced_is_named(masks, tmp_path):
    run(masks[:2], tmp_path)
    (tmp_path / "cam1_cam2.png").unlink()
    (tmp_path / "cam1_cam2.png").mkdir()
    found, _, heard = run(masks[:3], tmp_path, seed=1)
    assert list(found.calibrations) == [("cam1", "cam3"), ("cam2", "cam3")]
    assert "cam1 - cam2: " in heard.errors[0]
    assert "cam1_cam2.png: cannot be removed" in heard.errors[0]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"cameras": ["A"]}, "at least two"),
        ({"cameras": "A"}, "several paths"),
        ({"cameras": ["A", "A"]}, "given twice"),
        ({"cameras": {"x/y": "A", "z": "B"}}, "x/y"),
        ({"background": ["A"]}, "background: 1 given for 2"),
        ({"ignore": "A"}, "ignore: 1 given for 2"),
        ({"method": "magic"}, "magic"),
        ({"foreground": "magic"}, "magic"),
        ({"lines": 0}, "lines"),
        ({"frames": (5, 3)}, "frames 5:3"),
        ({"cameras": ["A", "B", "C"], "time_offset": 3}, "time_offset = 3"),
    ],
)
def test_bad_arguments(options, named, tmp_path):
    arguments = {"cameras": ["A", "B"], **FAST, **options}
    with pytest.raises(EpibarError, match=named):
        epibar.calibrate_all(arguments.pop("cameras"), tmp_path / "out", **arguments)
    assert not (tmp_path / "out").exists()


def test_without_dask(monkeypatch):
    monkeypatch.setitem(sys.modules, "dask", None)
    with pytest.raises(EpibarError, match=r"epibar\[dask\]"), dask_executor("local"):
        pass


# --- a saved calibration ---


def flat(value):
    """Everything in a calibration as plain Python values and exact arrays."""
    if hasattr(value, "__dataclass_fields__"):
        return {field.name: flat(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, dict):
        return {key: flat(item) for key, item in value.items()}
    return [flat(item) for item in value] if isinstance(value, (list, tuple)) else value


def test_a_saved_calibration_comes_back_exactly(done, tmp_path):
    for calibration in done[1].calibrations.values():
        calibration.save(tmp_path / "pair.npz")
        assert flat(Calibration.load(tmp_path / "pair.npz")) == flat(calibration)
    kept = Calibration.load(done[0] / "pairs" / "cam1_cam2.npz")
    assert flat(kept) == flat(done[1].calibrations["cam1", "cam2"])


def test_rivals_and_a_missing_F_come_back_too(done, tmp_path):
    values = {
        field.name: getattr(done[1].calibrations["cam1", "cam3"], field.name) for field in fields(Calibration)
    }
    rival = {"F": np.arange(9.0).reshape(3, 3) / 7, "distance": 0.1, "source": "floor"}
    odd = Calibration(
        **{**values, "F": None, "expected_error": None, "floor": np.eye(3) / 3, "rivals": [rival]}
    )
    odd.save(tmp_path / "odd.npz")
    assert flat(Calibration.load(tmp_path / "odd.npz")) == flat(odd)


def test_what_is_no_calibration(done, masks, tmp_path):
    for path in (done[0] / "recordings" / "cam1.npz", masks[0]):
        with pytest.raises(EpibarError, match=r"not a calibration"):
            Calibration.load(path)
    with pytest.raises(EpibarError, match="no such file"):
        Calibration.load(tmp_path / "none.npz")
    arrays = dict(np.load(done[0] / "pairs" / "cam1_cam3.npz"))
    np.savez(tmp_path / "short.npz", **{**arrays, "candidates.inliers": arrays["candidates.inliers"][:-1]})
    with pytest.raises(EpibarError, match=r"short.npz: damaged \(candidates.inliers"):
        Calibration.load(tmp_path / "short.npz")
    del arrays["candidates.lines_a"]
    np.savez(tmp_path / "less.npz", **arrays)
    with pytest.raises(EpibarError, match="lines_a is missing"):
        Calibration.load(tmp_path / "less.npz")


@pytest.mark.parametrize(
    ("lengths", "said"),
    [
        ({"distances": [("cam1", "hall", 4.2)]}, "no camera 'hall'"),
        ({"camera_heights": [("hall", 2.6)]}, "no camera 'hall'"),
        ({"camera_heights": [("cam1", -2.6)]}, "camera_height"),
        ({"person_height": "tall"}, "person_height"),
    ],
)
def test_lengths_of_no_use_are_refused_before_anything_is_recorded(masks, tmp_path, lengths, said):
    with pytest.raises(EpibarError, match=said):
        epibar.calibrate_all(masks, tmp_path / "out", **FAST, **lengths)
    assert not (tmp_path / "out" / "recordings").exists()
