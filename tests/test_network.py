"""Networks of cameras: the whole job from recordings, and what is refused."""

import math

import numpy as np
import pytest
from network_input import FRAMES, LINES, calibrated, recordings, situation

import epibar
from epibar import EpibarError, KnownCamera, Recording, synthetic
from epibar.network import ClockOffsets, find_offsets, join_pairs, pairs_to_search, search_pairs

# --- the whole job ---


def test_nothing_known_but_the_recordings():
    net = calibrated()
    assert net.accepted, net.reason
    assert net.unit == "baseline"
    assert list(net.cameras) == ["cam1", "cam2", "cam3"]
    one, other = net.cameras["cam1"], net.cameras["cam2"]
    assert np.linalg.norm(one.position - other.position) == pytest.approx(1)
    truth = {f"cam{k + 1}": camera for k, camera in enumerate(situation().cameras[:3])}
    found = {truth[name].name: camera for name, camera in synthetic.accepted_cameras(net).items()}
    for name, error in synthetic.network_errors(situation(), found).items():
        assert abs(error.focal) < 0.02, name
        assert error.rotation < 1, name
        assert error.position < 0.01, name
    for name, camera in net.cameras.items():
        assert camera.accepted
        assert camera.matrix.shape == camera.rotation.shape == (3, 3)
        assert camera.distortions.shape == (5,)
        assert camera.translation.shape == (3,)
        assert np.linalg.det(camera.rotation) == pytest.approx(1)
        assert camera.expected.keys() == {"focal", "rotation", "position"}
        assert 0 < camera.expected["rotation"] < 2
        axes = 2.5 * np.sqrt(np.linalg.eigvalsh(camera.position_covariance))
        assert axes[2] / 2.5 < camera.expected["position"] < np.linalg.norm(axes)
        # z is up: cameras hang above the floor, and look across it.
        assert camera.position[2] > 0
        assert (camera.rotation @ [0, 0, 1])[1] < 0
        assert net.clocks[name].offset == pytest.approx(0, abs=0.02)
    assert net.clocks["cam1"].offset == 0


def test_pairs_are_in_undistorted_pixels():
    net, made = calibrated(), situation()
    cameras = synthetic.accepted_cameras(net)
    for (a, b), pair in net.pairs.items():
        assert pair.accepted
        assert pair.status == "confirmed"
        assert np.linalg.norm(pair.F) == pytest.approx(1)
        assert np.array_equal(net.pairs[b, a].F, pair.F.T)
        assert (net.pairs[b, a].a, net.pairs[b, a].b) == (b, a)
        i, j = (int(name[-1]) - 1 for name in (a, b))
        x, y = made.correspondences(i, j, lens=True)
        straight = cameras[a].undistort(x), cameras[b].undistort(y)
        assert epibar.symmetric_epipolar_distance(pair.F, *straight).mean() < 1
    assert list(net.pairs) == [("cam1", "cam2"), ("cam1", "cam3"), ("cam2", "cam3")]
    with pytest.raises(KeyError):
        net.pairs["cam1", "nobody"]


def test_people_and_a_distance_agree_on_metres():
    net, made = calibrated(), situation()
    baseline = float(np.linalg.norm(made.cameras[0].centre - made.cameras[1].centre))
    metres = net.scaled(distance=("cam1", "cam2", baseline), person_height=1.72)
    assert metres.unit == "metre"
    off = metres.ground.height / 1.72
    assert 0.9 < off < 1.1


def test_two_cameras_of_unknown_focal_length():
    two = {name: one for name, one in recordings().items() if name != "cam3"}
    net = epibar.calibrate_network(two)
    assert not net.accepted
    assert "two cameras" in net.reason
    assert net.cameras["cam1"].matrix is None
    assert net.cameras["cam1"].status == "too_few"
    assert net.pairs["cam1", "cam2"].F is None
    assert net.clocks["cam2"].offset is None


def test_two_cameras_of_known_matrix():
    made = situation()
    known = {f"cam{k + 1}": KnownCamera(matrix=made.cameras[k].K, distortions=np.zeros(5)) for k in range(2)}
    told = []
    net = epibar.calibrate_network(
        [Recording(recordings()[name]._core, name=name) for name in known],
        time_offset=0.0,
        known=known,
        distances=[("cam1", "cam2", 3.0)],
        progress=lambda stage, share: told.append((stage, share)),
    )
    assert net.accepted, net.reason
    assert net.unit == "metre"
    np.testing.assert_allclose(net.cameras["cam2"].matrix, made.cameras[1].K, rtol=1e-12)
    assert net.cameras["cam2"].distortions.tolist() == [0] * 5
    assert net.clocks["cam2"].offset == 0
    assert {stage for stage, _ in told} == {"pairs", "network"}
    assert all(0 <= share <= 1 for _, share in told)


def test_join_pairs_takes_refused_pairs_and_leaves_a_camera_out():
    films = dict(recordings())
    offsets = find_offsets(list(films.values()), 10.0)
    assert offsets.together
    none = join_pairs(films, {}, offsets)
    assert not none.accepted
    assert none.left_out == ["cam1", "cam2", "cam3"]
    with pytest.raises(EpibarError, match="order of the recordings"):
        join_pairs(films, {("cam2", "cam1"): object()}, offsets)
    with pytest.raises(EpibarError, match="nobody"):
        join_pairs(films, {("cam1", "nobody"): object()}, offsets)
    with pytest.raises(EpibarError, match="2 clocks for 3"):
        join_pairs(films, {}, ClockOffsets((0.0, 0.0)))


def test_stages_by_hand_make_the_same_network():
    films = recordings()
    offsets = find_offsets(films, 10.0)
    assert offsets == find_offsets(list(films.values()), 10.0)
    told = []
    chosen = pairs_to_search(films, offsets)
    assert chosen == [(0, 1), (0, 2), (1, 2)]
    pairs = search_pairs(films, chosen, offsets, seed=3, progress=lambda *at: told.append(at))
    assert list(pairs) == [("cam1", "cam2"), ("cam1", "cam3"), ("cam2", "cam3")]
    assert {stage for stage, _ in told} == {"pairs"}
    assert sorted(set(told)) == [("pairs", done / 3) for done in range(4)]
    whole_told = []
    whole = epibar.calibrate_network(
        films, seed=3, search_seconds=10.0, progress=lambda *at: whole_told.append(at)
    )
    for told_of in told, whole_told:
        for stage in {stage for stage, _ in told_of}:
            shares = [share for name, share in told_of if name == stage]
            assert shares == sorted(shares), stage
    by_hand = join_pairs(films, pairs, offsets)
    assert by_hand.reason == whole.reason
    for name, camera in whole.cameras.items():
        assert by_hand.cameras[name].status == camera.status
        np.testing.assert_array_equal(by_hand.cameras[name].matrix, camera.matrix)


def test_search_pairs_names_what_it_cannot_search():
    films = recordings()
    known = ClockOffsets((0.0, 0.0, 0.0), given=True)
    for chosen in [(1, 0)], [(0, 3)], [(-1, 1)], [("cam1", "cam2")], [(0, 1, 2)], [3]:
        with pytest.raises(EpibarError, match="places a < b of the 3 cameras"):
            search_pairs(films, chosen, known)
    with pytest.raises(EpibarError, match="cam1 and cam3: nothing tells the offset"):
        search_pairs(films, [(0, 2)], ClockOffsets((0.0, 0.0, math.nan)))
    for stage in (
        lambda clocks: pairs_to_search(films, clocks),
        lambda clocks: search_pairs(films, [], clocks),
    ):
        with pytest.raises(EpibarError, match="2 clocks for 3"):
            stage(ClockOffsets((0.0, 0.0)))
        with pytest.raises(EpibarError, match="offsets is a float, expected ClockOffsets"):
            stage(0.0)
    for wrong, named in (
        (7, "recordings is a int"),
        ({"cam1": "cam1.npz"}, r"recordings\['cam1'\] is a str"),
    ):
        with pytest.raises(EpibarError, match=named):
            find_offsets(wrong, 10.0)
        with pytest.raises(EpibarError, match=named):
            pairs_to_search(wrong, known)
    with pytest.raises(EpibarError, match="no name of a camera") as refused:
        find_offsets({"rtsp://me:secret@hall/1": "cam1.npz"}, 10.0)
    assert "secret" not in str(refused.value)


# --- what is refused ---


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"time_offset": math.nan}, "time_offset = nan"),
        ({"time_offset": "soon"}, "soon"),
        ({"time_offset": 2.0}, "does not say whose"),
        ({"time_offset": {"cam1": 0, "cam2": math.nan, "cam3": 0}}, r"time_offset\['cam2'\] = nan"),
        ({"time_offset": {"cam1": 0, "cam2": 1}}, "no camera cam3"),
        ({"time_offset": {"cam1": 0, "cam2": 1, "cam3": 1, "cam9": 1}}, "cam9"),
        ({"search_seconds": 0}, "search_seconds"),
        ({"seed": -1}, "seed"),
        ({"distances": ("cam1", "nobody", 2.0)}, "nobody"),
        ({"distances": [("cam1", "cam2")]}, "expected"),
        ({"distances": ("cam1", "cam1", 2.0)}, "are one"),
        ({"distances": ("cam1", "cam2", -2.0)}, "positive"),
        ({"distances": ("cam1", "cam2", math.inf)}, "positive"),
        ({"person_height": 0}, "person_height"),
        ({"camera_heights": [("cam7", 2.6)]}, "cam7"),
        ({"camera_heights": ("cam1", 0.0)}, "camera_height"),
        ({"known": {"nobody": KnownCamera()}}, "nobody"),
        ({"known": {"cam1": 700.0}}, "KnownCamera"),
        ({"known": {"cam1": KnownCamera(focal=-1)}}, "cam1: focal"),
        ({"known": {"cam1": KnownCamera(aspect="wide")}}, "cam1: aspect"),
        ({"known": {"cam1": KnownCamera(matrix=np.eye(4))}}, "cam1: matrix"),
        ({"known": {"cam1": KnownCamera(matrix=[[700, 5, 320], [0, 700, 240], [0, 0, 1]])}}, "skew"),
        ({"known": {"cam1": KnownCamera(distortions=[0.1, 0, 0.05, 0, 0])}}, "p1 and p2"),
        ({"known": {"cam1": KnownCamera(distortions=[0.1])}}, "1 distortions"),
        ({"known": {"cam1": KnownCamera(principal_point=[1, math.nan])}}, "principal_point"),
    ],
)
def test_bad_arguments(options, named):
    with pytest.raises(EpibarError, match=named):
        epibar.calibrate_network(recordings(), **options)


def test_bad_recordings():
    films = list(recordings().values())
    for given, named in (
        ({"cam1": films[0]}, "at least two"),
        ({"cam1": films[0], "cam2": "cam2.mp4"}, "cam2"),
        ([films[0], films[0]], "its own name"),
        ([films[0], 3], r"recordings\[1\]"),
        (films[0], "expected recordings"),
        ("cam1.mp4", "expected recordings"),
    ):
        with pytest.raises(EpibarError, match=named):
            epibar.calibrate_network(given)
    flat = Recording(films[0]._core, matrix=situation().cameras[0].K)
    with pytest.raises(EpibarError, match="lens taken out"):
        epibar.calibrate_network(
            {"cam1": flat, "cam2": films[1], "cam3": films[2]}, known={"cam1": KnownCamera(focal=700)}
        )


# --- clocks that are not known ---


def test_three_cameras_started_apart():
    """Each is found against the first, and pairs and network agree on it."""
    made, first = situation(), (20, 0, 60)
    fps = made.clocks[0].fps
    films = {
        f"cam{k + 1}": Recording.from_masks(made.masks(k, start, start + 450), fps=fps, lines=LINES, seed=k)
        for k, start in enumerate(first)
    }
    net = epibar.calibrate_network(films, search_seconds=8.0)
    assert net.accepted, net.reason
    for k, start in enumerate(first):
        assert net.clocks[f"cam{k + 1}"].offset == pytest.approx((first[0] - start) / fps, abs=0.1 / fps)


def test_two_cameras_started_apart():
    """The second filmed two seconds longer before."""
    made, late = situation(), 2.0
    fps = made.clocks[0].fps
    skip = round(late * fps)
    known = {f"cam{k + 1}": KnownCamera(matrix=made.cameras[k].K) for k in range(2)}
    films = {
        "cam1": Recording.from_masks(made.masks(0, skip, FRAMES), fps=fps, lines=LINES),
        "cam2": Recording.from_masks(made.masks(1, 0, FRAMES - skip), fps=fps, lines=LINES, seed=1),
    }
    net = epibar.calibrate_network(films, known=known, search_seconds=4.0)
    assert net.accepted, net.reason
    assert net.clocks["cam2"].offset == pytest.approx(skip / fps, abs=0.1 / fps)
