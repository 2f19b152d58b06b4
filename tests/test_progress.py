"""How far a job is: the share never goes back, the time left holds, a row for each camera."""

import types
from itertools import pairwise

import numpy as np
import pytest
from jobs_input import FAST, write_masks
from progress_input import Clock, job_of, simulated

import epibar
from epibar import synthetic
from epibar.jobs import Watch
from epibar.jobs.camera_sizes import frames_and_pixels
from epibar.jobs.inputs import CameraInput, Job, RecordOptions
from epibar.jobs.pace import Pace, played_through
from epibar.jobs.shares import BEGINS, PairShare, joining_share
from epibar.jobs.stages import CLOCKS, MATCHING, NETWORK, RECORDING, Task
from epibar.jobs.tally import Tally, search_rounds, workers_of
from epibar.sources.frame_range import FrameRange

WITHIN = (0.6, 1.6)
STAGES = (("record",), ("clocks",), ("match",), ("join",))


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))


def ratios(looks, first=0.25, last=0.95):
    """Stated over real seconds left."""
    end = looks[-1][0]
    return [left / (end - at) for at, _, left in looks if first * end < at < last * end and left is not None]


def check_shares(looks):
    shares = [share for _, share, _ in looks]
    assert all(before <= after for before, after in pairwise(shares))
    assert shares[-1] == 1.0
    assert all(share < 1.0 for share in shares[:-1])


# --- the estimate ---


@pytest.mark.parametrize("tells", [True, False])
@pytest.mark.parametrize("slower", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("cameras", [[20, 20, 20, 20], [5, 80, 10, 30], [60, 60]])
def test_the_time_left_holds_however_fast_the_machine(cameras, slower, tells):
    looks = simulated(job_of(cameras, slower), tells=tells)
    check_shares(looks)
    found = np.array(ratios(looks))
    assert len(found) > 10
    assert np.mean((found > WITHIN[0]) & (found < WITHIN[1])) > 0.9
    if tells:
        assert np.median(abs(np.log(found))) < np.log(1.15)


def test_tasks_that_differ_from_what_is_thought():
    found = []
    for seed in range(20):
        looks = simulated(job_of([20] * 4, 2.0, spread=0.5, seed=seed))
        check_shares(looks)
        found += ratios(looks)
    assert np.mean([WITHIN[0] < ratio < WITHIN[1] for ratio in found]) > 0.85


def test_it_does_not_jump():
    looks = simulated(job_of([20] * 4, 3.0, spread=0.5))
    stated = [(at, left) for at, _, left in looks if left is not None]
    whole = looks[-1][0]
    for (before, first), (after, last) in pairwise(stated[:-1]):
        assert abs(last - first) < 0.05 * whole + (after - before)


def test_cameras_of_unknown_size_are_like_the_others():
    clock = Clock()
    pace = Pace(STAGES, 1, None, clock)
    pace.expect("record", {"a": None, "b": None})
    pace.started("record", "a")
    clock.now += 20
    assert pace.look({})[1] is None
    pace.ended("a", 20.0)
    pace.started("record", "b")
    clock.now += 5
    assert pace.look({})[1] == pytest.approx(15.0, abs=3.0)


def test_nothing_is_said_before_anything_is_measured():
    clock = Clock()
    pace = Pace(STAGES, 2, None, clock)
    pace.expect("record", {"a": 10.0})
    pace.started("record", "a")
    told = []
    for _ in range(20):
        clock.now += 0.5
        told.append(pace.look({"a": 0.0})[1])
    assert told == [None] * 20
    clock.now += 1
    pace.look({"a": 0.01})
    clock.now += 1
    assert pace.look({"a": 0.1})[1] is not None


def test_what_begins_late_is_not_thought_slow():
    """The empty scene is learned before the first frame counts."""
    clock = Clock()
    pace = Pace((("record",),), 1, None, clock)
    pace.expect("record", {"a": 10.0})
    pace.started("record", "a")
    for tick in range(1, 60):
        clock.now = 1000.0 + tick
        share = max(tick - 40, 0) / 20
        left = pace.look({"a": share})[1]
        if tick > 50:
            assert left == pytest.approx(60 - tick, abs=2.5)


def test_tasks_that_fail_are_no_measure():
    stages = job_of([20] * 4, 2.0)
    stages[2][1].update({f"pair{k}": (11.0, 0.25) for k in range(3)})
    looks = simulated(stages, fails=("pair0", "pair1", "pair2"))
    check_shares(looks)
    at_the_pairs = [left / (looks[-1][0] - at) for at, _, left in looks if 108 < at < 150]
    assert np.mean([WITHIN[0] < ratio < WITHIN[1] for ratio in at_the_pairs]) > 0.9


def test_what_never_begins_is_not_waited_for():
    clock = Clock()
    pace = Pace(STAGES, 1, None, clock)
    pace.expect("record", {"a": 10.0})
    pace.expect("match", {"p": 500.0, "q": 10.0})
    pace.started("record", "a")
    clock.now += 10
    pace.ended("a")
    assert not pace.failed("p")
    clock.now += 1
    assert pace.look({})[1] < 20


def test_played_through():
    alone = [(4.0, 0.0), (2.0, 0.0)]
    assert played_through(alone, [(3.0, 0.0)], 2) == pytest.approx(5.0)
    assert played_through([], [(3.0, 0.0)] * 5, 2) == pytest.approx(9.0)
    assert played_through([(4.0, 1.0), (2.0, 1.0)], [(3.0, 1.0)], 2) == pytest.approx(9.0)
    assert played_through([], [], 3) == 0.0


# --- what tasks tell ---


@pytest.mark.parametrize("rounds", [1, 2, 3])
def test_the_share_of_a_search_never_goes_back(rounds):
    search, shares = PairShare(rounds), [0.0]
    for number in range(rounds + 1):
        for stage in BEGINS:
            for within in (0.0, 0.5):
                shares.append(search.tell(stage, within))
        shares.append(search.tell("time_offset", 0.0))
        assert shares[-1] == pytest.approx(min((number + 0.945) / rounds, 0.98), abs=0.01)
    assert all(before <= after for before, after in pairwise(shares))
    assert shares[-1] < 1.0


def test_a_search_that_ends_early_is_not_said_to_be_nearly_done():
    search = PairShare(1)
    search.tell("candidates", 0.0)
    few = search.tell("few", 1.0)
    told = [search.tell("settle", within) for within in (0.0, 0.5)]
    assert few < 0.3
    assert told == pytest.approx([0.62, 0.81], abs=0.01)
    # Where more hypotheses were drawn little is left when that begins.
    search = PairShare(1)
    for stage in ("candidates", "few", "refine"):
        search.tell(stage, 0.0)
    assert search.tell("settle", 0.0) == pytest.approx(0.89)


def test_shares_of_joining():
    told = [joining_share(share) for share in np.linspace(0, 1, 21)]
    assert told == sorted(told)
    assert told[0] == 0.0
    assert joining_share(0.4) == pytest.approx(0.52)
    assert told[-1] == 1.0


def test_sizes_are_read_without_decoding(masks, tmp_path):
    scene = synthetic.cubes(3, cameras=2, frames=20, size=(64, 48))
    video = synthetic.render_video(scene, 0, tmp_path / "cam.avi", empty_frames=5)
    options = RecordOptions()
    assert frames_and_pixels(CameraInput("a", str(video), 0), options) == (25, 64 * 48)
    part = RecordOptions(frames=FrameRange(5, 15))
    assert frames_and_pixels(CameraInput("a", str(video), 0), part) == (10, 64 * 48)
    ready = RecordOptions(masks=True)
    assert frames_and_pixels(CameraInput("a", str(masks[0]), 0), ready) == (200, 160 * 120)
    (tmp_path / "broken.mp4").write_bytes(b"no video")
    for unknown in ("rtsp://nobody/1", str(tmp_path / "none.mp4"), str(tmp_path / "broken.mp4"), "0"):
        assert frames_and_pixels(CameraInput("a", unknown, 0), options) is None


# --- a tally of a job ---


class Heard(Watch):
    """Keeps what was told."""

    def __init__(self):
        self.paces, self.stages, self.notes = [], [], []

    def pace(self, progress):
        self.paces.append(progress)

    def progress(self, stage, done, total):
        self.stages.append((stage, done, total))

    def note(self, text):
        self.notes.append(text)


def cameras(count):
    return [CameraInput(f"cam{k + 1}", f"cam{k + 1}.mp4", k) for k in range(count)]


def test_a_row_for_each_camera_that_is_recorded(tmp_path):
    clock, heard = Clock(), Heard()
    job = Job(cameras(3), tmp_path)
    tally = Tally(job, heard, 2, together=True, clock=clock)
    tally.plan(job.cameras)
    tasks = [Task(camera) for camera in job.cameras]
    for task in tasks[:2]:
        tally.started(task)
    tally.tell(tasks[:2])
    assert heard.paces[-1].rows == ()
    for frame in range(1, 101):
        clock.now += 0.02
        tasks[0].progress("recording", frame / 400)
        if frame % 10 == 0:
            tally.tell(tasks[:2])
    (row,) = heard.paces[-1].rows
    assert (row.name, row.share) == ("cam1", 0.25)
    assert row.frames_per_second == pytest.approx(50.0)
    assert heard.paces[-1].doing == "recorded 0 of 3 cameras"
    assert heard.stages[-1] == (RECORDING, 0.25, 3)
    tally.ended(tasks[0], (object(), 2.0))
    tally.started(tasks[2])
    tasks[1].progress("recording", 0.5)
    tally.tell(tasks[1:])
    assert [row.name for row in heard.paces[-1].rows] == ["cam2"]
    assert heard.paces[-1].doing == "recorded 1 of 3 cameras"


def test_a_camera_that_fails_takes_its_pairs_along(tmp_path):
    clock, heard = Clock(), Heard()
    job = Job(cameras(3), tmp_path)
    tally = Tally(job, heard, 1, together=True, clock=clock)
    tally.plan(job.cameras)

    def left():
        clock.now += 60
        tally.tell(())
        return heard.paces[-1].seconds_left

    tasks = [Task(camera) for camera in job.cameras]
    for task in tasks[:2]:
        tally.started(task)
        clock.now += 10
        tally.ended(task, (object(), 10.0))
    before = left()
    tally.started(tasks[2])
    tally.failed(job.cameras[2])
    assert left() < 0.6 * before


def test_what_is_kept_is_no_work(tmp_path):
    heard, clock = Heard(), Clock()
    job = Job(cameras(3), tmp_path)
    for name in (
        "recordings/clocks.json",
        "network.json",
        *(f"pairs/cam{k}.npz" for k in ("1_cam2", "1_cam3")),
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    tallies = []
    for pairs in (2, 3):
        (tmp_path / "pairs" / "cam2_cam3.npz").touch() if pairs == 3 else None
        tallies.append(Tally(job, heard, 1, together=True, clock=clock))
        tallies[-1].plan([])
        clock.now += 3
    for tally in tallies:
        tally.tell(())
    one_pair, nothing = (progress.share for progress in heard.paces)
    assert nothing > one_pair


def test_workers_of_an_executor():
    assert workers_of(types.SimpleNamespace(_max_workers=3)) == 3
    assert workers_of(types.SimpleNamespace(workers=5, _max_workers=3)) == 5
    # A cluster whose workers have not come yet.
    assert workers_of(types.SimpleNamespace(workers=0)) == 1
    assert workers_of(types.SimpleNamespace()) >= 1


def test_rounds_of_a_search():
    from epibar.jobs.inputs import PairOptions

    assert search_rounds(PairOptions()) == 3
    assert search_rounds(PairOptions(time_offset=1.5)) == 1
    assert search_rounds(PairOptions(time_offset=1.5, sharpen_offset=True)) == 2


@pytest.mark.parametrize("kept", [0, 2, 4])
def test_a_job_tells_shares_that_never_go_back(kept, masks, tmp_path):
    if kept:
        epibar.calibrate_all(masks[:kept], tmp_path / "out", **FAST)
    heard = Heard()
    epibar.calibrate_all(masks, tmp_path / "out", watch=heard, **FAST)
    shares = [progress.share for progress in heard.paces]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert heard.paces[-1].seconds_left == 0.0
    stages = {stage for stage, _, _ in heard.stages}
    assert stages == ({RECORDING, MATCHING} if kept < 4 else set())


def test_a_job_with_a_network_tells_every_stage(masks, tmp_path):
    heard = Heard()
    usual = {**FAST, "method": "frontier", "time_offset": "auto"}
    epibar.calibrate_all(masks[:3], tmp_path / "out", watch=heard, **usual)
    assert {stage for stage, _, _ in heard.stages} == {RECORDING, CLOCKS, MATCHING, NETWORK}
    said = [progress.doing for progress in heard.paces]
    assert {"comparing clocks", "matched 0 of 3 pairs", "joining all pairs", "writing"} <= set(said)
    assert {row.name for progress in heard.paces for row in progress.rows} <= {"cam1", "cam2", "cam3"}
    assert said[-1] == "done"


def test_cameras_that_cannot_be_recorded(masks, tmp_path):
    heard = Heard()
    epibar.calibrate_all([*masks[:2], tmp_path / "none.npz"], tmp_path / "out", watch=heard, **FAST)
    shares = [progress.share for progress in heard.paces]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_watch_that_knows_nothing_of_it_is_told_the_stages(masks, tmp_path):
    told = []

    class Old(Watch):
        """As users wrote them before."""

        def progress(self, stage, done, total):
            told.append((stage, done, total))

    epibar.calibrate_all(masks[:2], tmp_path / "out", watch=Old(), **FAST)
    assert (MATCHING, 1, 1) in told
