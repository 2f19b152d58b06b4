"""Networks in metres: lengths, people, and what they rest on."""

import json
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from network_input import COVARIANCE, made_up

import epibar
from epibar import EpibarError
from epibar.files.json_file import write_json
from epibar.network.calibrating import in_metres
from epibar.network.metres import check_lengths
from epibar.network.prose import network_notes


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


def test_what_lengths_are_wrong_by_together_does_not_average_out():
    """The floor is under all cameras, and where one stands is in all lengths that it has a part in."""
    net = made_up(refused=(), lost=())
    low = replace(net, ground=replace(net.ground, level_error=0.03 * 0.8, vertical_error=0.0))
    height = [(name, 0.8, 1e-4) for name in net.cameras]
    one, all_of_them = (low.scaled(camera_height=given).scale.error for given in (height[:1], height))
    assert one > 1.645 * 0.03
    assert 1.645 * 0.03 <= all_of_them < one
    # Two that share a camera say less than two that do not.
    loose = {
        name: replace(camera, expected={**camera.expected, "position": 0.05 if name == "cam1" else 1e-6})
        for name, camera in net.cameras.items()
    }
    (a, b, first), *_, (c, d, last) = net_sides(net)
    assert "cam1" in (a, b)
    assert "cam1" in (c, d)
    shared = replace(net, cameras=loose)
    single = shared.scaled(distance=(a, b, first, 1e-6)).scale.error
    both = shared.scaled(distance=[(a, b, first, 1e-6), (c, d, last, 1e-6)]).scale.error
    assert both == pytest.approx(single / 2**0.5, rel=0.01)  # their directions are at right angles


def test_the_same_length_twice_is_one():
    net = made_up()
    twice = [("cam1", "cam2", 4.2), ("cam2", "cam1", 4.2)]
    with pytest.raises(EpibarError, match="are of the same: give one of them"):
        net.scaled(distance=twice)
    # Before any work, too.
    with pytest.raises(EpibarError, match="are of the same: give one of them"):
        check_lengths(list(net.cameras), distance=twice)


def test_two_heights_above_one_floor_contradict_each_other_whatever_its_level():
    net = made_up(refused=(), lost=())
    low = replace(net, ground=replace(net.ground, level_error=0.05, vertical_error=0.0))
    assert low.scaled(camera_height=[("cam1", 4.0, 0.004), ("cam3", 4.01, 0.004)]).scale.error > 0.05
    with pytest.raises(EpibarError, match="contradict each other"):
        low.scaled(camera_height=[("cam1", 4.0, 0.004), ("cam3", 4.5, 0.004)])


def test_a_height_above_a_floor_of_unknown_error_says_nothing():
    net = made_up()
    for unknown in ("level_error", "vertical_error"):
        ground = replace(net.ground, **{unknown: None})
        with pytest.raises(EpibarError, match="does not say how well its floor is known"):
            replace(net, ground=ground).scaled(camera_height=("cam2", 4.2))


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


def test_lengths_count_on_where_they_are_kept(tmp_path):
    net = made_up()
    lengths = [("cam1", "cam2", 7.0, 0.2)]
    at_once = net.scaled(distance=lengths, person_height=1.75, camera_height=("cam2", 4.0, 0.1))
    step = net.scaled(person_height=1.75).scaled(distance=lengths, keep=True)
    step.save(tmp_path / "network.json")
    step = epibar.Network.load(tmp_path / "network.json")
    step = step.scaled(camera_height=("cam2", 4.0, 0.1), keep=True)
    for name in ("cam1", "cam2"):
        place = at_once.cameras[name].position
        np.testing.assert_allclose(step.cameras[name].position, place, rtol=1e-12, atol=1e-12)
    assert step.scale.error == pytest.approx(at_once.scale.error, rel=1e-12)
    assert sorted(step.scale.sources) == sorted(at_once.scale.sources)
    # The same again corrects it, whichever camera is named first.
    again = step.scaled(distance=("cam2", "cam1", 7.1, 0.2), keep=True)
    assert len(again.scale.lengths) == 3
    assert "7.1 m between cam2 and cam1" in " ".join(again.scale.sources)
    assert len(step.scaled(distance=lengths).scale.lengths) == 1


def test_a_length_that_contradicts_what_was_given_before(tmp_path):
    net = made_up().scaled(person_height=1.75)
    more = {"distance": ("cam1", "cam2", 40.0), "keep": True}
    with pytest.raises(EpibarError, match=r"of people and the distance .* contradict .*--forget"):
        net.scaled(**more)
    # Files of before have words alone.
    net.save(tmp_path / "network.json")
    content = json.loads((tmp_path / "network.json").read_text())
    del content["scale"]["lengths"]
    (tmp_path / "network.json").write_text(json.dumps(content))
    old = epibar.Network.load(tmp_path / "network.json")
    assert old.scale.lengths == ()
    with pytest.raises(EpibarError, match=r"1.75 m of people and the distance .* contradict"):
        old.scaled(**more)
    # One that says that it is known exactly.
    content["scale"]["error"] = 0
    (tmp_path / "network.json").write_text(json.dumps(content))
    with pytest.raises(EpibarError, match=r"contradict"):
        epibar.Network.load(tmp_path / "network.json").scaled(**more)
    for ratio, error in ((0, 0.1), (1.0, 0), (1.0, 1e-200)):
        content["scale"]["lengths"] = [
            {"what": "a stick", "of": ["distance"], "ratio": ratio, "error": error}
        ]
        (tmp_path / "network.json").write_text(json.dumps(content))
        with pytest.raises(EpibarError, match=r"damaged .*says nothing"):
            epibar.Network.load(tmp_path / "network.json")


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
        ({"distance": ("cam1", "cam2", 2.0, 1e-320)}, "billionth"),
        ({"distance": ("cam1", "cam2", 1e200)}, "0.0001 to"),
        ({"distance": ("cam1", "cam2", 1e-320)}, "0.0001 to"),
        ({"distance": ("cam1", "cam2", 0.001)}, "as much as the length itself"),
        ({"camera_height": ("cam1", math.nan)}, "positive"),
        ({"camera_height": ("cam1", 1e308)}, "0.0001 to"),
        ({"person_height": 1e160}, "0.0001 to"),
        ({"person_height": "tall"}, "person_height"),
        ({"person_height": 175}, "in metres: 1.75, not 175"),
    ],
)
def test_lengths_of_no_use(lengths, named):
    with pytest.raises(EpibarError, match=named):
        made_up().scaled(**lengths)


def test_a_network_that_says_too_little_for_a_length(tmp_path):
    def changed(change):
        content = made_up().as_dict()
        change(content["cameras"])
        write_json(tmp_path / "network.json", content)
        return epibar.Network.load(tmp_path / "network.json")

    in_one_place = changed(
        lambda cameras: cameras[1].update({key: cameras[0][key] for key in ("rotation", "translation")})
    )
    with pytest.raises(EpibarError, match="both stand in one place"):
        in_one_place.scaled(distance=("cam1", "cam2", 2.0))
    unknown = changed(lambda cameras: cameras[0]["expected"].update(position=None))
    with pytest.raises(EpibarError, match="how well it is known"):
        unknown.scaled(distance=("cam1", "cam2", 2.0))


def test_people_say_nothing_without_a_floor():
    net = made_up(floor=False)
    for lengths in ({"person_height": 1.75}, {"camera_height": ("cam1", 2.0)}):
        with pytest.raises(EpibarError, match="no floor was found"):
            net.scaled(**lengths)
    kept = in_metres(net, (), 1.75)
    assert kept.unit == "baseline"
    assert "not in metres" in kept.reason
    # That is no longer so.
    assert kept.scaled(distance=("cam1", "cam2", 2.0)).reason == net.reason
