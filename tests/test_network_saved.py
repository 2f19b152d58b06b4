"""Networks saved and loaded: what comes back, what is damaged, and what earlier versions wrote."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from network_input import calibrated, made_up

from epibar import EpibarError, Network
from epibar.files.json_file import json_text


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
        (lambda c: c["cameras"][0].update(translation=[0, 1e160, 0]), "cam1: translation"),
        (lambda c: c["cameras"][0].update(distortions=[0] * 4), "cam1: distortions"),
        (lambda c: c["cameras"][0].update(distortions=[0, 0, 1e308, 0, 0]), "cam1: distortions"),
        (lambda c: c["cameras"][0]["expected"].update(position=-1.0), "position is -1.0"),
        (lambda c: c["cameras"][0].update(position_covariance=(1e300 * np.eye(3)).tolist()), "which is none"),
        (lambda c: c["ground"].update(height=-1.7), "height is -1.7"),
        (lambda c: c["ground"].update(level_error=-1e308), "level_error"),
        (lambda c: c.update(radius=1e13), "radius"),
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
