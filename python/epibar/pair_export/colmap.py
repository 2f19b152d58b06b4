"""Runs as COLMAP database: frontier points as keypoints, pairs as verified two-view geometries.

A stationary camera is one image, and the frontier points of all frames are its keypoints: what moved
through the scene stands still in the database, each moment beside the others. A corner of a silhouette that
several pairs use is one keypoint, so tracks over three cameras exist.

Pitfall: COLMAP counts pixels from the corner of the image, so that the centre of the first pixel is (0.5,
0.5). Points, principal points and F are moved accordingly.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import Unsigned
from ..camera_export.colmap import NO_WORD
from ..camera_export.losses import plain_names, renamed, tell
from ..errors import EpibarError
from ..files.atomic import write_atomically
from ..geometry.pose import RelativePose
from ..outcome.run import Pair, Run, RunCamera

__all__ = ["write_pairs_colmap"]

HALF = 0.5
FOCAL_GUESS = 1.2
"""Focal length over the longer side of the image where it is not known: COLMAP's own guess."""
TO_COLMAP = np.array([[1.0, 0.0, HALF], [0.0, 1.0, HALF], [0.0, 0.0, 1.0]])

Key = tuple[int, float, float]


def write_pairs_colmap(run: Run, path: str | os.PathLike[str]) -> list[Path]:
    """Write a COLMAP database through ``pycolmap``, replacing what is there.

    With intrinsics a camera is a PINHOLE whose focal length is a prior (the points are undistorted
    already); else a SIMPLE_RADIAL guess marked as no prior. A pair is CALIBRATED, with E and the relative
    pose, where these are known; else UNCALIBRATED, with F. COLMAP has no place for our verdict, so a pair
    that was not accepted is marked UNDEFINED, which COLMAP takes for not verified. Cameras are named as in
    the model of a network's cameras, one word each; other names than the recordings' are logged.

    Returns
    -------
    list of Path
        The file.

    Raises
    ------
    EpibarError
        ``pycolmap`` is missing, or the file cannot be written.
    """
    try:
        import pycolmap
    except ImportError as error:
        raise EpibarError(
            "pycolmap is missing, which writes COLMAP databases: pip install 'epibar[colmap]'"
        ) from error
    keypoints: dict[str, dict[Key, int]] = {camera.name: {} for camera in run.cameras}
    matches = [_matches(pair, keypoints) for pair in run.pairs]
    poses = run.poses()[0]
    names = plain_names(run.cameras, NO_WORD)
    tell(Path(path), renamed(run.cameras, names))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "database.db"
        database = pycolmap.Database.open(file)
        images = {
            camera.name: _add_image(pycolmap, database, name, camera, keypoints[camera.name])
            for name, camera in zip(names, run.cameras, strict=True)
        }
        for pair, match in zip(run.pairs, matches, strict=True):
            ids = images[pair.a], images[pair.b]
            database.write_matches(*ids, match)
            geometry = _geometry(pycolmap, pair, poses.get((pair.a, pair.b)), match)
            database.write_two_view_geometry(*ids, geometry)
        database.close()
        content = file.read_bytes()
    write_atomically(path, lambda stream: stream.write(content))
    return [Path(path)]


def _matches(pair: Pair, keypoints: dict[str, dict[Key, int]]) -> Unsigned:
    """Number the points of a pair within each camera, new ones at the end; (n, 2)."""
    points = pair.frontier_points
    columns = []
    for name, frames, pixels in ((pair.a, points.frame, points.a), (pair.b, pair.frames_b, points.b)):
        known = keypoints[name]
        corners = zip(frames.tolist(), *pixels.T.tolist(), strict=True)
        columns.append([known.setdefault(corner, len(known)) for corner in corners])
    return np.unique(np.array(columns, np.uint32).T.reshape(-1, 2), axis=0)


def _add_image(pycolmap: Any, database: Any, name: str, camera: RunCamera, corners: dict[Key, int]) -> int:
    width, height = camera.size
    if camera.matrix is None:
        guess = FOCAL_GUESS * max(width, height)
        model = pycolmap.Camera.create_from_model_name(1, "SIMPLE_RADIAL", guess, width, height)
    else:
        K = camera.matrix
        model = pycolmap.Camera.create_from_model_name(1, "PINHOLE", K[0, 0], width, height)
        model.params = [K[0, 0], K[1, 1], K[0, 2] + HALF, K[1, 2] + HALF]
    model.has_prior_focal_length = camera.matrix is not None
    model.camera_id = database.write_camera(model)
    rig = pycolmap.Rig()
    rig.add_ref_sensor(model.sensor_id)
    rig.rig_id = database.write_rig(rig)
    image = pycolmap.Image()
    image.name, image.camera_id = name, model.camera_id
    image.image_id = database.write_image(image)
    frame = pycolmap.Frame()
    frame.rig_id = rig.rig_id
    frame.add_data_id(image.data_id)
    database.write_frame(frame)
    pixels = np.array(list(corners), np.float64).reshape(-1, 3)[:, 1:] + HALF
    database.write_keypoints(image.image_id, pixels.astype(np.float32))
    return int(image.image_id)


def _geometry(pycolmap: Any, pair: Pair, pose: RelativePose | None, match: Unsigned) -> Any:
    kinds = pycolmap.TwoViewGeometryConfiguration
    geometry = pycolmap.TwoViewGeometry()
    geometry.inlier_matches = match
    if pair.F is not None:
        back = np.linalg.inv(TO_COLMAP)
        geometry.F = back.T @ pair.F @ back
    if pose is not None:
        geometry.E = pose.E
        geometry.cam2_from_cam1 = pycolmap.Rigid3d(pycolmap.Rotation3d(pose.R), pose.t)
    if not pair.accepted:
        geometry.config = kinds.UNDEFINED
    else:
        geometry.config = kinds.UNCALIBRATED if pose is None else kinds.CALIBRATED
    return geometry
