"""Three cameras whose pairs are calibrated once, and the folder of a run of these, for tests of exports."""

import functools
from dataclasses import replace

import epibar
from epibar import synthetic
from epibar.files.frontier_csv import write_frontier_points
from epibar.files.json_file import write_json
from epibar.lens.cameras_toml import write_cameras
from epibar.lens.intrinsics import Intrinsics
from epibar.outcome.entries import camera_entry


@functools.cache
def people():
    return synthetic.people(seed=5, cameras=3, walkers=6, frames=400, size=(320, 240), asymmetric=True)


@functools.cache
def recorded():
    found = []
    for index, camera in enumerate(people().cameras):
        recording = epibar.Recording.from_masks(
            people().masks(index), fps=people().fps, lines=4000, seed=index, name=f"cam{index + 1}"
        )
        recording.matrix = camera.K
        found.append(recording)
    return found


@functools.cache
def calibrated_pairs():
    """Two pairs with a right answer, and one made to be refused: the cameras 1 and 2."""
    recordings = recorded()
    found = {pair: epibar.calibrate(recordings[pair[0]], recordings[pair[1]]) for pair in ((0, 2), (1, 2))}
    assert all(calibration.accepted for calibration in found.values())
    refused = replace(found[0, 2], accepted=False, kind="no_common_scene", reason="Nothing in common.")
    return {(0, 1): refused, **found}


def write_camera_file(path):
    """Intrinsics without poses."""
    write_cameras(
        path, [Intrinsics(f"cam{i + 1}", camera.size, camera.K) for i, camera in enumerate(people().cameras)]
    )
    return path


def write_run(folder, recordings, calibrations, intrinsics):
    """Write the part of a run that exports read."""
    folder.mkdir(exist_ok=True)
    pairs = []
    for (i, j), calibration in calibrations.items():
        a, b = recordings[i].name, recordings[j].name
        points = write_frontier_points(folder / f"{a}_{b}_frontier.csv", calibration.frontier_points)
        keys = ("accepted", "kind", "reason", "F", "expected_error", "time_offset")
        pairs.append(
            {"a": a, "b": b, "frontier_points": points.name, **{k: getattr(calibration, k) for k in keys}}
        )
    cameras = [camera_entry(r.name, f"{r.name}.mp4", i, r) for i, r in enumerate(recordings)]
    result = {"format": 1, "intrinsics": intrinsics, "cameras": cameras, "pairs": pairs, "errors": []}
    write_json(folder / "calibration.json", result)
    return folder
