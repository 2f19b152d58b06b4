"""Real silhouettes with known cameras, where they are at hand: they are not ours to ship."""

from __future__ import annotations

from pathlib import Path

import pytest

import epibar
from epibar import evaluation, geometry
from epibar.lens.cameras_toml import load_cameras

DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "four_people"

pytestmark = pytest.mark.skipif(not DATA.exists(), reason=f"the real recordings are not at {DATA}")


def test_two_cameras_over_four_people() -> None:
    cameras = {camera.name: camera for camera in load_cameras(DATA / "cameras.toml")}
    recordings = {
        name: epibar.record(
            DATA / f"{name}.avi", masks=True, intrinsics=cameras[name], lines=20_000, seed=seed
        )
        for seed, name in enumerate(("cam1", "cam3"))
    }
    cal = epibar.calibrate(recordings["cam1"], recordings["cam3"])
    assert cal.accepted, cal.reason
    pose_a, pose_b = cameras["cam1"].posed(), cameras["cam3"].posed()
    # Frontier points, triangulated with the known cameras, span the volume where people walked.
    points = geometry.triangulate(
        geometry.projection_matrix(pose_a),
        geometry.projection_matrix(pose_b),
        cal.frontier_points.a,
        cal.frontier_points.b,
    )
    volume = evaluation.moving_volume(points)
    in_a, in_b = evaluation.volume_correspondences(pose_a, pose_b, volume)
    # The known cameras are good to 1-2 px.
    assert epibar.symmetric_epipolar_distance(cal.F, in_a, in_b).mean() < 2.0
