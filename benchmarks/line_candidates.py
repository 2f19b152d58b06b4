"""What candidate line pairs are, on a recording with known cameras and people of a known height.

Of each pair the share of candidates that are true, of those on the plane at half the people's height, and
how alike the barcodes of lines through random moving places are, in the true pencils and in those found.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
from common import Array
from options import numbers
from recordings_views import DATA, foreground_of, parser_of, record
from tables import percent, px, table

import epibar
from epibar.evaluation import true_candidates
from epibar.geometry.cameras import fundamental_from_cameras
from epibar.lens.cameras_toml import load_cameras
from epibar.lens.intrinsics import Intrinsics

NAME = "pets_cameras"
HALF_HEIGHT = 875.0
"""Half the height of its people, millimetres."""
ON_PLANE = 6.0
"""Mean distance in B from the line that the plane gives, pixels."""
PLACES = 150


def clipped(line: Array, width: int, height: int) -> list[float] | None:
    """Both ends of a line in an image; None beside it."""
    a, b, c = line
    ends = [(x, -(a * x + c) / b) for x in (0.0, width - 1.0) if b] + [
        (-(b * y + c) / a, y) for y in (0.0, height - 1.0) if a
    ]
    inside = [p for p in ends if -1e-9 <= p[0] <= width - 1 + 1e-9 and -1e-9 <= p[1] <= height - 1 + 1e-9]
    if len(inside) < 2:
        return None
    return [*min(inside), *max(inside)]


def plane(camera: Intrinsics) -> Array:
    """The homography of the plane at half the people's height to the image."""
    posed = camera.posed()
    origin = posed.R[:, 2] * HALF_HEIGHT + posed.t
    return camera.matrix @ np.column_stack([posed.R[:, 0], posed.R[:, 1], origin])


def on_plane(lines_a: Array, lines_b: Array, homography: Array, size: tuple[int, int]) -> Array:
    """Which line pairs are one line of the plane that a homography carries from A to B."""
    there = lines_a @ np.linalg.inv(homography)
    there /= np.linalg.norm(there[:, :2], axis=1, keepdims=True)
    found = np.zeros(len(lines_a), bool)
    for k, line in enumerate(lines_b):
        ends = clipped(line, *size)
        if ends is not None:
            points = np.linspace(ends[:2], ends[2:], 41)
            found[k] = np.abs(points @ there[k, :2] + there[k, 2]).mean() < ON_PLANE
    return found


def correlations(F: Array, masks: tuple[Array, Array], seed: int) -> Array:
    """Of the barcodes of epipolar lines through random moving places of A; 0 where B does not see it."""
    frames, height, width = masks[0].shape
    random = np.random.default_rng(seed)
    heat = masks[0].sum(axis=0, dtype=float).ravel()
    places = random.choice(heat.size, PLACES, p=heat / heat.sum())
    points = np.column_stack([places % width, places // width, np.ones(PLACES)])
    epipole = np.linalg.svd(F)[2][-1]
    here = [clipped(line, width, height) for line in np.cross(epipole, points)]
    there = [clipped(line, *masks[1].shape[:0:-1]) for line in points @ F.T]
    both = [k for k in range(PLACES) if here[k] is not None and there[k] is not None]
    found = np.zeros(PLACES)
    if not both:
        return found
    x, y = (
        np.unpackbits(
            epibar.barcodes(seen, [lines[k] for k in both]).view(np.uint8), axis=1, bitorder="little"
        )[:, :frames].astype(float)
        for seen, lines in zip(masks, (here, there), strict=True)
    )
    x, y = (bits - bits.mean(axis=1, keepdims=True) for bits in (x, y))
    norms = np.linalg.norm(x, axis=1) * np.linalg.norm(y, axis=1)
    found[both] = (x * y).sum(axis=1) / np.where(norms > 0, norms, np.inf)
    return found


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--cameras", type=numbers, default=list(range(1, 9)), help="such as 1,3,4,8")
    args = parser.parse_args()
    folder: Path = args.data_dir / DATA[NAME].folder
    if not (folder / "cameras.toml").exists():
        print(f"{folder} is not there, so there is nothing to measure")
        return
    known = {camera.name: camera for camera in load_cameras(folder / "cameras.toml")}
    names = [f"cam{number}" for number in args.cameras]
    files = {name: folder / DATA[NAME].files[name] for name in names}
    recordings = {
        name: record(files[name], True, known[name], args.lines, k, foreground_of(args), args.cache)
        for k, name in enumerate(names)
    }
    masks = {name: np.load(files[name])["masks"] for name in names}
    rows = []
    for a, b in combinations(names, 2):
        pair = recordings[a], recordings[b]
        cal = epibar.calibrate(*pair, method="lines")
        truth = fundamental_from_cameras(known[a].posed(), known[b].posed())
        homography = plane(known[b]) @ np.linalg.inv(plane(known[a]))
        lines = cal.candidates.lines_a, cal.candidates.lines_b
        true = true_candidates(*lines, truth, pair[0].size, pair[1].size)
        seen = masks[a], masks[b]
        there = correlations(truth, seen, 0)
        ours = np.full(1, np.nan) if cal.F is None else correlations(cal.F, seen, 0)
        rows.append(
            [
                f"{a}-{b}",
                cal.kind,
                percent(float(true.mean())),
                percent(float(on_plane(*lines, homography, pair[1].size).mean())),
                px(float(cal.candidates.correlation.max())),
                *(px(float(value), 3) for r in (there, ours) for value in (r.mean(), np.median(r))),
            ]
        )
        if args.verbose:
            print(rows[-1], flush=True)
    head = ["pair", "verdict", "true candidates", "on the plane at half height", "highest correlation"]
    head += [f"{which}: {what}" for which in ("true pencils", "found") for what in ("mean", "median")]
    print(table(head, rows))


if __name__ == "__main__":
    main()
