"""A network whose cameras moved: what ``updated`` and ``epibar check --update`` change, and what stays.

The verdicts are made up; test_check.py has the real thing.
"""

import json

import numpy as np
import pytest
from check_input import FEW, MOVED, UNSURE, films, network, replaced, some_masks, suspect, write_run

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.files import network_json
from epibar.files.calibration_json import schema
from epibar.geometry.cameras import fundamental_from_cameras
from epibar.jobs.folder import Folder
from epibar.lens.cameras_toml import load_cameras
from epibar.network import updating


@pytest.fixture
def folder(tmp_path):
    """What a run of four cameras leaves, as far as an update touches it."""
    net = network()
    pairs = [
        {"a": a, "b": b, "accepted": True, "kind": "accepted", "reason": "fine", "F": np.eye(3).tolist()}
        | {"expected_error": 0.3, "time_offset": 0.0, "frontier_points": f"{a}_{b}.csv", "rivals": [{}]}
        | {"picture": f"{a}_{b}.png", "floor": np.eye(3).tolist(), "pose": None}
        for a, b in net.pairs
    ]
    for pair in pairs:
        (tmp_path / pair["frontier_points"]).write_text("frame_a,x_a,y_a,x_b,y_b,residual\n")
    write_run(tmp_path, net, pairs)
    for k in range(4):
        np.savez_compressed(tmp_path / f"cam{k + 1}.npz", masks=some_masks(k), fps=25.0)
    return tmp_path


def update(folder, *more):
    videos = [str(folder / f"cam{k}.npz") for k in (1, 2, 3)]
    return main(["check", str(folder), *videos, *FEW, "--update", *more])


def written(folder):
    names = ("network.json", "cameras.toml", "calibration.json")
    return {name: (folder / name).read_bytes() for name in names}


def check_of(core, net, **verdicts):
    core.verdicts = verdicts
    return net.check(films("cam1", "cam2", "cam3"), 0.0)


# --- in Python ---


def test_what_changes_and_what_stays(core):
    net = network()
    moved = replaced(net.cameras["cam2"], ["cam1", "cam3"])
    now = net.updated(check_of(core, net, cam2=moved))
    camera, before, place = now.cameras["cam2"], net.cameras["cam2"], moved["place"]
    assert all((getattr(camera, k) == place[k]).all() for k in ("matrix", "rotation", "translation"))
    assert (camera.distortions == before.distortions).all()
    assert camera.accepted
    assert "solved for again" in camera.reason
    # Its own error, and what the two that stand are wrong by.
    assert camera.expected["rotation"] == pytest.approx(np.hypot(0.04, 0.2))
    assert camera.expected["focal"] == pytest.approx(np.hypot(0.003, 0.01))
    theirs = np.mean([one.expected["position"] ** 2 for one in (net.cameras["cam1"], net.cameras["cam3"])])
    assert np.allclose(camera.position_covariance, place["position_covariance"] + theirs / 2.5**2 * np.eye(3))
    for name in ("cam1", "cam3", "cam4"):
        assert now.cameras[name] is net.cameras[name]
    for key in (("cam1", "cam3"), ("cam1", "cam4"), ("cam2", "cam4")):
        assert now.pairs[key] is net.pairs[key]
    pair = now.pairs["cam1", "cam2"]
    one, other = (now.cameras[name].intrinsics().posed() for name in ("cam1", "cam2"))
    assert np.allclose(pair.F, fundamental_from_cameras(one, other))
    assert pair.status == "confirmed"
    assert pair.evidence == {"tangents": 12.0, "silhouettes": 4.0}
    assert (now.clocks, now.ground, now.unit) == (net.clocks, net.ground, net.unit)
    assert (net.cameras["cam2"].rotation == before.rotation).all()


def test_a_check_of_before_is_refused(core):
    net = network().scaled(distance=("cam1", "cam3", 4.0, 0.01))
    check = check_of(core, net, cam2=replaced(net.cameras["cam2"], ["cam1", "cam3"]))
    longer = network().scaled(distance=("cam1", "cam3", 5.0, 0.01))
    with pytest.raises(EpibarError, match=r"cam\d does not stand where it did .* check again"):
        longer.updated(check)
    assert net.updated(check).cameras["cam2"] is not net.cameras["cam2"]


def test_the_focal_length_stays_as_well_known_where_it_stays(core):
    net = network()
    now = net.updated(check_of(core, net, cam2=replaced(net.cameras["cam2"], ["cam1", "cam3"], False)))
    assert now.cameras["cam2"].expected["focal"] == net.cameras["cam2"].expected["focal"]


def test_a_pair_that_the_new_footage_says_little_of(core):
    net = network()
    moved = replaced(net.cameras["cam2"], ["cam1", "cam3"])
    moved["place"]["pairs"]["cam3"] = (1.0, float("nan"))
    now = net.updated(check_of(core, net, cam2=moved))
    assert now.pairs["cam2", "cam3"].status == "predicted"
    assert now.pairs["cam2", "cam3"].evidence == {"tangents": 1.0}


def test_a_camera_that_was_put_beside_another_has_no_epipole_there(core):
    net = network()
    moved = replaced(net.cameras["cam2"], ["cam1", "cam3"])
    beside = net.cameras["cam1"].position + np.array([0.005, 0.0, 0.0])  # errors are 0.002 to 0.003
    moved["place"]["translation"] = -moved["place"]["rotation"] @ beside
    now = net.updated(check_of(core, net, cam2=moved))
    pair = now.pairs["cam1", "cam2"]
    assert now.cameras["cam2"].accepted
    assert (pair.status, pair.accepted) == ("no_baseline", False)
    assert pair.F is not None
    assert now.pairs["cam2", "cam3"].accepted


def test_what_is_not_confirmed_stays(core):
    net = network()
    check = check_of(core, net, cam2=MOVED, cam3=UNSURE)
    now = net.updated(check)
    assert all(now.cameras[name] is net.cameras[name] for name in net.cameras)
    assert updating.update_notes(check) == [
        "nothing was updated",
        "cam2 was not updated: its new place is not certain, see above",
        "cam3 was not updated: it cannot be judged",
    ]


def test_a_check_of_another_network(core):
    net = network()
    check = check_of(core, net, cam2=replaced(net.cameras["cam2"], ["cam1", "cam3"]))
    with pytest.raises(EpibarError, match="check again"):
        net.scaled(distance=("cam1", "cam2", 3.0)).updated(check)
    del net.cameras["cam2"]
    with pytest.raises(EpibarError, match="cam2: the check is of another network"):
        net.updated(check)


def test_a_lens_that_was_taken_out_is_not_zoomed(core):
    """Nobody knows how the other focal length bends."""
    net = network()
    core.verdicts = {"cam2": replaced(net.cameras["cam2"], ["cam1", "cam3"])}
    mine = films("cam2", matrix=net.cameras["cam2"].matrix)
    check = net.check({**films("cam1", "cam3"), **mine}, 0.0)
    assert check.moved == ["cam2"]
    assert check.cameras["cam2"].place is None
    assert "calibrate the lens again" in check.cameras["cam2"].reason


# --- on the command line ---


def test_every_file_holds_the_new_network(core, folder, capsys):
    net = network()
    core.verdicts = {"cam2": replaced(net.cameras["cam2"], ["cam1", "cam3"])}
    assert update(folder) == 0
    assert "updated: cam2; all else stays as it was" in capsys.readouterr().out
    now = epibar.Network.load(folder / "network.json")
    place = core.verdicts["cam2"]["place"]
    assert np.allclose(now.cameras["cam2"].rotation, place["rotation"])
    assert np.allclose(now.cameras["cam1"].rotation, net.cameras["cam1"].rotation)
    known = {camera.name: camera for camera in load_cameras(folder / "cameras.toml")}
    assert np.allclose(known["cam2"].matrix, place["matrix"])
    content = json.loads((folder / "calibration.json").read_text())
    alone = json.loads((folder / "network.json").read_text())
    assert alone == {"$schema": network_json.SCHEMA, **content["network"]}
    for pair in content["pairs"]:
        if "cam2" in (pair["a"], pair["b"]):
            assert not pair["accepted"]
            assert (pair["kind"], pair["F"], pair["rivals"]) == ("moved", None, [])
            assert "cam2 moved after the pair was calibrated" in pair["reason"]
        else:
            assert pair["accepted"]
            assert pair["F"] == np.eye(3).tolist()
    epibar.export.Run.load(folder)


def test_a_pair_in_undistorted_pixels_gets_the_networks_geometry(core, folder):
    path = folder / "calibration.json"
    content = json.loads(path.read_text())
    net = network()
    for one in content["cameras"][:3]:
        one["matrix"] = net.cameras[one["name"]].matrix.tolist()
    path.write_text(json.dumps(content))
    core.verdicts = {"cam2": replaced(net.cameras["cam2"], ["cam1", "cam3"], zoomed=False)}
    assert update(folder) == 0
    now = epibar.Network.load(folder / "network.json")
    (pair,) = (p for p in json.loads(path.read_text())["pairs"] if (p["a"], p["b"]) == ("cam1", "cam2"))
    assert not pair["accepted"]
    assert np.allclose(pair["F"], now.pairs["cam1", "cam2"].F)
    assert pair["reason"].endswith("F is the network's")


def test_pairs_are_still_as_the_schema_says(core, folder):
    jsonschema = pytest.importorskip("jsonschema")
    net = network()
    core.verdicts = {"cam2": replaced(net.cameras["cam2"], ["cam1", "cam3"])}
    assert update(folder) == 0
    content = json.loads((folder / "calibration.json").read_text())
    described = schema()
    properties = ("accepted", "kind", "reason", "F", "expected_error", "floor", "rivals", "pose")
    for pair in content["pairs"]:
        if pair["kind"] == "moved":
            for key in properties:
                part = {**described["$defs"]["pair"]["properties"][key], "$defs": described["$defs"]}
                jsonschema.validate(pair[key], part)
            assert set(properties) < pair.keys()


def test_for_programs(core, folder, capsys):
    net = network()
    core.verdicts = {"cam2": replaced(net.cameras["cam2"], ["cam1", "cam3"]), "cam3": UNSURE}
    assert update(folder, "--json") == 4
    printed = capsys.readouterr()
    result = json.loads(printed.out, parse_constant=pytest.fail)
    assert result["updated"] == ["cam2"]
    assert result["ok"] is False
    assert result["cameras"]["cam2"]["place"]["zoomed"] is True
    assert "cam3 was not updated: it cannot be judged" in printed.err


def test_all_is_well_where_what_moved_was_updated(core, folder, capsys):
    """As the exit code says."""
    core.verdicts = {"cam2": replaced(network().cameras["cam2"], ["cam1", "cam3"])}
    assert update(folder, "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["ok"], result["moved"], result["updated"]) == (True, ["cam2"], ["cam2"])


def test_nothing_is_written_where_nothing_is_confirmed(core, folder, capsys):
    before = written(folder)
    assert update(folder) == 0
    core.verdicts = {"cam2": MOVED}
    assert update(folder) == 4
    assert "cam2 was not updated: its new place is not certain, see above" in capsys.readouterr().out
    assert written(folder) == before


def test_nothing_is_written_where_it_is_not_known_which_moved(core, folder, capsys):
    before = written(folder)
    core.verdicts = {"cam2": suspect("cam3"), "cam3": suspect("cam2")}
    assert update(folder) == 4
    assert "cam2, cam3: none was updated, for which of them moved is not known" in capsys.readouterr().out
    assert written(folder) == before


def test_all_or_none(core, folder, capsys, monkeypatch):
    """The last of the files cannot be written: the others are as they were."""
    from epibar.jobs import update_files

    before = written(folder)

    def full(*_):
        raise EpibarError("calibration.json: no space left on device")

    monkeypatch.setattr(update_files, "write_json", full)
    core.verdicts = {"cam2": replaced(network().cameras["cam2"], ["cam1", "cam3"])}
    assert update(folder) == 2
    assert "no space left" in capsys.readouterr().err
    assert written(folder) == before
    # What was found is told all the same.
    assert update(folder, "--json") == 2
    told = json.loads(capsys.readouterr().out)
    assert told["cameras"]["cam2"]["status"] == "moved"
    assert told["updated"] == []
    assert not told["ok"]


def test_while_another_run_is_at_work(core, folder, capsys):
    with Folder(folder):
        assert update(folder) == 2
    assert "another run of epibar" in capsys.readouterr().err
    assert core.__dict__.get("names") is None


def test_a_network_that_no_run_wrote(core, tmp_path, capsys):
    network().save(tmp_path / "network.json")
    assert main(["check", str(tmp_path), "cam1.npz", "cam2.npz", "--update"]) == 2
    assert "not written by epibar" in capsys.readouterr().err
