"""One more camera for a network: what the compiled module is asked, what is refused, and the real thing."""

import functools
import json
import logging
from dataclasses import replace

import numpy as np
import pytest
from check_input import FEW, MOVED, UNSURE, films, network, replaced, some_masks, stand_in, write_run
from network_input import looking_at

import epibar
from epibar import EpibarError, Recording, _core, synthetic
from epibar.calibration import Calibration
from epibar.cli import main
from epibar.geometry.cameras import fundamental_from_cameras
from epibar.lens import Intrinsics, write_cameras
from epibar.lens.cameras_toml import load_cameras
from epibar.network import ClockOffsets, KnownCamera, NetworkClock, extending, pair_search
from epibar.network.core_parts import camera_of

REFUSED = "left out: what moves in it does not move as in the other cameras"


class Adding:
    """Stands for the compiled module: cam9 stands where it is told, other names are refused."""

    def __init__(self):
        self.R, t = looking_at((0.7, 0.7, 0.5))
        self.place = {
            "matrix": np.array([[650.0, 0, 319.5], [0, 650.0, 239.5], [0, 0, 1]]),
            "distortions": np.array([-0.1, 0.0, 0.0, 0.0, 0.0]),
            "rotation": self.R,
            "translation": t,
            "expected": {"focal": 0.012, "rotation": 0.3, "position": 0.004},
            "position_covariance": np.eye(3) * 1e-6,
        }

    def __call__(self, recordings, names, stored, known, pairs, clocks, progress):
        self.names, self.stored, self.known, self.pairs, self.clocks = names, stored, known, pairs, clocks
        if progress is not None:
            progress("network", 1.0)
        nothing = dict.fromkeys(self.place)
        answers, found = [], []
        for k, name in enumerate(names[len(stored) :], len(stored)):
            ok = name == "cam9"
            answers.append(
                {
                    "name": name,
                    "accepted": ok,
                    "status": "accepted" if ok else "nothing_in_common",
                    "reason": "calibrated: well" if ok else REFUSED,
                    **(self.place if ok else nothing),
                    "deviates": (9.0, 7.0),
                    "clock": (0.25, 20.0) if ok else None,
                    "offset_error": 0.001,
                }
            )
            found += [
                {
                    "a": a,
                    "b": k,
                    "status": "confirmed" if ok else "outside",
                    "accepted": ok,
                    "F": np.eye(3) / 3**0.5 if ok else None,
                    "deviates": (6.0, 5.0),
                }
                for a in range(k)
            ]
        return {"cameras": answers, "pairs": found}


@pytest.fixture
def core(monkeypatch):
    return stand_in(monkeypatch)


@pytest.fixture
def adding(core, monkeypatch):
    stub = Adding()
    monkeypatch.setattr(_core, "add_cameras", stub)
    stub.searched = []

    def searched(rec_a, rec_b, **options):
        stub.searched.append(options)
        if options["progress"] is not None:
            options["progress"]("search", 1.0)
        return refused_pair()

    monkeypatch.setattr(pair_search, "calibrate", searched)
    return stub


@functools.cache
def refused_pair():
    one, other = (Recording.from_masks(some_masks(k), lines=50) for k in (0, 5))
    found = epibar.calibrate(one, other, time_offset=0.0)
    assert isinstance(found, Calibration)
    return found


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


# --- on the command line ---


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
    assert content["network"] == json.loads((folder / "network.json").read_text())
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


def test_a_camera_whose_clock_is_not_known_has_no_part(adding, monkeypatch):
    offsets = ClockOffsets((0.0, float("nan"), 0.0, 1.5))
    monkeypatch.setattr(extending, "_clocks", lambda *_: offsets)
    more = network().extended(films("cam1", "cam2", "cam3", "cam9"))
    assert adding.names == ["cam1", "cam3", "cam9"]
    assert adding.clocks == ([0.0, 0.0, 1.5], False, False)
    assert "cam9" in more.cameras
    monkeypatch.setattr(extending, "_clocks", lambda *_: replace(offsets, seconds=(0.0, *[float("nan")] * 3)))
    assert "cam9" not in network().extended(films("cam1", "cam2", "cam3", "cam9")).cameras


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
