"""Writes the inputs that fuzzing of the readers begins with: ``python tests/fuzz_first_inputs.py``.

What was found since stays.
"""

import io
import json
import tempfile
from pathlib import Path

import fuzzed
import numpy as np
from jobs_input import FAST, write_masks
from network_input import made_up
from test_fuzz_corpus import CORPUS

import epibar
from epibar.files.checks import RECORDING
from epibar.files.json_file import json_text


def put(function, name, data):
    folder = CORPUS / function.__name__
    folder.mkdir(exist_ok=True)
    (folder / name).write_bytes(data)


def small_masks():
    masks = np.zeros((10, 12, 16), np.uint8)
    for frame in range(10):
        masks[frame, 3:8, frame : frame + 4] = 1
    return masks


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        out = folder / "out"
        epibar.calibrate_all(write_masks(folder)[:2], out, **{**FAST, "lines": 60})
        result = json.loads((out / "calibration.json").read_text())
        arrays = dict(np.load(out / "pairs" / "cam1_cam2.npz"))
        points = (out / "cam1_cam2_frontier.csv").read_text().splitlines()[:4]

        recording = epibar.Recording.from_masks(small_masks(), fps=25.0, lines=6, name="hall")
        recording.save(folder / "recording.npz")
        put(fuzzed.archive, "recording.npz", (folder / "recording.npz").read_bytes())
        kept = dict(np.load(folder / "recording.npz"))
        put(fuzzed.recording, "small", fuzzed.listed(kept, [*RECORDING, "else"]))

        few = {key: arrays[key] for key in fuzzed.CALIBRATION if key in arrays}
        for key in few:
            if key.startswith(("candidates", "frontier_points", "shift_curve")):
                few[key] = few[key][:3]
            if key.startswith("error_maps"):
                few[key] = few[key][:2, :3]
        put(fuzzed.calibration, "small", fuzzed.listed(few, fuzzed.CALIBRATION))

        stream = io.BytesIO()
        np.save(stream, small_masks())
        put(fuzzed.masks, "array", b"\x00" + stream.getvalue())
        put(fuzzed.masks, "archive", b"\x80" + stream.getvalue())

        for pair in result["pairs"]:
            pair["frontier_points"] = None
        put(fuzzed.run, "two_cameras.json", json.dumps(result).encode())
        net = made_up(count=3, lost=())
        put(fuzzed.network, "three_cameras.json", json.dumps(json.loads(json_text(net.as_dict()))).encode())
        net.export(folder / "cameras.toml", "anipose")
        put(fuzzed.cameras, "cameras.toml", (folder / "cameras.toml").read_bytes())
        put(fuzzed.points, "points.csv", "\n".join(points).encode())
        tracks = epibar.network.WalkerTracks(
            names=("hall", "=door"),
            unit="metre",
            time=np.arange(3.0),
            track=np.array([0, 0, 1]),
            foot=np.ones((3, 3)),
            top=np.ones((3, 3)),
            cameras=np.ones((3, 2), bool),
            residual=np.ones(3),
        )
        tracks.save(folder / "tracks.csv")
        put(fuzzed.tracks, "tracks.csv", (folder / "tracks.csv").read_bytes())


if __name__ == "__main__":
    main()
