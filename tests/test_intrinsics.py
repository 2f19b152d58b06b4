"""Camera files, and lines that the lens bent."""

import cv2
import numpy as np
import pytest

import epibar
from epibar.errors import EpibarError
from epibar.lens.cameras_toml import find_camera, load_cameras, write_cameras
from epibar.lens.intrinsics import Intrinsics
from epibar.lens.undistortion import Undistorter

ONE = """
[cam_0]
name = "left"
size = [64, 48]
matrix = [[50.0, 0.0, 31.0], [0.0, 51.0, 23.0], [0.0, 0.0, 1.0]]
distortions = [-0.3, 0.1, 0.0, 0.0, 0.0]
rotation = [0.1, 0.2, 0.3]
translation = [1.0, 2.0, 3.0]
"""


def camera(distortions=(-0.3, 0.1, 0.001, -0.002, 0.0), size=(320, 240), fisheye=False, name="cam"):
    matrix = [[260.0, 0, 150.0], [0, 255.0, 125.0], [0, 0, 1]]
    return Intrinsics(name, size, matrix, distortions, fisheye)


def write(tmp_path, text):
    path = tmp_path / "cameras.toml"
    path.write_text(text)
    return path


def test_read(tmp_path):
    (left,) = load_cameras(write(tmp_path, ONE + "\n[metadata]\nerror = 0.5\nadjusted = true\n"))
    assert (left.name, left.size, left.fisheye, left.distorted) == ("left", (64, 48), False, True)
    assert left.matrix[1, 2] == 23
    pose = left.posed()
    assert np.allclose(pose.R, cv2.Rodrigues(np.array([0.1, 0.2, 0.3]))[0])
    assert np.array_equal(pose.t, [1, 2, 3])
    assert pose.size == (64, 48)


def test_caliscope_variations(tmp_path):
    text = """
    [cameras.1]
    port = 1
    size = [64, 48]
    rotation_count = 0
    fisheye = true
    matrix = [[50.0, 0.0, 31.0], [0.0, 51.0, 23.0], [0.0, 0.0, 1.0]]
    distortions = [0.1, 0.0, 0.0, 0.0]
    rotation = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    translation = [0, 0, 1]
    [cameras.2]
    size = [64, 48]
    matrix = [[50, 0, 31], [0, 51, 23], [0, 0, 1]]
    distortions = []
    """
    first, second = load_cameras(write(tmp_path, text))
    assert (first.name, first.fisheye, second.name, second.distorted) == ("1", True, "2", False)
    assert np.allclose(first.rotation, [np.pi / 2, 0, 0])
    with pytest.raises(EpibarError, match="2: no rotation"):
        second.posed()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("50.0", "nan", "matrix is .* not finite"),
        ("50.0", "-50.0", r"expected \[\[fx"),
        ("[50.0, 0.0", "[50.0, 2.0", "skew"),
        ("[0.0, 0.0, 1.0]]", "]", r"matrix (has shape|is)"),
        ("-0.3, 0.1", "inf, 0.1", "distortions is .* not finite"),
        ("-0.3, 0.1", "-0.3", None),
        ("-0.3, 0.1, ", "", r"3 distortions"),
        ("[64, 48]", "[64]", "size has shape"),
        ("[64, 48]", "[64, 0]", "size is"),
        ("[64, 48]", '"big"', "size is 'big', expected numbers"),
        ("size", "sizes", r"\[cam_0\] has no size"),
        ("distortions", "dist", r"\[cam_0\] has no distortions"),
        ("[0.1, 0.2, 0.3]", "[0.1, 0.2]", "rotation has shape"),
        ("[cam_0]", "[cam_0", "not a TOML file"),
        ("matrix", "k", r"has no matrix"),
    ],
)
def test_bad_files(tmp_path, old, new, message):
    path = write(tmp_path, ONE.replace(old, new))
    if message is None:
        assert len(load_cameras(path)[0].distortions) == 4
        return
    with pytest.raises(EpibarError, match=r"cameras.toml: .*" + message):
        load_cameras(path)


def test_no_cameras(tmp_path):
    with pytest.raises(EpibarError, match=r"none.toml: no such file"):
        load_cameras(tmp_path / "none.toml")
    with pytest.raises(EpibarError, match="no cameras"):
        load_cameras(write(tmp_path, "[metadata]\nerror = 1\n"))
    with pytest.raises(EpibarError, match="two cameras are called 'left'"):
        load_cameras(write(tmp_path, ONE + ONE.replace("cam_0", "cam_1")))


def test_written_is_read(tmp_path):
    posed = Intrinsics(
        'a "b" ü',
        (30, 20),
        camera().matrix,
        [1e-9, 0, 0, -2],
        True,
        rotation=[1, 2, 3],
        translation=[0, 1e30, 0],
    )
    write_cameras(tmp_path / "c.toml", [posed, camera(name="other")])
    again, other = load_cameras(tmp_path / "c.toml")
    assert (again.name, again.size, again.fisheye) == (posed.name, posed.size, True)
    for key in ("matrix", "distortions", "rotation", "translation"):
        assert np.array_equal(getattr(again, key), getattr(posed, key))
    assert other.rotation is None


def test_find_camera():
    cameras = [camera(name=name) for name in ("right", "Left", "left")]
    assert find_camera(cameras, "left", 0) is cameras[2]
    assert find_camera(cameras, "LEFT", 0) is cameras[1]
    assert find_camera(cameras, "GOPR0001", 1) is cameras[1]
    with pytest.raises(EpibarError, match=r"GOPR0001: no camera .* right, Left, left"):
        find_camera(cameras, "GOPR0001", 3)
    # A table that is of another video by its name serves nobody else.
    assert find_camera(cameras, "GOPR0001", 1, ["GOPR0001", "cam9"]) is cameras[1]
    with pytest.raises(EpibarError, match=r"GOPR0001: no camera of that name .* is that of another video"):
        find_camera(cameras, "GOPR0001", 2, ["Left", "right", "left", "GOPR0001"])


def test_size_mismatch():
    with pytest.raises(EpibarError, match=r"^cam2\.mp4: 640x480 frames, but its intrinsics are for 320x240$"):
        Undistorter(camera(), (640, 480), "cam2.mp4")
    with pytest.raises(EpibarError, match=r"^cam: 240x320 frames"):
        Undistorter(camera())(np.zeros((320, 240), np.uint8))


@pytest.mark.parametrize(
    "lens",
    [camera(), camera((0.05, -0.02, 0.01, 0.0), fisheye=True), camera((0.2, -0.1, 0, 0, 0, 0.01, 0, 0))],
)
def test_a_bent_disc_lands_where_the_pinhole_camera_sees_it(lens):
    rays = np.array([[[-0.35, -0.2, 1.0]], [[0.3, 0.25, 1.0]], [[0.0, 0.0, 1.0]], [[0.25, -0.3, 1.0]]])
    project = cv2.fisheye.projectPoints if lens.fisheye else cv2.projectPoints
    seen = project(rays, np.zeros(3), np.zeros(3), lens.matrix, lens.distortions)[0].reshape(-1, 2)
    undistort = Undistorter(lens, (320, 240))
    for ray, (x, y) in zip(rays[:, 0], seen, strict=True):
        yy, xx = np.mgrid[:240, :320]
        disc = (np.hypot(xx - x, yy - y) < 6).astype(np.uint8)
        straight = undistort(disc)
        assert set(np.unique(straight)) == {0, 1}
        found = np.argwhere(straight)[:, ::-1].mean(axis=0)
        assert np.allclose(found, (lens.matrix @ ray)[:2], atol=0.35)


def test_no_distortion_changes_nothing():
    mask = np.random.default_rng(0).integers(0, 2, (240, 320)).astype(bool)
    undistort = Undistorter(camera(np.zeros(5)))
    assert np.array_equal(undistort(mask), mask)
    assert undistort.valid.all()


def test_valid_area():
    pincushion = Undistorter(camera((0.4, 0.0, 0.0, 0.0)))  # the corners look past the sensor
    assert not pincushion.valid[0, 0]
    assert pincushion.valid[125, 150]
    # OpenCV 4 rounds sources to 1/32 px, so that a few pixels on the very edge may differ.
    assert np.count_nonzero(pincushion(np.ones((240, 320), np.uint8)) != pincushion.valid) < 10
    barrel = Undistorter(camera((-0.3, 0.1, 0.0, 0.0)))
    assert barrel.valid.all()


def test_a_polynomial_that_folds_back_shows_nothing_twice():
    folding = camera((-1.2, 0.0, 0.0, 0.0))  # r (1 - 1.2 r²) grows up to r = 0.527
    valid = Undistorter(folding).valid
    yy, xx = np.mgrid[:240, :320]
    radius = np.hypot((xx - 150) / 260, (yy - 125) / 255)
    assert not valid[radius > 0.53].any()
    assert valid[radius < 0.52].all()


def test_colour_images():
    image = np.random.default_rng(0).integers(0, 255, (240, 320, 3)).astype(np.uint8)
    lens = camera()
    expected = cv2.undistort(image, lens.matrix, lens.distortions)
    difference = np.abs(lens.undistort_image(image).astype(int) - expected)
    assert np.median(difference) <= 2
    assert lens.undistort_image(image).shape == image.shape


def disc_masks(tmp_path, count=40):
    """Ready masks of a disc that crosses an image of 160x120, as a file."""
    yy, xx = np.mgrid[:120, :160]
    path = tmp_path / "cam.npz"
    masks = [np.hypot(xx - 4 * index, yy - 60) < 14 for index in range(count)]
    np.savez(path, masks=np.array(masks), fps=25.0)
    return path


def test_what_is_visible_is_what_the_lens_saw_and_nobody_ignored(tmp_path):
    path = disc_masks(tmp_path)
    matrix = [[130.0, 0, 75.0], [0, 127.0, 62.0], [0, 0, 1]]
    pincushion = Intrinsics("cam", (160, 120), matrix, (0.4, 0.0, 0.0, 0.0))
    undistort = Undistorter(pincushion)
    ignore = np.zeros((120, 160), bool)
    ignore[:, 90:] = True
    lens = epibar.record(path, masks=True, lines=50, intrinsics=pincushion)
    both = epibar.record(path, masks=True, lines=50, intrinsics=pincushion, ignore=ignore)
    square = np.ones((5, 5), np.uint8)
    assert not undistort.valid.all()
    assert np.array_equal(lens.visible, cv2.erode(undistort.valid, square))
    # The edge of what is ignored is bent like everything else, and two pixels beside it are not visible.
    edge = np.stack([np.full(91, 89.5), np.arange(15.0, 106.0)], axis=1)
    straight = cv2.undistortPoints(
        edge[:, None], pincushion.matrix, pincushion.distortions, P=pincushion.matrix
    )
    ends = [np.flatnonzero(both.visible[round(y)]).max() + 0.5 for _, y in straight[:, 0]]
    assert np.ptp(ends) >= 1
    assert np.abs(straight[:, 0, 0] - 2 - ends).max() < 1
    assert not (both.visible & ~lens.visible).any()
    # A lens that fills the image hides nothing.
    barrel = Intrinsics("cam", (160, 120), matrix, (-0.3, 0.1, 0.0, 0.0))
    assert epibar.record(path, masks=True, lines=50, intrinsics=barrel).visible is None


def test_a_rotation_that_was_written_with_two_digits(tmp_path):
    turn = cv2.Rodrigues(np.array([0.3, -1.1, 0.6]))[0]
    text = "[a]\nsize = [640, 480]\nmatrix = [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\ndistortions = []\n"
    (tmp_path / "cameras.toml").write_text(
        f"{text}rotation = {turn.round(2).tolist()}\ntranslation = [0, 0, 0]"
    )
    (camera,) = epibar.load_cameras(tmp_path / "cameras.toml")
    assert np.abs(camera.posed().R - turn).max() < 0.01


def test_what_is_no_lens_is_refused(tmp_path):
    with pytest.raises(EpibarError, match="intrinsics is a int, expected Intrinsics or a path"):
        epibar.record(disc_masks(tmp_path), masks=True, lines=50, intrinsics=3)
