"""One more camera for a network: what the compiled module is asked, what is refused, and the real thing."""

import functools
import logging
from dataclasses import replace

import numpy as np
import pytest
from check_input import MOVED, UNSURE, films, network
from extended_input import REFUSED, refused_pair

import epibar
from epibar import EpibarError, synthetic
from epibar.geometry.cameras import fundamental_from_cameras
from epibar.network import ClockOffsets, KnownCamera, NetworkClock, extending
from epibar.network.core_parts import camera_of


def test_what_is_asked_and_what_comes_out(adding):
    told = set()
    net = network()
    more = net.extended(
        films("cam9", "cam3", "cam1", "cam2"), 3, 0.0, progress=lambda stage, share: told.add(stage)
    )
    assert told >= {"check", "pairs", "network"}
    # The cameras of the network first, in its order.
    assert adding.names == ["cam1", "cam2", "cam3", "cam9"]
    assert adding.stored[0]["expected"] == net.cameras["cam1"].expected
    assert len(adding.known) == 1
    assert adding.known[0]["matrix"] is None
    assert adding.clocks == ([0.0] * 4, False, True)
    assert len(adding.searched) == 3
    assert all(options["seed"] == 3 and options["upright"] for options in adding.searched)
    assert list(more.cameras) == ["cam1", "cam2", "cam3", "cam4", "cam9"]
    assert all(more.cameras[name] is net.cameras[name] for name in net.cameras)
    camera = more.cameras["cam9"]
    assert camera.accepted
    assert camera.evidence == {"tangents": 9.0, "silhouettes": 7.0}
    assert (camera.rotation == adding.R).all()
    assert more.clocks["cam9"].offset == pytest.approx(0.25)
    assert list(more.pairs) == [
        *(("cam1", "cam2"), ("cam1", "cam3"), ("cam1", "cam4"), ("cam1", "cam9")),
        *(("cam2", "cam3"), ("cam2", "cam4"), ("cam2", "cam9"), ("cam3", "cam4"), ("cam3", "cam9")),
        ("cam4", "cam9"),
    ]
    assert more.pairs["cam9", "cam2"].status == "confirmed"
    assert more.pairs["cam4", "cam9"].status == "outside"
    assert more.reason.endswith("; added later: cam9")
    assert (more.unit, more.ground, more.accepted) == (net.unit, net.ground, net.accepted)


def test_it_is_saved_and_read_again(adding, tmp_path):
    more = network().extended(films("cam9", "cam1", "cam2"), time_offset=0.0)
    more.save(tmp_path / "network.json")
    again = epibar.Network.load(tmp_path / "network.json")
    assert (again.cameras["cam9"].matrix == adding.place["matrix"]).all()
    assert again.pairs["cam1", "cam9"].status == "confirmed"
    # No film of it says anything of this pair: it follows from where both stand.
    pair, posed = (
        again.pairs["cam3", "cam9"],
        [again.cameras[n].intrinsics().posed() for n in ("cam3", "cam9")],
    )
    assert (pair.status, pair.accepted) == ("predicted", True)
    assert np.allclose(pair.F, fundamental_from_cameras(*posed))


def test_the_clock_is_against_that_of_the_first_camera(adding):
    net = network()
    net.clocks["cam2"] = NetworkClock(2.0, 10.0, 0.001)
    clock = net.extended(films("cam9", "cam2", "cam3"), time_offset=0.0).clocks["cam9"]
    assert adding.names[0] == "cam2"
    assert clock.offset == pytest.approx(2.25, abs=1e-3)
    assert clock.drift == pytest.approx(30.0, abs=1e-3)


def test_clocks_that_are_given_and_clocks_that_are_found(adding):
    net = network()
    seconds = {"cam9": 1.0, "cam2": 1.5, "cam1": 3.0}
    net.extended(films("cam9", "cam2", "cam1"), time_offset=seconds)
    assert adding.clocks == ([0.0, -1.5, -2.0], False, True)
    net.extended(films("cam9", "cam2", "cam1"), search_seconds=1.0)
    assert not adding.clocks[2]
    assert len(adding.clocks[0]) == 3


def test_a_camera_that_moved_has_no_part_in_it(core, adding):
    core.verdicts = {"cam2": MOVED}
    more = network().extended(films("cam1", "cam2", "cam3", "cam9"), time_offset=0.0)
    assert adding.names == ["cam1", "cam3", "cam9"]
    assert more.pairs["cam2", "cam9"].status == "predicted"
    core.verdicts = {"cam2": MOVED, "cam3": UNSURE}
    adding.names = None
    left = network().extended(films("cam1", "cam2", "cam3", "cam9"), time_offset=0.0)
    assert adding.names is None
    assert "cam9" not in left.cameras
    assert "at least two cameras of the network must stand as stored" in left.reason


def test_a_camera_that_is_refused_is_left_out(adding, caplog):
    net = network()
    with caplog.at_level(logging.WARNING, "epibar"):
        same = net.extended(films("cam1", "cam2", "other"), time_offset=0.0)
    assert list(same.cameras) == list(net.cameras)
    assert list(same.pairs) == list(net.pairs)
    assert f"other was not added: {REFUSED}" in same.reason
    assert "other was not added" in caplog.text


def test_what_is_known_of_a_new_camera(adding):
    net = network()
    known = {"cam9": KnownCamera(focal=640.0)}
    net.extended(films("cam1", "cam2", "cam9"), time_offset=0.0, known=known)
    assert adding.known[0]["focal"][0] == 640.0
    with pytest.raises(EpibarError, match="the network has its lens"):
        net.extended(films("cam1", "cam2", "cam9"), known={"cam1": KnownCamera(focal=640.0)})
    with pytest.raises(EpibarError, match="known is a int, expected a mapping of names to KnownCamera"):
        net.extended(films("cam1", "cam2", "cam9"), known=3)


@pytest.mark.parametrize(
    ("names", "options", "told"),
    [
        (["cam1", "cam2"], {}, "none to add"),
        (["cam1", "cam9"], {}, "at least two accepted cameras .* there are 1"),
        (["cam1", "cam4", "cam9"], {}, "there are 1"),
        (["cam1", "cam2", "cam9"], {"seed": -1}, "seed"),
        (["cam1", "cam2", "cam9"], {"search_seconds": 0}, "search_seconds"),
        (["cam1", "cam2", "cam9"], {"time_offset": 1.0}, "does not say whose"),
        (["cam1", "cam2", "cam9"], {"known": {"cam8": KnownCamera()}}, "cam8"),
    ],
)
def test_what_is_refused(adding, names, options, told):
    with pytest.raises(EpibarError, match=told):
        network().extended(films(*names), **options)


def test_a_pair_search_that_failed_brings_nothing(adding):
    network().extended(films("cam1", "cam2", "cam9"), time_offset=0.0)
    assert len(adding.pairs) == (0 if refused_pair().F is None else 2)


def test_a_camera_whose_clock_is_not_known_has_no_part(adding, monkeypatch):
    offsets = ClockOffsets((0.0, float("nan"), 0.0, 1.5))
    monkeypatch.setattr(extending, "_clocks", lambda *_: offsets)
    more = network().extended(films("cam1", "cam2", "cam3", "cam9"))
    assert adding.names == ["cam1", "cam3", "cam9"]
    assert adding.clocks == ([0.0, 0.0, 1.5], False, False)
    assert "cam9" in more.cameras
    monkeypatch.setattr(extending, "_clocks", lambda *_: replace(offsets, seconds=(0.0, *[float("nan")] * 3)))
    assert "cam9" not in network().extended(films("cam1", "cam2", "cam3", "cam9")).cameras


# --- the real thing ---


@functools.cache
def situation():
    return synthetic.situation(3, "network_plain")


def test_a_fourth_camera_is_added_to_three_true_ones():
    """The stored network is the truth, so that the new camera is held against it as it stands."""
    made = situation()
    net = network()
    names = ["cam1", "cam2", "cam3"]
    for name, camera in zip(names, made.cameras, strict=False):
        answer = {"matrix": camera.K, "distortions": np.resize(camera.distortions or (0.0,), 5)}
        answer |= {"rotation": camera.R, "translation": camera.t, "deviates": (9.0, 9.0)}
        answer |= {"name": name, "accepted": True, "status": "accepted", "reason": "true"}
        answer |= {"expected": {"focal": 0.0, "rotation": 0.0, "position": 0.0}}
        answer |= {"position_covariance": np.zeros((3, 3))}
        net.cameras[name] = camera_of(answer, camera.size)
    recordings = {name: made.recording(k, lines=1500, frames=600) for k, name in enumerate([*names, "cam9"])}
    more = net.extended(recordings, time_offset=0.0)
    assert "cam9" in more.cameras, more.reason
    camera, truth = more.cameras["cam9"], made.cameras[3]
    turned = np.degrees(np.arccos(np.clip((np.trace(camera.rotation @ truth.R.T) - 1) / 2, -1, 1)))
    assert turned <= camera.expected["rotation"] < 2.0
    assert np.linalg.norm(camera.position - truth.centre) <= camera.expected["position"]
    assert abs(camera.matrix[0, 0] / truth.K[0, 0] - 1) <= camera.expected["focal"]
    assert sum(more.pairs[name, "cam9"].status == "confirmed" for name in names) >= 2


@pytest.mark.parametrize(
    ("filmed", "turned", "added"),
    [
        (("cam1", "cam2"), 0.0, False),
        (("cam1", "cam2"), 3.0, True),
        (("cam1", "cam2", "cam3"), 0.0, True),
    ],
)
def test_a_camera_by_another_name_is_not_added_as_a_second_one(filmed, turned, added, adding):
    net = network()
    third = net.cameras["cam3"]
    angle = np.deg2rad(turned)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    # Within what is stated of either, where it is not turned.
    moved = 0.5 * third.expected["position"] * third.rotation[0]
    R = turn @ third.rotation
    adding.place |= {"rotation": R, "translation": -R @ (np.asarray(third.position) + moved)}
    more = net.extended(films(*filmed, "cam9"), time_offset=0.0)
    assert ("cam9" in more.cameras) == added
    if not added:
        told = (
            "it stands where cam3 is stored, of which there is no film: if it is that camera, name the film"
        )
        assert told in more.reason
        assert not any("cam9" in key for key in more.pairs)
        assert "cam9" not in more.clocks
