"""Has a camera moved? What is asked of the compiled module, and what is refused.

But for the last test the verdicts are made up, so that every kind of them is there.
"""

import functools
from dataclasses import replace

import numpy as np
import pytest
from check_input import MOVED, UNMOVED, UNSURE, films, network
from network_input import LINES

import epibar
from epibar import EpibarError, Recording, _core, synthetic
from epibar.network import CameraCheck, NetworkCheck
from epibar.synthetic.settings import turned

# --- from Python ---


def test_what_is_asked(core):
    told = []
    net = network()
    check = net.check(films("cam3", "cam1"), 0.0, lambda stage, share: told.append((stage, share)))
    assert told == [("check", 1.0)]
    assert core.names == ["cam3", "cam1"]
    assert core.clocks == ([0.0, 0.0], False, True)
    assert all(isinstance(one, _core.Recording) for one in core.recordings)
    stored = net.cameras["cam3"]
    assert core.cameras[0] == {
        "camera": {
            "matrix": stored.matrix.tolist(),
            "distortions": stored.distortions.tolist(),
            "rotation": stored.rotation.tolist(),
            "translation": stored.translation.tolist(),
        },
        "expected": stored.expected,
    }
    assert isinstance(check, NetworkCheck)
    assert check.ok
    assert check.moved == check.unsure == []
    assert check.cameras["cam1"] == CameraCheck(name="cam1", **UNMOVED)
    assert check.left_out.keys() == {"cam2", "cam4"}
    assert "no new recording" in check.left_out["cam2"]
    assert "not accepted" in check.left_out["cam4"]
    assert check.reason == "none of 2 cameras has moved; not looked at: cam2, cam4"


def test_clocks_are_against_the_first_that_is_looked_at(core):
    net = network()
    seconds = {"cam4": 1.0, "cam2": 1.5, "cam1": 3.0}
    net.check(films("cam4", "cam2", "cam1"), seconds)
    assert core.names == ["cam2", "cam1"]
    assert core.clocks == ([0.0, 1.5], False, True)


def test_clocks_are_found(core):
    stages = set()
    network().check(films("cam1", "cam2", "cam3"), progress=lambda stage, _: stages.add(stage))
    seconds, _, given = core.clocks
    assert len(seconds) == 3
    assert not given
    assert "check" in stages


def test_a_recording_without_its_lens(core):
    """Its distortions are none, and its matrix is the stored one or it is refused."""
    net = network()
    mine = films("cam2", matrix=net.cameras["cam2"].matrix)
    net.check({**films("cam1"), **mine}, 0.0)
    assert core.cameras[0]["camera"]["distortions"] == net.cameras["cam1"].distortions.tolist()
    assert core.cameras[1]["camera"]["distortions"] == [0.0] * 5
    other = net.cameras["cam2"].matrix * [[1.001], [1.001], [1]]
    with pytest.raises(EpibarError, match=r"cam2: .*another camera matrix"):
        net.check({**films("cam1"), **films("cam2", matrix=other)}, 0.0)


@pytest.mark.parametrize(
    ("names", "options", "told"),
    [
        (["cam1", "cam9"], {}, "cam9: the network has no camera of that name; it has cam1"),
        (["cam1"], {}, "at least two"),
        (["cam1", "cam4"], {}, "1 can be looked at .*cam4: not accepted"),
        (["cam1", "cam2"], {"time_offset": "soon"}, "soon"),
        (["cam1", "cam2", "cam3"], {"time_offset": 1.0}, "does not say whose"),
        (["cam1", "cam2"], {"search_seconds": 0}, "search_seconds"),
    ],
)
def test_what_is_refused(core, names, options, told):
    with pytest.raises(EpibarError, match=told):
        network().check(films(*names), **options)


def test_frames_of_another_size(core):
    with pytest.raises(EpibarError, match=r"cam2: 320x480 frames, .* at 640x480"):
        network().check({**films("cam1"), **films("cam2", size=(320, 480))}, 0.0)


def test_a_film_that_does_not_fit_costs_its_camera_and_no_other(core):
    """It cannot be judged, and a camera beside it that moved is named."""
    core.verdicts = {"cam3": MOVED}
    check = network().check({**films("cam1", "cam3"), **films("cam2", size=(320, 480))}, 0.0)
    assert core.names == ["cam1", "cam3"]
    assert (check.moved, check.unsure, check.ok) == (["cam3"], ["cam2"], False)
    assert check.cameras["cam2"].reason.startswith(
        "320x480 frames, but the network was calibrated at 640x480"
    )
    assert list(check.cameras) == ["cam1", "cam3", "cam2"]


def test_what_the_compiled_module_refuses_is_told(monkeypatch):
    def refused(*_):
        raise ValueError("cam1: no frames")

    monkeypatch.setattr(_core, "check_network", refused, raising=False)
    with pytest.raises(EpibarError, match="cam1: no frames"):
        network().check(films("cam1", "cam2"), 0.0)


@pytest.mark.parametrize(
    ("verdicts", "reason"),
    [
        ({"cam2": MOVED}, "of 3 cameras cam2 has moved"),
        ({"cam1": MOVED, "cam2": MOVED}, "of 3 cameras cam1, cam2 have moved"),
        ({"cam2": UNSURE}, "of 3 cameras none is known to have moved, but cam2 cannot be judged"),
        ({"cam1": MOVED, "cam3": UNSURE}, "of 3 cameras cam1 has moved, and cam3 cannot be judged"),
    ],
)
def test_sentences(core, verdicts, reason):
    core.verdicts = verdicts
    check = network().check(films("cam1", "cam2", "cam3"), 0.0)
    assert not check.ok
    assert check.reason == f"{reason}; not looked at: cam4"


# --- the real thing ---

BEFORE, AFTER = 600, 700
"""Frames that the network is made of, and where the new footage starts."""


@functools.cache
def situation():
    return synthetic.situation(3, "network_plain")


def recorded(camera, first, last, film=None):
    made = situation()
    film = film or made.films[camera]
    return Recording.from_masks(
        np.stack(list(film.iter_masks(first, last))), fps=made.clocks[camera].fps, lines=LINES, seed=camera
    )


@pytest.mark.skipif(
    not hasattr(_core, "check_network"), reason="the compiled module has no check_network yet"
)
def test_a_camera_that_was_turned_is_found(tmp_path):
    """Four cameras calibrated, filmed again later: as they stood, and with the third turned by 3 degrees."""
    before = {f"cam{k + 1}": recorded(k, 0, BEFORE) for k in range(4)}
    net = epibar.calibrate_network(before, time_offset=0.0)
    assert net.accepted, net.reason
    net.save(tmp_path / "network.json")
    net = epibar.Network.load(tmp_path / "network.json")
    after = {f"cam{k + 1}": recorded(k, AFTER, AFTER + 600) for k in range(4)}
    same = net.check(after)
    assert same.ok, same.reason
    film = situation().films[2]
    knocked = replace(film, camera=turned(film.camera, np.random.default_rng(0), 3.0))
    after["cam3"] = recorded(2, AFTER, AFTER + 600, knocked)
    check = net.check(after)
    assert check.moved == ["cam3"], check.reason
    found = check.cameras["cam3"]
    assert found.turned == pytest.approx(3.0, abs=1.0)


def test_where_none_stands_several_may_have_moved(core):
    names = ["cam1", "cam2", "cam3"]
    others = {name: [other for other in names if other != name] for name in names}
    core.verdicts = {name: {**MOVED, "status": "suspect", "rivals": others[name]} for name in names}
    check = network().check(films(*names), 0.0)
    assert check.reason == "of 3 cameras one or more of cam1, cam2, cam3 has moved; not looked at: cam4"


def test_a_suspect_that_cannot_be_judged_is_named_with_the_others(core):
    """Where two films are swapped those two fit nothing, and the others seem to have moved."""
    core.verdicts = {"cam1": {**MOVED, "status": "suspect", "rivals": ["cam2", "cam3"]}, "cam2": UNSURE}
    check = network().check(films("cam1", "cam2", "cam3"), 0.0)
    assert (check.suspects, check.unsure) == (["cam1"], ["cam2"])
    told = "of 3 cameras one of cam1, cam2, cam3 has moved, and cam2 cannot be judged; not looked at: cam4"
    assert check.reason == told
