"""``epibar check --update`` with a camera that the network does not have: what is printed and written."""

import json
from dataclasses import replace

import numpy as np
import pytest
from check_input import FEW, films, network, replaced, some_masks, write_run
from extended_input import REFUSED, refused_pair

import epibar
from epibar import EpibarError, _core
from epibar.cli import main
from epibar.files import network_json
from epibar.lens import Intrinsics, write_cameras
from epibar.lens.cameras_toml import load_cameras
from epibar.network import pair_search


@pytest.fixture
def folder(tmp_path):
    """What a run of four cameras leaves, as far as an addition touches it; and films of a fifth."""
    write_run(tmp_path, network(), [])
    for k, name in enumerate(("cam1", "cam2", "cam3", "cam9", "other")):
        np.savez_compressed(tmp_path / f"{name}.npz", masks=some_masks(k), fps=25.0)
    return tmp_path


def run(folder, names, *more):
    videos = [str(folder / f"{name}.npz") for name in names]
    return main(["check", str(folder), *videos, *FEW, *more])


FILES = ("network.json", "cameras.toml", "calibration.json")


def written(folder):
    return {name: (folder / name).read_bytes() for name in FILES}


def test_every_file_holds_the_camera_that_was_added(adding, folder, capsys):
    assert run(folder, ("cam1", "cam2", "cam3", "cam9"), "--update") == 0
    printed = capsys.readouterr()
    assert "added: cam9: calibrated: well" in printed.out
    assert "nothing was updated" not in printed.out
    now = epibar.Network.load(folder / "network.json")
    assert now.cameras["cam9"].accepted
    known = {camera.name: camera for camera in load_cameras(folder / "cameras.toml")}
    assert np.allclose(known["cam9"].matrix, adding.place["matrix"])
    assert np.allclose(known["cam9"].distortions, adding.place["distortions"])
    content = json.loads((folder / "calibration.json").read_text())
    alone = json.loads((folder / "network.json").read_text())
    assert alone == {"$schema": network_json.SCHEMA, **content["network"]}
    assert [one["name"] for one in content["cameras"]] == ["cam1", "cam2", "cam3", "cam4"]
    epibar.export.Run.load(folder)
    # From now on it is one of the network's.
    assert run(folder, ("cam1", "cam2", "cam9")) == 0


def test_without_update_it_is_said_and_the_others_are_checked(adding, folder, capsys):
    before = written(folder)
    assert run(folder, ("cam1", "cam2", "cam9"), "--json") == 4
    printed = capsys.readouterr()
    assert (
        "cam9: the network has no camera of that name, it has cam1, cam2, cam3, cam4; --update adds it"
        in (printed.err)
    )
    result = json.loads(printed.out)
    assert result["ok"] is False
    assert result["cameras"].keys() == {"cam1", "cam2"}
    assert result["not_added"].keys() == {"cam9"}
    assert "added" not in result
    assert written(folder) == before


def test_for_programs(core, adding, folder, capsys):
    core.verdicts = {"cam2": replaced(network().cameras["cam2"], ["cam1", "cam3"])}
    assert run(folder, ("cam1", "cam2", "cam3", "cam9", "other"), "--update", "--json") == 4
    printed = capsys.readouterr()
    result = json.loads(printed.out, parse_constant=pytest.fail)
    assert result["updated"] == ["cam2"]
    assert result["added"].keys() == {"cam9"}
    assert result["added"]["cam9"]["matrix"][0][0] == 650.0
    assert result["not_added"] == {"other": REFUSED}
    assert "cam2 had no part in that" in printed.err
    assert adding.names == ["cam1", "cam3", "cam9", "other"]
    now = epibar.Network.load(folder / "network.json")
    assert np.allclose(now.cameras["cam2"].rotation, core.verdicts["cam2"]["place"]["rotation"])
    assert "other" not in now.cameras


def test_nothing_is_written_where_nothing_is_added(adding, folder, capsys):
    before = written(folder)
    assert run(folder, ("cam1", "cam2", "other"), "--update") == 4
    assert f"other was not added: {REFUSED}" in capsys.readouterr().out
    assert written(folder) == before


def test_a_new_camera_that_cannot_be_read(adding, folder, capsys):
    (folder / "cam9.npz").write_bytes(b"damaged")
    assert run(folder, ("cam1", "cam2", "cam9"), "--update", "--json") == 3
    result = json.loads(capsys.readouterr().out)
    assert "not recorded" in result["not_added"]["cam9"]
    assert result["cameras"].keys() == {"cam1", "cam2"}


def test_what_was_updated_is_written_where_adding_fails(core, monkeypatch, folder, capsys):
    """And it is told why nothing was added."""
    core.verdicts = {"cam2": replaced(network().cameras["cam2"], ["cam1", "cam3"])}

    def fails(*_):
        raise ValueError("cameras = 'cam9': expected another")

    monkeypatch.setattr(_core, "add_cameras", fails)
    monkeypatch.setattr(pair_search, "calibrate", lambda *_, **__: refused_pair())
    assert run(folder, ("cam1", "cam2", "cam3", "cam9"), "--update", "--json") == 4
    result = json.loads(capsys.readouterr().out)
    assert result["updated"] == ["cam2"]
    assert "expected another" in result["not_added"]["cam9"]
    now = epibar.Network.load(folder / "network.json")
    assert np.allclose(now.cameras["cam2"].rotation, core.verdicts["cam2"]["place"]["rotation"])


def test_names_that_differ_by_case_are_one_camera(adding, folder, capsys):
    (folder / "cam1.npz").rename(folder / "Cam1.npz")
    before = written(folder)
    assert run(folder, ("Cam1", "cam2", "cam3"), "--update") == 2
    assert "Cam1 and cam1 differ by upper and lower case only" in capsys.readouterr().err
    assert written(folder) == before
    with pytest.raises(EpibarError, match="Cam1 and cam1 differ by upper and lower case"):
        network().extended(films("Cam1", "cam2", "cam3"), 0, 0.0)


def test_one_camera_of_the_network_is_too_few(adding, folder, capsys):
    assert run(folder, ("cam1", "cam9"), "--update") == 2
    assert "to add cam9 new footage of at least two cameras of the network is needed" in (
        capsys.readouterr().err
    )


def test_a_lens_file_of_the_new_camera_alone(adding, folder):
    """The others were calibrated without, so they need none."""
    path = folder / "lenses.toml"
    write_cameras(path, [Intrinsics("cam9", (640, 480), adding.place["matrix"])])
    assert run(folder, ("cam1", "cam2", "cam9"), "--update", "--intrinsics", str(path)) == 0
    assert adding.known[0]["matrix"] == adding.place["matrix"].tolist()


def test_lenses_of_new_cameras(adding, folder, capsys):
    """They are held, and are not taken out of the films."""
    net, matrix = network(), adding.place["matrix"]
    of_net = [Intrinsics(name, (640, 480), net.cameras[name].matrix) for name in ("cam1", "cam2")]
    lens = Intrinsics("cam9", (640, 480), matrix, np.array([-0.1, 0, 0, 0, 0]))
    path = folder / "lenses.toml"
    write_cameras(path, [*of_net, lens])
    assert run(folder, ("cam1", "cam2", "cam9"), "--update", "--intrinsics", str(path)) == 0
    assert adding.known[0]["matrix"] == matrix.tolist()
    assert adding.known[0]["distortions"][0] == -0.1
    # The network has it now, and a film with its lens is checked.
    assert run(folder, ("cam1", "cam2", "cam9"), "--intrinsics", str(path)) == 0
    net.save(folder / "network.json")
    write_cameras(path, [*of_net, replace(lens, size=(320, 240))])
    assert run(folder, ("cam1", "cam2", "cam9"), "--update", "--intrinsics", str(path)) == 4
    assert "its lens is of 320x240 frames, and these are 640x480" in capsys.readouterr().out
    write_cameras(path, [*of_net, replace(lens, distortions=np.zeros(4), fisheye=True)])
    assert run(folder, ("cam1", "cam2", "cam9"), "--update", "--intrinsics", str(path)) == 2
    assert "fisheye" in capsys.readouterr().err
