"""Walkers as tracks: places against the truth, the file and its way back, and what a run leaves of them."""

import csv
import functools
from dataclasses import replace

import numpy as np
import pytest
from network_input import recordings, situation

import epibar
from epibar.network import Ground, NetworkCamera, NetworkClock, WalkerTracks
from epibar.network.parts import NetworkPairs
from epibar.network.tracks_csv import load_tracks
from epibar.synthetic.figures import between


@functools.cache
def true_network():
    """The cameras of :func:`situation` as they are, in metres."""
    made, cameras, clocks = situation(), {}, {}
    for k, name in enumerate(recordings()):
        camera = made.cameras[k]
        cameras[name] = NetworkCamera(
            name,
            camera.size,
            True,
            "accepted",
            "true",
            matrix=camera.K,
            distortions=np.zeros(5),
            rotation=camera.R,
            translation=camera.t,
            expected={"focal": 0.0, "rotation": 0.0, "position": 0.0},
        )
        clocks[name] = NetworkClock(*made.clock_between(0, k), 0.0)
    ground = Ground("floor", 1.72, 0.0, 1000, 0.05)
    return epibar.Network(cameras, NetworkPairs([]), clocks, True, "true", "metre", ground)


@functools.cache
def tracks():
    return true_network().tracks(recordings())


def heights_and_places(seconds):
    """Of all walkers at moments of the first camera: (K, N, 2), and (N,)."""
    made = situation()
    world = made.films[0].world
    places = [between(group.track.position, made.clocks[0].start + seconds) for group in world.movers]
    return np.concatenate(places, axis=1), np.concatenate([group.height for group in world.movers])


def test_tracks_are_where_walkers_are():
    found = tracks()
    assert len(found) > 300
    places, heights = heights_and_places(found.time)
    # Above the body is the head; feet step before and behind it.
    apart = np.linalg.norm(places - found.top[:, None, :2], axis=2)
    nearest = apart.argmin(axis=1)
    assert (apart.min(axis=1) < 0.4).mean() > 0.99
    assert np.median(apart.min(axis=1)) < 0.08
    assert np.median(np.abs(found.height - heights[nearest])) < 0.05
    assert np.abs(found.foot[:, 2]).max() < 0.3
    owners = [np.bincount(nearest[found.track == track]) for track in np.unique(found.track)]
    assert sum(owner.max() for owner in owners) > 0.99 * len(found)


def test_the_arrays_belong_together():
    found = tracks()
    m, n = len(found.time), 3
    assert found.names == ("cam1", "cam2", "cam3")
    assert (found.foot.shape, found.top.shape, found.cameras.shape) == ((m, 3), (m, 3), (m, n))
    assert found.height.shape == found.residual.shape == found.track.shape == (m,)
    assert found.cameras.dtype == bool
    assert (found.cameras.sum(axis=1) >= 2).all()
    assert np.isin(found.time, recordings()["cam1"].times).all()
    assert (np.diff(found.track) >= 0).all()
    for track in np.unique(found.track):
        assert (np.diff(found.time[found.track == track]) > 0).all()
    assert list(np.unique(found.track)) == list(range(found.track.max() + 1))
    assert "metre" in repr(found)


def test_the_unit_is_that_of_the_network():
    """The same cameras in another unit have the same tracks in that unit."""
    net = true_network()
    small = replace(
        net,
        unit="baseline",
        ground=replace(net.ground, height=net.ground.height / 8),
        cameras={n: replace(c, translation=c.translation / 8) for n, c in net.cameras.items()},
    )
    found = small.tracks(recordings())
    np.testing.assert_array_equal(found.track, tracks().track)
    np.testing.assert_allclose(8 * found.top, tracks().top, atol=1e-9)
    assert found.unit == "baseline"


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_files_hold_all(tmp_path, suffix):
    found, path = tracks(), tmp_path / f"tracks{suffix}"
    found.save(path)
    if suffix == ".csv":
        again = load_tracks(path)
        assert (again.names, again.unit) == (found.names, found.unit)
        rows = list(csv.DictReader(path.read_text().splitlines()))
        assert [int(row["cameras"]) for row in rows] == found.cameras.sum(axis=1).tolist()
        assert [row["seen by cam2"] == "1" for row in rows] == found.cameras[:, 1].tolist()
        heights = [float(row["height"]) for row in rows]
        np.testing.assert_allclose(heights, found.height, atol=6e-5)
        values = {
            name: getattr(again, name) for name in ("time", "track", "foot", "top", "cameras", "residual")
        }
    else:
        with np.load(path, allow_pickle=False) as values:
            values = dict(values)
        np.testing.assert_array_equal(values["height"], found.height)
        assert values["names"].tolist() == list(found.names)
    for name in ("time", "track", "foot", "top", "cameras", "residual"):
        np.testing.assert_allclose(values[name], getattr(found, name), atol=6e-4, err_msg=name)


def some(names=("=cam()", "b"), count=3):
    """Tracks of which only the form matters."""
    return WalkerTracks(
        names,
        "baseline",
        np.arange(count) / 25,
        np.zeros(count, np.int64),
        np.zeros((count, 3)),
        np.ones((count, 3)),
        np.ones((count, 2), bool),
        np.zeros(count),
    )


def test_a_spreadsheet_sees_no_formula(tmp_path):
    some(("=cam()", "\rb")).save(tmp_path / "tracks.csv")
    for row in csv.reader((tmp_path / "tracks.csv").read_text().splitlines()):
        assert not any(cell[:1] in "=+@" for cell in row if cell)
        assert len(row) == 14
    again = load_tracks(tmp_path / "tracks.csv")
    assert again.names[0] == "=cam()"


def test_no_walker_is_a_table_without_rows(tmp_path):
    some(count=0).save(tmp_path / "tracks.csv")
    again = load_tracks(tmp_path / "tracks.csv")
    assert len(again) == 0
    assert again.names == ("=cam()", "b")


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(epibar.EpibarError, match="tracks are written as"):
        some().save(tmp_path / "tracks.json")


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: "",
        lambda text: text.replace("time,", "tims,"),
        lambda text: text.replace("0.0400", "nan"),
        lambda text: text.replace("0.0400", "many"),
        lambda text: text.replace("baseline", "furlong"),
        lambda text: text + "1,2,3\n",
        lambda text: text.replace(",1,1\n", ",1,2\n"),
        lambda text: text.replace("0.0400,0,", "0.0400,-1,"),
        lambda text: text + '"' + "x" * 200_000,
    ],
)
def test_a_damaged_table_is_refused(tmp_path, damage):
    path = tmp_path / "tracks.csv"
    some(("a", "b")).save(path)
    path.write_text(damage(path.read_text()))
    with pytest.raises(epibar.EpibarError, match="damaged"):
        load_tracks(path)


def test_what_cannot_be_followed():
    net, films = true_network(), recordings()
    flat = replace(net, ground=Ground("cameras"))
    with pytest.raises(epibar.EpibarError, match="floor"):
        flat.tracks(films)
    with pytest.raises(epibar.EpibarError, match="no camera of that name"):
        net.tracks({**films, "other": films["cam1"]})
    cameras = {**net.cameras, "cam2": replace(net.cameras["cam2"], accepted=False)}
    refused = replace(net, accepted=False, cameras=cameras)
    assert refused.tracks(films).names == ("cam1", "cam3")
    with pytest.raises(epibar.EpibarError, match="two accepted cameras"):
        refused.tracks({"cam1": films["cam1"], "cam2": films["cam2"]})
    smaller = {**net.cameras, "cam2": replace(net.cameras["cam2"], size=(64, 48))}
    with pytest.raises(epibar.EpibarError, match="calibrated at 64x48"):
        replace(net, cameras=smaller).tracks(films)
    lost = replace(net, clocks={**net.clocks, "cam3": NetworkClock()})
    with pytest.raises(epibar.EpibarError, match="no clock"):
        lost.tracks(films)


def test_progress_is_told_and_may_stop_it():
    told = []
    true_network().tracks(recordings(), progress=lambda stage, share: told.append((stage, share)))
    assert {stage for stage, _ in told} == {"tracks"}

    class Enough(Exception):
        pass

    def stop(stage, share):
        raise Enough

    with pytest.raises(Enough):
        true_network().tracks(recordings(), progress=stop)
