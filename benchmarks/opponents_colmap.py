"""COLMAP on the points of a network's pairs: focal lengths from fundamental matrices, then a mapper.

Each point belongs to one pair, so every track has two views, which both mappers leave out unless they are
told otherwise. Pitfall: COLMAP counts pixels from the corner of the image, half a pixel before ours.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from colmap import cameras_of
from common import Array
from opponents_views import Views, with_focal

from epibar.synthetic import Camera

HALF = 0.5
"""From our pixels to COLMAP's."""
CORNER = np.array([[1.0, 0.0, HALF], [0.0, 1.0, HALF], [0.0, 0.0, 1.0]])
PRIOR_FOCAL = 1.2
"""Focal length to start from, widths of the image: COLMAP's own guess."""
SEED = 1


def in_pixels_from_the_corner(F: Array) -> Array:
    """Return the fundamental matrix of the same two cameras in COLMAP's pixels."""
    back = np.linalg.inv(CORNER)
    moved: Array = back.T @ F @ back
    return moved / np.linalg.norm(moved)


def _camera(views: Views, name: str) -> Any:
    """A camera to start from: known and kept, or a guess."""
    import pycolmap

    width, height = views.sizes[name]
    if views.matrices is not None:
        K = views.matrices[name]
        params = [K[0, 0], K[1, 1], K[0, 2] + HALF, K[1, 2] + HALF]
        return pycolmap.Camera(
            model="PINHOLE", width=width, height=height, params=params, has_prior_focal_length=True
        )
    params = [PRIOR_FOCAL * width, width / 2, height / 2]
    model = "SIMPLE_RADIAL" if views.bent else "SIMPLE_PINHOLE"
    params += [0.0] if views.bent else []
    return pycolmap.Camera(model=model, width=width, height=height, params=params)


def _two_views(views: Views, pair: tuple[str, str], cameras: dict[str, Any]) -> Any:
    """The geometry of a pair: F as it was found, or E of known cameras by COLMAP's own estimate."""
    import pycolmap

    matches = views.pairs[pair]
    each = np.arange(len(matches.a), dtype=np.uint32)
    indices = np.stack([each, each], axis=1)
    if views.matrices is None:
        return pycolmap.TwoViewGeometry(
            config=pycolmap.TwoViewGeometryConfiguration.UNCALIBRATED,
            F=in_pixels_from_the_corner(matches.F),
            inlier_matches=indices,
        )
    options = pycolmap.TwoViewGeometryOptions(
        compute_relative_pose=True, detect_watermark=False, ransac={"random_seed": SEED}
    )
    first, second = (cameras[name] for name in pair)
    return pycolmap.estimate_calibrated_two_view_geometry(
        first, matches.a + HALF, second, matches.b + HALF, indices, options
    )


def write_database(path: Path, views: Views) -> None:
    """Write cameras, points and geometries of pairs; a pair's points follow those of the pairs before."""
    import pycolmap

    cameras = {name: _camera(views, name) for name in views.sizes}
    points: dict[str, list[Array]] = {name: [] for name in cameras}
    matches = {}
    for pair, found in views.pairs.items():
        starts = [sum(map(len, points[name])) for name in pair]
        each = np.arange(len(found.a))
        matches[pair] = np.stack([each + start for start in starts], axis=1).astype(np.uint32)
        for name, pixels in zip(pair, (found.a, found.b), strict=True):
            points[name].append(pixels + HALF)
    with pycolmap.Database.open(path) as database:
        ids = {}
        for number, (name, camera) in enumerate(cameras.items(), start=1):
            camera.camera_id = database.write_camera(camera)
            rig = pycolmap.Rig()
            rig.add_ref_sensor(camera.sensor_id)
            rig_id = database.write_rig(rig)
            image = pycolmap.Image(name=name, camera_id=camera.camera_id, image_id=number)
            ids[name] = database.write_image(image, use_image_id=True)
            frame = pycolmap.Frame(rig_id=rig_id)
            frame.add_data_id(image.data_id)
            database.write_frame(frame)
            pixels = np.concatenate([np.empty((0, 2)), *points[name]]).astype(np.float32)
            database.write_keypoints(ids[name], pixels)
        for pair, indices in matches.items():
            geometry = _two_views(views, pair, cameras)
            inliers = np.asarray(geometry.inlier_matches)
            geometry.inlier_matches = indices[inliers[:, 0]]
            database.write_matches(ids[pair[0]], ids[pair[1]], indices)
            database.write_two_view_geometry(ids[pair[0]], ids[pair[1]], geometry)


def _calibrated(path: Path) -> dict[str, float]:
    """Let COLMAP find focal lengths from the fundamental matrices; they are in the database afterwards."""
    import pycolmap

    options = pycolmap.ViewGraphCalibrationOptions(random_seed=SEED)
    if not pycolmap.calibrate_view_graph(path, options):
        raise RuntimeError("uncalibrated")
    return _focals(path)


def _focals(path: Path) -> dict[str, float]:
    """Focal lengths in a database, by the names of images."""
    import pycolmap

    with pycolmap.Database.open(path) as database:
        return {
            image.name: database.read_camera(image.camera_id).mean_focal_length()
            for image in database.read_all_images()
        }


def view_graph(views: Views) -> Views:
    """The same views with the focal lengths that COLMAP finds from their fundamental matrices."""
    if views.matrices is not None:
        return views
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "database.db"
        write_database(path, views)
        return with_focal(views, _calibrated(path))


def _global_options(known: bool) -> Any:
    import pycolmap

    options = pycolmap.GlobalPipelineOptions(random_seed=SEED, num_threads=1)
    mapper = options.mapper
    mapper.num_threads, mapper.random_seed = 1, SEED
    mapper.track_min_num_views_per_track = 2
    mapper.global_positioning.min_num_view_per_track = 2
    mapper.global_positioning.use_gpu = False
    mapper.bundle_adjustment.min_track_length = 2
    mapper.bundle_adjustment.ceres.use_gpu = False
    mapper.bundle_adjustment.refine_focal_length = not known
    mapper.bundle_adjustment.refine_extra_params = not known
    mapper.retriangulation.ignore_two_view_tracks = False
    return options


def _incremental_options(known: bool) -> Any:
    import pycolmap

    options = pycolmap.IncrementalPipelineOptions(
        random_seed=SEED, num_threads=1, min_model_size=2, extract_colors=False
    )
    options.ba_refine_focal_length = not known
    options.ba_refine_extra_params = not known
    options.mapper.abs_pose_refine_focal_length = not known
    options.mapper.abs_pose_refine_extra_params = not known
    options.triangulation.ignore_two_view_tracks = False
    return options


def mapped(views: Views, way: str) -> dict[str, Camera]:
    """Cameras that COLMAP places, those of its largest model, in our pixels.

    Parameters
    ----------
    views : Views
    way : {"global", "incremental"}

    Raises
    ------
    RuntimeError
        One word that says why there are none.
    """
    import pycolmap

    pycolmap.logging.minloglevel = 3
    known = views.matrices is not None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "database.db"
        write_database(path, views)
        if not known:
            _calibrated(path)
        if way == "global":
            models = pycolmap.global_mapping(path, folder, folder, _global_options(known))
        else:
            models = pycolmap.incremental_mapping(path, folder, folder, _incremental_options(known))
    if not models:
        raise RuntimeError("unmapped")
    best = max(models.values(), key=lambda model: (model.num_reg_images(), model.num_points3D()))
    return cameras_of(best)
