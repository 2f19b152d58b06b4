"""Networks of cameras: the whole job from recordings, and what a network that is there can do."""

import json
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from network_input import COVARIANCE, FRAMES, LINES, calibrated, made_up, recordings, situation

import epibar
from epibar import EpibarError, KnownCamera, Network, Recording, synthetic
from epibar.files.json_file import json_text
from epibar.network import ClockOffsets, find_offsets, join_pairs
from epibar.network.calibrating import in_metres
from epibar.network.prose import network_notes

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


# --- metres ---


def test_a_distance():
    net = made_up()
    long = float(np.linalg.norm(net.cameras["cam1"].position - net.cameras["cam2"].position))
    for given in (("cam1", "cam2", 2 * long), [("cam1", "cam2", 2 * long, 0.05)]):
        metres = net.scaled(distance=given)
        assert metres.unit == "metre"
        np.testing.assert_allclose(metres.cameras["cam1"].position, 2 * net.cameras["cam1"].position)
        np.testing.assert_array_equal(metres.cameras["cam1"].rotation, net.cameras["cam1"].rotation)
        assert metres.cameras["cam1"].expected["position"] == pytest.approx(0.004)
        assert metres.cameras["cam1"].expected["rotation"] == 0.2
        np.testing.assert_allclose(metres.cameras["cam1"].position_covariance, 4 * COVARIANCE)
        assert metres.cameras["cam2"].position_covariance is None
        assert metres.cameras["cam4"].translation is None
        assert metres.ground.height == pytest.approx(0.7)
        assert metres.pairs is net.pairs
        assert "between cam1 and cam2" in metres.scale.sources[0]
    assert net.unit == "baseline"
    assert net.scaled(distance=("cam1", "cam2", 2.0)).scale.error == pytest.approx(1.645 * 0.01, rel=0.2)


def test_lengths_are_combined_by_their_accuracy():
    net = made_up()
    both = net.scaled(person_height=1.75, camera_height=("cam2", 4.2, 0.01))
    assert both.cameras["cam2"].position[2] == pytest.approx(4.2, rel=0.01)  # the taller by the tape measure
    assert both.ground.height == pytest.approx(0.35 / 0.8 * 4.2, rel=0.01)
    assert both.scale.error < net.scaled(person_height=1.75).scale.error
    assert len(both.scale.sources) == 2
    # What is scaled already can be scaled again.
    again = both.scaled(person_height=1.75)
    assert again.ground.height == pytest.approx(1.75)


def test_five_metres_known_to_a_centimetre():
    """Half a percent at most, with what is not known of the two places themselves."""
    net = made_up(refused=(), lost=())
    good = net.scaled(distance=("cam1", "cam2", 5.0, 0.01))
    assert 1.645 * 0.002 < good.scale.error < 0.005
    loose = {
        name: replace(one, expected={**one.expected, "position": 0.05}) for name, one in net.cameras.items()
    }
    assert replace(net, cameras=loose).scaled(distance=("cam1", "cam2", 5.0, 0.01)).scale.error > 0.02
    # Three of them say more than one, and people next to nothing beside them.
    given = [(a, b, 5.0 / 2**0.5 * length, 0.01) for a, b, length in net_sides(net)]
    assert net.scaled(distance=given).scale.error < good.scale.error
    both = net.scaled(distance=given[0], person_height=0.35 * 5 / 2**0.5 * 1.05)
    assert both.scale.error == pytest.approx(good.scale.error, rel=0.01)
    assert both.cameras["cam1"].position[2] == pytest.approx(0.8 * 5 / 2**0.5, rel=0.002)


def net_sides(net):
    """Neighbours on the circle, and how far apart."""
    names = [*net.cameras, "cam1"]
    place = {name: camera.position for name, camera in net.cameras.items()}
    return [(a, b, float(np.linalg.norm(place[a] - place[b]))) for a, b in pairwise(names)]


@pytest.mark.parametrize(
    ("ground", "named"),
    [
        ({"breadth": 0.65}, "0.65 times as broad as it is tall"),
        ({"diversity": 0.4}, "differs in height by 40 %"),
    ],
)
def test_what_is_not_people_gives_no_metres(ground, named):
    net = made_up()
    net = replace(net, ground=replace(net.ground, **ground))
    with pytest.raises(EpibarError, match=rf"height of 1.75 m of people says nothing: .*{named}.*distance"):
        net.scaled(person_height=1.75)
    assert net.scaled(distance=("cam1", "cam2", 2.0)).unit == "metre"
    note = next(one for one in network_notes(net) if "unit of length" in one)
    assert "--distance" in note
    assert "--person-height" not in note
    people = replace(net, ground=replace(net.ground, breadth=0.4, diversity=0.08))
    assert people.scaled(person_height=1.75).unit == "metre"
    assert "--person-height" in " ".join(network_notes(people))


def test_a_stature_is_not_measured_better_than_feet_are_seen():
    exact = made_up().scaled(person_height=(1.75, 0.001)).scale.error
    assert 1.645 * 0.012 < exact < made_up().scaled(person_height=1.75).scale.error


def test_the_floor_is_known_to_centimetres(tmp_path):
    net = made_up()
    net = replace(net, ground=replace(net.ground, level_error=0.01))
    metres = net.scaled(person_height=1.75)
    assert metres.ground.level_error == pytest.approx(0.05)
    assert "to 5 cm (standard error)" in " ".join(network_notes(metres))
    assert "standard error)" not in " ".join(network_notes(net)).replace("(standard error 0.2°)", "")
    # A camera's height above a floor that is known so badly says less.
    before = made_up().scaled(camera_height=("cam2", 4.2, 0.01)).scale.error
    assert net.scaled(camera_height=("cam2", 4.2, 0.01)).scale.error > before
    metres.save(tmp_path / "n.json")
    assert epibar.Network.load(tmp_path / "n.json").ground == metres.ground


def test_networks_of_before_have_neither_breadth_nor_level_error(tmp_path):
    path = tmp_path / "n.json"
    made_up().save(path)
    content = json.loads(path.read_text())
    for key in ("breadth", "level_error"):
        del content["ground"][key]
    path.write_text(json.dumps(content))
    net = epibar.Network.load(path)
    assert net.ground.breadth is None
    assert net.scaled(person_height=1.75).unit == "metre"


def test_contradictions_are_named():
    with pytest.raises(EpibarError, match=r"2 m between cam1 and cam2 and the height of 1.75 m of people"):
        made_up().scaled(distance=("cam1", "cam2", 2.0), person_height=1.75)


@pytest.mark.parametrize(
    ("lengths", "named"),
    [
        ({}, "give a distance"),
        ({"distance": ("cam1", "cam3", 2.0)}, "cam3 is not accepted"),
        ({"distance": ("cam1", "cam4", 2.0)}, "cam4 is not accepted"),
        ({"distance": ("cam1", "cam9", 2.0)}, "cam9"),
        ({"distance": 2.0}, "expected"),
        ({"distance": ("cam1", "cam2", 2.0, -1.0)}, "standard error"),
        ({"distance": ("cam1", "cam2", 2.0, 2.0)}, "less than the length itself"),
        ({"camera_height": ("cam1", math.nan)}, "positive"),
        ({"person_height": "tall"}, "person_height"),
    ],
)
def test_lengths_of_no_use(lengths, named):
    with pytest.raises(EpibarError, match=named):
        made_up().scaled(**lengths)


def test_people_say_nothing_without_a_floor():
    net = made_up(floor=False)
    for lengths in ({"person_height": 1.75}, {"camera_height": ("cam1", 2.0)}):
        with pytest.raises(EpibarError, match="no floor was found"):
            net.scaled(**lengths)
    kept = in_metres(net, (), 1.75)
    assert kept.unit == "baseline"
    assert "not in metres" in kept.reason


# --- the file ---


def assert_same(one, other):
    assert (one.accepted, one.reason, one.unit, one.radius) == (
        other.accepted,
        other.reason,
        other.unit,
        other.radius,
    )
    assert (one.ground, one.scale, one.clocks) == (other.ground, other.scale, other.clocks)
    for mine, yours in zip(
        [*one.cameras.values(), *one.pairs.values()],
        [*other.cameras.values(), *other.pairs.values()],
        strict=True,
    ):
        for key, value in vars(mine).items():
            np.testing.assert_array_equal(value, getattr(yours, key), err_msg=key)


@pytest.mark.parametrize("make", [calibrated, made_up, lambda: made_up().scaled(person_height=1.7)])
def test_save_and_load(make, tmp_path):
    net = make()
    net.save(tmp_path / "network.json")
    loaded = Network.load(tmp_path / "network.json")
    assert_same(net, loaded)
    assert isinstance(loaded, Network)
    loaded.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "network.json").read_bytes()


def damaged(change):
    content = json.loads(json_text(made_up().as_dict()))
    change(content)
    return content


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda c: c.pop("epibar_network"), "not a network"),
        (lambda c: c.update(epibar_network=2), "format 2"),
        (lambda c: c.pop("pairs"), "pairs"),
        (lambda c: c.update(cameras={}), "cameras"),
        (lambda c: c.update(cameras=c["cameras"][:1]), "cam1"),
        (lambda c: c.update(unit="inch"), "inch"),
        (lambda c: c.update(accepted="yes"), "accepted"),
        (lambda c: c.update(accepted=True), "does not fit"),
        (lambda c: c.update(reason=""), "reason"),
        (lambda c: c.update(ground=None), "damaged"),
        (lambda c: c["cameras"][0].update(name="cam2"), "cam2, cam2"),
        (lambda c: c["cameras"][0].update(rotation=None), "cam1 has no rotation"),
        (lambda c: c["cameras"][0].update(rotation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]), "cam1: rotation"),
        (lambda c: c["cameras"][0].update(rotation=np.zeros((3, 3)).tolist()), "cam1: rotation"),
        (lambda c: c["cameras"][0].update(translation=[0, 0]), "cam1: translation"),
        (lambda c: c["cameras"][0].update(translation=[0, 0, math.inf]), "Infinity is no number"),
        (lambda c: c["cameras"][0].update(distortions=[0] * 4), "cam1: distortions"),
        (lambda c: c["cameras"][0].update(matrix=[[0] * 3] * 3), "cam1: matrix"),
        (lambda c: c["cameras"][0].update(width=-640), "cam1: size"),
        (lambda c: c["cameras"][0].update(expected={"focal": "small"}), "focal"),
        (
            lambda c: c["cameras"][0].update(position_covariance=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
            "which is none",
        ),
        (lambda c: c["cameras"][0].update(position_covariance=[1, 2, 3]), "cam1: position_covariance"),
        (
            lambda c: c["cameras"][0].update(position_covariance=[[1, 1, 0], [0, 1, 0], [0, 0, 1]]),
            "which is none",
        ),
        (lambda c: c["cameras"][3].update(accepted=True), "cam4 has no matrix"),
        (lambda c: c["cameras"][0].update(clock=None), "damaged"),
        (lambda c: c["pairs"][0].update(F=[1, 2, 3]), "cam1 - cam2: F"),
        (lambda c: c["pairs"][0].update(b="nobody"), "nobody"),
    ],
)
def test_damaged_files(change, named, tmp_path):
    path = tmp_path / "network.json"
    path.write_text(json.dumps(damaged(change)))
    with pytest.raises(EpibarError, match=named) as raised:
        Network.load(path)
    assert "network.json" in str(raised.value)


def test_one_that_was_saved_before_ellipsoids_were(tmp_path):
    content = json.loads(json_text(made_up().as_dict()))
    for one in content["cameras"]:
        del one["position_covariance"]
    (tmp_path / "network.json").write_text(json.dumps(content))
    loaded = Network.load(tmp_path / "network.json")
    assert loaded.cameras["cam1"].position_covariance is None
    assert loaded.cameras["cam1"].expected["position"] == 0.002


def test_no_such_file(tmp_path):
    with pytest.raises(EpibarError, match="no such file"):
        Network.load(tmp_path / "none.json")
    for text in ("", "{", "[]", "\x00"):
        (tmp_path / "other.json").write_text(text)
        with pytest.raises(EpibarError, match=r"other\.json"):
            Network.load(tmp_path / "other.json")
    with pytest.raises(EpibarError, match="cannot be written"):
        made_up().save(tmp_path / "nowhere" / "network.json")


def test_repr_says_how_many():
    assert "2 of 4 cameras accepted" in repr(made_up())
    assert "cam1 - cam2" in repr(made_up().pairs)
    assert replace(made_up(), unit="metre").unit == "metre"


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
