"""A network in metres, and what its cameras project, for the tests of camera files."""

from dataclasses import replace

import cv2
import numpy as np
from network_input import made_up

from epibar.network.walkers import WalkerTracks

METRES = 1.7 / 0.35
"""Of the made-up network, once people measure 1.7 m."""
POINTS = METRES * np.random.default_rng(0).uniform((-0.4, -0.4, 0.65), (0.4, 0.4, 1.35), (1000, 3))
HOSTILE = [
    "cam 1",
    'a "b"',
    "it's",
    "two\nlines",
    "../up",
    "=cmd",
    "Küche 東",
    "none",
    "a]b = 1",
    "\u202eb\x1b[31m",
]


def network(count=12, distortions=None, names=None):
    """A network in metres; its k3 is not 0."""
    net = made_up(count, refused=(), lost=()).scaled(person_height=1.7)
    cameras = {}
    for k, (name, camera) in enumerate(net.cameras.items()):
        lens = camera.distortions if distortions is None else np.array(distortions)
        new = names[k] if names else name
        cameras[new] = replace(camera, name=new, distortions=lens)
    return replace(net, cameras=cameras)


def walkers(began=2.0):
    """Tracks of two walkers, 1.7 m tall; the first is not seen for three seconds."""
    time = began + np.array([0.0, 0.5, 1.0, 4.0, 4.5, 0.5, 1.0, 1.5])
    foot = np.column_stack([0.2 * np.arange(8.0), np.sin(np.arange(8.0)), np.zeros(8)])
    return WalkerTracks(
        names=("cam1", "cam2"),
        unit="metre",
        time=time,
        track=np.array([0, 0, 0, 0, 0, 4, 4, 4]),
        foot=foot,
        top=foot + np.array([0.0, 0.0, 1.7]),
        cameras=np.ones((8, 2), bool),
        residual=np.full(8, 0.3),
    )


def pixels(K, distortions, R, t, points=POINTS):
    return cv2.projectPoints(points, cv2.Rodrigues(R)[0], np.asarray(t), K, np.asarray(distortions))[0][:, 0]


def expected(camera, distortions=None):
    lens = camera.distortions if distortions is None else np.array(distortions)
    return pixels(camera.matrix, lens, camera.rotation, camera.translation)


def inside(found, camera):
    return (found >= 0).all(axis=1) & (found < np.array(camera.size) - 1).all(axis=1)


def assert_projects(net, found, atol=1e-3):
    assert list(found) == list(net.cameras)
    for name, values in found.items():
        np.testing.assert_allclose(pixels(*values), expected(net.cameras[name]), atol=atol, err_msg=name)


def rerun_entities(path):
    """What a recording of Rerun holds: of each entity the last value of each component."""
    from rerun.chunk import RrdReader

    logged = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        entity = logged.setdefault(str(chunk.entity_path).replace("\\", ""), {})
        for name in batch.schema.names:
            column = batch.column(batch.schema.names.index(name))
            values = [one.as_py() for one in column if one.is_valid]
            entity.update({name: values[-1]} if values else {})
    return logged


def rerun_pixels(camera):
    """Where a camera of :func:`rerun_entities` sees the points."""
    (place,), (turn,) = camera["Transform3D:translation"], camera["Transform3D:mat3x3"]
    (lens,) = camera["Pinhole:image_from_camera"]
    R = np.array(turn).reshape(3, 3)  # column by column: its transpose, world to camera
    K = np.array(lens).reshape(3, 3).T
    return pixels(K, np.zeros(5), R, -R @ np.array(place))
