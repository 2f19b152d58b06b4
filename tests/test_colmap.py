"""Points of a COLMAP model: where they are, what was measured of them, and what COLMAP makes of them."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_formats_input import POINTS, expected, inside, network, pixels, walkers
from network_input import calibrated, recordings

from epibar import EpibarError, FrontierPoints
from epibar.camera_export import colmap
from epibar.cli import main
from epibar.files.json_file import write_json
from epibar.lens import Intrinsics
from epibar.network.parts import NetworkPairs
from epibar.network.sightings import WalkerSightings

pycolmap = pytest.importorskip("pycolmap", reason="pycolmap, the extra 'colmap', is not installed")

LENS = (-0.2, 0.05, 0.001, -0.002, 0)


def frontier_points(seen_a, seen_b, frames=None):
    frames = np.arange(len(seen_a)) if frames is None else frames
    return FrontierPoints(frames, seen_a, seen_b, np.zeros(len(seen_a)))


def both_see(net, a="cam1", b="cam2", count=300):
    """Points inside the images of two cameras, and their pixels."""
    seen = [expected(net.cameras[name]) for name in (a, b)]
    good = inside(seen[0], net.cameras[a]) & inside(seen[1], net.cameras[b])
    return POINTS[good][:count], seen[0][good][:count], seen[1][good][:count]


def measured(model):
    """Of each point its place, and its pixels by the names of cameras, from the centre of the first."""
    found = []
    for _, point in sorted(model.points3D.items()):
        at = {}
        for element in point.track.elements:
            image = model.image(element.image_id)
            at[image.name] = image.points2D[element.point2D_idx].xy - 0.5
        found.append((point.xyz, at))
    return found


def test_names_with_blanks_are_one_word_each(tmp_path):
    net = network(3)
    cameras = {
        name: replace(camera, name=name)
        for name, camera in zip(("cam 1", "cam 2", "cam_2"), net.cameras.values(), strict=True)
    }
    clocks = dict(zip(cameras, net.clocks.values(), strict=True))
    replace(net, cameras=cameras, clocks=clocks, pairs=NetworkPairs([])).export(tmp_path / "c", "colmap")
    model = pycolmap.Reconstruction(tmp_path / "c")
    assert sorted(image.name for image in model.images.values()) == ["cam_1", "cam_2", "cam_2_3"]
    assert "renamed: cam 1: it is cam_1" in (tmp_path / "c" / "README.txt").read_text()


def test_another_programs_model_stays(tmp_path):
    net = network(3)
    own, theirs, bare = (tmp_path / name for name in ("own", "theirs", "bare"))
    net.export(own, "colmap")
    net.export(own, "colmap")
    theirs.mkdir()
    (theirs / "README.txt").write_text("of the hall, measured by hand")
    (theirs / "cameras.bin").write_bytes(b"1")
    with pytest.raises(EpibarError, match=r"theirs: holds README.txt, cameras.bin, which epibar did not"):
        net.export(theirs, "colmap")
    assert sorted(path.name for path in theirs.iterdir()) == ["README.txt", "cameras.bin"]
    bare.mkdir()
    (bare / "points3D.txt").write_text("")
    with pytest.raises(EpibarError, match=r"bare: holds points3D.txt"):
        net.export(bare, "colmap")
    (bare / "points3D.txt").rename(bare / "notes.txt")
    net.export(bare, "colmap")
    assert (bare / "notes.txt").exists()


@pytest.mark.parametrize(
    ("points", "told"),
    [
        (3, "frontier_points is a int"),
        ({"cam1": 3}, "frontier_points\\['cam1'\\]: expected the names of two cameras"),
        ({("cam1", "cam2"): 3}, "frontier_points.*is a int, expected FrontierPoints"),
    ],
)
def test_points_that_are_none_are_refused(tmp_path, points, told):
    with pytest.raises(EpibarError, match=told):
        network(3).export(tmp_path / "m", "colmap", frontier_points=points)


def test_what_two_cameras_see_is_a_point(tmp_path):
    net = network(4, distortions=LENS)
    places, seen_a, seen_b = both_see(net)
    assert len(places) > 100
    points = {("cam1", "cam2"): frontier_points(seen_a, seen_b)}
    net.export(tmp_path / "model", format="colmap", frontier_points=points)
    model = pycolmap.Reconstruction(tmp_path / "model")
    assert model.num_points3D() == len(places)
    assert f"{len(places)} points, each seen by two cameras" in (tmp_path / "model/README.txt").read_text()
    for (place, at), true, a, b in zip(measured(model), places, seen_a, seen_b, strict=True):
        np.testing.assert_allclose(place, true, atol=1e-5)
        assert list(at) == ["cam1", "cam2"]
        np.testing.assert_allclose(at["cam1"], a, atol=1e-9)
        np.testing.assert_allclose(at["cam2"], b, atol=1e-9)
    assert model.compute_mean_reprojection_error() < 1e-3


def test_a_lens_that_was_taken_out_is_put_back(tmp_path):
    net = network(3, distortions=np.zeros(5))
    places, seen_a, seen_b = both_see(net)
    lenses = {
        "cam1": Intrinsics("cam1", (640, 480), net.cameras["cam1"].matrix, [-0.3, 0.1, 0, 0, 0]),
        "cam2": Intrinsics(
            "cam2", (640, 480), net.cameras["cam2"].matrix, [0.1, 0.02, 0, 0.01], fisheye=True
        ),
    }
    points = {("cam1", "cam2"): frontier_points(seen_a, seen_b)}
    net.export(tmp_path / "model", format="colmap", lenses=lenses, frontier_points=points)
    one, other = net.cameras["cam1"], net.cameras["cam2"]
    bent_a = pixels(one.matrix, lenses["cam1"].distortions, one.rotation, one.translation, places)
    turn = cv2.Rodrigues(other.rotation)[0]
    fisheye = cv2.fisheye.projectPoints
    k = lenses["cam2"].distortions
    bent_b = fisheye(places[:, None], turn, other.translation, other.matrix, k)[0][:, 0]
    model = pycolmap.Reconstruction(tmp_path / "model")
    found = measured(model)
    assert len(found) == len(places)
    np.testing.assert_allclose([at["cam1"] for _, at in found], bent_a, atol=1e-6)
    np.testing.assert_allclose([at["cam2"] for _, at in found], bent_b, atol=1e-6)
    np.testing.assert_allclose([place for place, _ in found], places, atol=1e-4)


def test_what_does_not_meet_is_left_out_and_much_is_thinned(tmp_path, monkeypatch):
    net = network(4, distortions=LENS)
    _, seen_a, seen_b = both_see(net, count=100)
    few = frontier_points(*both_see(net, "cam2", "cam3", 5)[1:])
    wrong = seen_b + np.where(np.arange(len(seen_b)) < 10, 30.0, 0.0)[:, None]
    net.export(
        tmp_path / "one", format="colmap", frontier_points={("cam1", "cam2"): frontier_points(seen_a, wrong)}
    )
    assert pycolmap.Reconstruction(tmp_path / "one").num_points3D() <= len(seen_a) - 9
    monkeypatch.setattr(colmap, "MOST_POINTS", 60)
    frames = np.arange(len(seen_a))[::-1]
    many = {("cam2", "cam1"): frontier_points(seen_b, seen_a, frames), ("cam2", "cam3"): few}
    net.export(tmp_path / "two", format="colmap", frontier_points=many)
    model = pycolmap.Reconstruction(tmp_path / "two")
    found = [at for _, at in measured(model)]
    assert [list(at) for at in found] == 30 * [["cam2", "cam1"]] + 5 * [["cam2", "cam3"]]
    # The first and the last in time, and what lies between.
    np.testing.assert_allclose([at["cam1"] for at in found[:30:29]], seen_a[::-1][[0, -1]])


def test_pairs_that_are_not_accepted_have_no_points(tmp_path):
    net = network(4, distortions=LENS)
    _, seen_a, seen_b = both_see(net)
    points = {("cam1", "cam2"): frontier_points(seen_a, seen_b)}
    pairs = [
        replace(pair, accepted=key != ("cam1", "cam2"), status="contradicts")
        for key, pair in net.pairs.items()
    ]
    replace(net, pairs=NetworkPairs(pairs)).export(tmp_path / "m", format="colmap", frontier_points=points)
    assert pycolmap.Reconstruction(tmp_path / "m").num_points3D() == 0
    with pytest.raises(EpibarError, match="no camera of that name"):
        net.export(tmp_path / "n", format="colmap", frontier_points={("cam1", "x"): points["cam1", "cam2"]})
    with pytest.raises(EpibarError, match="'gltf' has no place for frontier points"):
        net.export(tmp_path / "n.gltf", format="gltf", frontier_points=points)
    with pytest.raises(EpibarError, match="no sightings"):
        net.export(tmp_path / "n", format="colmap", tracks=walkers())
    assert not (tmp_path / "n").exists()


def test_walkers_come_before_frontier_points_of_their_cameras(tmp_path):
    """Tops and bottoms are those of the images, where a place says that cameras saw them."""
    net = network(3, distortions=LENS)
    _, seen_a, seen_b = both_see(net, "cam1", "cam2", 8)
    tracks = walkers()
    seen = np.stack([seen_a, seen_b], axis=1)
    sightings = WalkerSightings(np.arange(4)[::-1], np.tile([0, 1], (4, 1)), seen[:4], seen[4:])
    tracks = replace(tracks, sightings=sightings)
    others = both_see(net, "cam2", "cam3", 5)[1:]
    points = {("cam2", "cam1"): frontier_points(seen_b, seen_a), ("cam2", "cam3"): frontier_points(*others)}
    net.export(tmp_path / "m", format="colmap", tracks=tracks, frontier_points=points)
    found = measured(pycolmap.Reconstruction(tmp_path / "m"))
    assert [list(at) for _, at in found] == 8 * [["cam1", "cam2"]] + 5 * [["cam2", "cam3"]]
    # In the order of time, a top and its bottom.
    order = np.array([3, 7, 2, 6, 1, 5, 0, 4])
    np.testing.assert_allclose([at["cam1"] for _, at in found[:8]], seen_a[order])


@pytest.fixture(scope="module")
def tracked():
    return calibrated().tracks(recordings())


@pytest.fixture(scope="module")
def folder(tracked, tmp_path_factory):
    path = tmp_path_factory.mktemp("colmap") / "model"
    calibrated().export(path, format="colmap", tracks=tracked)
    return path


def test_sightings_are_of_the_places(tracked):
    seen = tracked.sightings
    assert len(seen) > 100
    assert seen.place.shape == (len(seen),)
    assert seen.cameras.shape == (len(seen), 2)
    assert seen.top.shape == seen.foot.shape == (len(seen), 2, 2)
    assert (seen.cameras[:, 0] < seen.cameras[:, 1]).all()
    assert np.take_along_axis(tracked.cameras[seen.place], seen.cameras, axis=1).all()
    # The lowest foot is another one in another camera.
    for end, places, most in ((seen.top, tracked.top, 10), (seen.foot, tracked.foot, 30)):
        off = []
        for row, side in np.ndindex(len(seen), 2):
            camera = calibrated().cameras[tracked.names[seen.cameras[row, side]]]
            place = places[seen.place[row]][None]
            shown = pixels(camera.matrix, camera.distortions, camera.rotation, camera.translation, place)[0]
            off.append(np.linalg.norm(shown - end[row, side]))
        assert np.median(off) < 1.5
        assert np.quantile(off, 0.95) < most


def test_points_of_walkers_fit_what_was_measured(tracked, folder):
    model = pycolmap.Reconstruction(folder)
    ends = np.concatenate([tracked.sightings.top, tracked.sightings.foot]).reshape(-1, 2)
    found = measured(model)
    assert len(found) > 0.9 * len(ends) / 2
    for _, at in found[::20]:
        for pixel in at.values():
            assert np.abs(ends - pixel).sum(axis=1).min() < 1e-9
    errors = [point.error for point in model.points3D.values()]
    assert np.median(errors) < 0.5
    assert max(errors) <= pycolmap.IncrementalMapperOptions().filter_max_reproj_error
    height = calibrated().ground.height
    # On the floor, or where heads are.
    z = np.array([place[2] for place, _ in found])
    assert np.median(np.minimum(np.abs(z), np.abs(z - height))) < 0.1 * height


def poses(model):
    """Rotations and places of the cameras, by name."""
    found = {image.name: image.cam_from_world() for image in model.images.values()}
    rotations = {name: pose.rotation.matrix() for name, pose in found.items()}
    return rotations, {name: -rotations[name].T @ pose.translation for name, pose in found.items()}


def moved(before, after):
    """Degrees and lengths of each camera, after the similarity that lays one best over the other."""
    (R, c), (S, d) = poses(before), poses(after)
    names = list(R)
    there, here = (np.array([places[name] for name in names]) for places in (c, d))
    size = np.linalg.norm(there - there.mean(axis=0))
    votes = sum(R[name].T @ S[name] for name in names)
    votes = votes + (there - there.mean(axis=0)).T @ (here - here.mean(axis=0)) / size**2
    u, _, v = np.linalg.svd(votes)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    off = (here - here.mean(axis=0)) @ turn.T
    off *= np.linalg.norm(there - there.mean(axis=0)) / np.linalg.norm(off)
    shifted = np.linalg.norm(off + there.mean(axis=0) - there, axis=1)
    angles = [np.degrees(np.linalg.norm(cv2.Rodrigues(S[name] @ turn.T @ R[name].T)[0])) for name in names]
    return {name: (angle, float(shift)) for name, angle, shift in zip(names, angles, shifted, strict=True)}


def adjusted(model):
    options = pycolmap.BundleAdjustmentOptions(
        refine_focal_length=False, refine_extra_params=False, print_summary=False
    )
    options.ceres.loss_function_type = pycolmap.LossFunctionType.CAUCHY
    pycolmap.bundle_adjustment(model, options)
    return model


def test_colmaps_own_adjustment_moves_nothing_beyond_what_is_stated(folder):
    model = adjusted(pycolmap.Reconstruction(folder))
    found = moved(pycolmap.Reconstruction(folder), model)
    assert any(angle > 1e-3 for angle, _ in found.values())
    for name, (angle, shift) in found.items():
        stated = calibrated().cameras[name].expected
        assert angle < stated["rotation"], name
        assert shift < stated["position"], name


def test_the_points_bring_a_turned_camera_back(folder):
    """Its rotation: only two of three pairs share walkers here, so nothing holds the ratio of baselines."""
    start, turned = pycolmap.Reconstruction(folder), pycolmap.Reconstruction(folder)
    image = turned.find_image_with_name("cam3")
    pose, by = image.cam_from_world(), pycolmap.Rotation3d(np.radians([0.0, 2.0, 0.0]))
    frame = turned.frame(image.frame_id)
    frame.rig_from_world = pycolmap.Rigid3d(by * pose.rotation, by * pose.translation)
    assert moved(start, turned)["cam3"][0] > 1
    for name, (angle, _) in moved(start, adjusted(turned)).items():
        assert angle < calibrated().cameras[name].expected["rotation"], name


def stored(folder, net, pairs=()):
    cameras = [
        {"name": name, "index": k, "width": c.size[0], "height": c.size[1], "matrix": None}
        for k, (name, c) in enumerate(net.cameras.items())
    ]
    content = {"format": 1, "intrinsics": None, "cameras": cameras, "pairs": list(pairs), "errors": []}
    write_json(folder / "calibration.json", {**content, "network": net.as_dict()})
    net.save(folder / "network.json")
    return ["export", str(folder), "--format", "colmap", "--cameras", "--out"]


def test_the_command_follows_walkers_anew(tmp_path, capsys):
    words = stored(tmp_path, calibrated())
    assert main([*words, str(tmp_path / "without")]) == 0
    assert "without tops and bottoms of walkers" in capsys.readouterr().err
    assert pycolmap.Reconstruction(tmp_path / "without").num_points3D() == 0
    (tmp_path / "recordings").mkdir()
    for name, film in recordings().items():
        film.save(tmp_path / "recordings" / f"{name}.npz")
    assert main([*words, str(tmp_path / "model")]) == 0
    assert "without" not in capsys.readouterr().err
    assert pycolmap.Reconstruction(tmp_path / "model").num_points3D() > 500
    content = json.loads((tmp_path / "calibration.json").read_text())
    for camera in content["cameras"]:
        camera["file"] = str(tmp_path / "given" / f"{camera['name']}.npz")
    (tmp_path / "calibration.json").write_text(json.dumps(content))
    (tmp_path / "recordings").rename(tmp_path / "given")
    assert main([*words, str(tmp_path / "of_given")]) == 0
    assert "without" not in capsys.readouterr().err
    assert pycolmap.Reconstruction(tmp_path / "of_given").num_points3D() > 500
    (tmp_path / "given").rename(tmp_path / "recordings")
    nothing = {"accepted": False, "reason": "", "F": None, "expected_error": None, "time_offset": 0.0}
    moved = [{"a": "cam1", "b": b, "kind": "moved", **nothing} for b in ("cam2", "cam3")]
    stands = {**moved[0], "a": "cam2", "b": "cam3", "kind": "degenerate"}
    assert main([*stored(tmp_path, calibrated(), [*moved, stands]), str(tmp_path / "later")]) == 0
    assert "without walkers in cam1, which moved" in capsys.readouterr().err
    found = measured(pycolmap.Reconstruction(tmp_path / "later"))
    assert {tuple(at) for _, at in found} == {("cam2", "cam3")}
