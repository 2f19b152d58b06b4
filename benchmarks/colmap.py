"""COLMAP's own bundle adjustment, started from an exported network: how far it moves cameras, and where to.

Of fresh networks of unknown cameras, or of a run of ``epibar demo``. The seeds of a reported table come from
the commit's own hash, as those of ``fresh.py``. Only positions and rotations are adjusted, or focal lengths
too; both with a robust loss.
"""

from __future__ import annotations

import tempfile
from argparse import ArgumentParser, Namespace
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from fresh_seeds import networks_asked_for
from networks import start_worker
from options import add_networks
from tables import progress

WAYS = {"poses": False, "poses and focal lengths": True}
LOSS_PIXELS = 0.5


@dataclass
class Known:
    """Cameras that others are held against."""

    cameras: list[Any]


def run(family: str, seed: int, lines: int) -> list[dict[str, Any]]:
    """Draw a situation, calibrate its cameras, let COLMAP adjust them, hold both against the truth."""
    import epibar
    from epibar import synthetic

    situation = synthetic.situation(seed, family)
    recordings = {c.name: situation.recording(i, lines) for i, c in enumerate(situation.cameras)}
    network = epibar.calibrate_network(recordings, seed=seed % 2**32)
    try:
        tracks = network.tracks(recordings)
    except epibar.EpibarError as error:
        progress(f"{family} {seed}: {error}")
        return []
    with tempfile.TemporaryDirectory() as folder:
        network.export(folder, format="colmap", tracks=tracks)
        return compared(network, Path(folder), situation)


def of_run(folder: Path) -> list[dict[str, Any]]:
    """Do the same with what a run of ``epibar demo`` found."""
    import epibar
    from epibar.cli import main as epibar_main
    from epibar.synthetic import Camera

    known = [
        Camera(c.matrix, c.posed().R, c.posed().t, c.size, c.name, tuple(c.distortions))
        for c in epibar.load_cameras(folder / "known_cameras.toml")
    ]
    network = epibar.Network.load(folder / "network.json")
    with tempfile.TemporaryDirectory() as made:
        model = Path(made) / "model"
        epibar_main(
            ["export", str(folder), "--format", "colmap", "--cameras", "--out", str(model), "--quiet"]
        )
        return compared(network, model, Known(known))


def compared(network: Any, folder: Path, truth: Any) -> list[dict[str, Any]]:
    """Of each camera and way of adjusting: errors before and after, by how much it moved, what is stated."""
    import pycolmap

    from epibar import synthetic

    pycolmap.logging.minloglevel = 2
    start = pycolmap.Reconstruction(folder)
    found = cameras_of(start)
    places = np.array([camera.centre for camera in found.values()])
    rig = max(np.linalg.norm(p - q) for p in places for q in places)
    before = synthetic.network_errors(truth, found)
    rows = []
    for way, focal in WAYS.items():
        model = pycolmap.Reconstruction(folder)
        options = pycolmap.BundleAdjustmentOptions(
            refine_focal_length=focal, refine_extra_params=False, print_summary=False
        )
        options.ceres.loss_function_type = pycolmap.LossFunctionType.CAUCHY
        options.ceres.loss_function_scale = LOSS_PIXELS
        pycolmap.bundle_adjustment(model, options)
        adjusted = cameras_of(model)
        moved = synthetic.network_errors(Known(list(found.values())), adjusted)
        after = synthetic.network_errors(truth, adjusted)
        for name in found:
            stated = network.cameras[name].expected
            rows.append(
                {
                    "way": way,
                    "camera": name,
                    "points": start.num_points3D(),
                    "pixels": start.compute_mean_reprojection_error(),
                    "stated": [stated["focal"], stated["rotation"], stated["position"] / rig],
                    **{
                        key: three(one[name])
                        for key, one in (("moved", moved), ("before", before), ("after", after))
                    },
                }
            )
    return rows


def cameras_of(model: Any) -> dict[str, Any]:
    """Cameras of a COLMAP model, by the names of their images; lenses apart."""
    from epibar.synthetic import Camera

    found = {}
    for image in sorted(model.images.values(), key=lambda one: one.image_id):
        camera, pose = model.cameras[image.camera_id], image.cam_from_world()
        found[image.name] = Camera(
            camera.calibration_matrix(),
            pose.rotation.matrix(),
            pose.translation,
            (camera.width, camera.height),
            image.name,
            (),
        )
    return found


def three(error: Any) -> list[float]:
    """Focal length (share), rotation (degrees), position (share of the rig)."""
    return [abs(error.focal), error.rotation, error.position]


UNITS = np.array([100, 1, 100])
KEYS = ("moved", "stated", "before", "after")
HEAD = "{} | focal length %: moved, stated, error before, after | rotation ° | position, % of the rig |"


def cells(values: dict[str, Any]) -> str:
    """Three cells, each of four numbers."""
    return " | ".join(", ".join(f"{values[key][k]:.2f}" for key in KEYS) for k in range(3))


def of_cameras(rows: list[dict[str, Any]]) -> None:
    """Print a row for each camera."""
    print(HEAD.format("| adjusted | camera"))
    print("| --- | --- | --- | --- | --- |")
    for row in rows:
        print(f"| {row['way']} | {row['camera']} | {cells({key: UNITS * row[key] for key in KEYS})} |")
    print(f"{rows[0]['points']} points, {rows[0]['pixels']:.2f} px")


def of_families(outcomes: list[tuple[str, list[dict[str, Any]]]]) -> None:
    """Print medians of each family, and how many cameras moved less than stated, and towards the truth."""
    print(
        HEAD.format("| family | adjusted | networks | cameras")
        + " within what is stated, % (f R C) | nearer, % |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for family in dict.fromkeys(name for name, _ in outcomes):
        of_family = [rows for name, rows in outcomes if name == family and rows]
        for way in WAYS:
            rows = [row for rows in of_family for row in rows if row["way"] == way]
            if not rows:
                continue
            every = {key: np.array([row[key] for row in rows]) for key in KEYS}
            middle = cells({key: UNITS * np.median(every[key], axis=0) for key in KEYS})
            within = (every["moved"] <= every["stated"]).mean(axis=0)
            nearer = (every["after"] < every["before"]).mean(axis=0)
            shares = " | ".join(" ".join(f"{100 * one:.0f}" for one in share) for share in (within, nearer))
            print(f"| {family} | {way} | {len(of_family)} | {len(rows)} | {middle} | {shares} |")


def main(arguments: Namespace) -> None:
    if arguments.run:
        of_cameras(of_run(arguments.run))
        return
    origin, jobs = networks_asked_for(arguments, "colmap ")
    outcomes = []
    workers = ProcessPoolExecutor(arguments.workers, get_context("spawn"), start_worker)
    with workers as pool:
        pending = {pool.submit(run, *job, arguments.lines): job[0] for job in jobs}
        for done in as_completed(pending):
            outcomes.append((pending[done], done.result()))
            progress(f"{len(outcomes)} of {len(jobs)}: {pending[done]}")
    print(f"commit {origin}" if origin else "seeds by hand: no table to report")
    of_families(sorted(outcomes, key=lambda one: one[0]))


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    parser.add_argument(
        "--run", type=Path, metavar="DIR", help="what 'epibar demo' wrote, instead of networks"
    )
    add_networks(parser, "network_plain,network", 3)
    main(parser.parse_args())
