"""Matching: mutual top 3 of 10,000 x 10,000 barcodes, beside NumKong, FAISS, OpenCV and numpy."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from data import FRAMES, Bits, Pair, random_barcodes
from machine import Machine
from numpy.typing import NDArray
from table import Stage
from timing import in_turn

from epibar import _core

COUNT = 10_000
TOP = 3
# As many as are candidates (paper, section 2), the default of `epibar.match_barcodes`.
BEST = 1000


def matching_stages(pair: Pair, machine: Machine) -> list[Stage]:
    """Barcodes of people, which can be pruned, and random ones, which cannot."""
    sets = {
        "matching, people": pair.barcodes(COUNT),
        "matching, random bits": [random_barcodes(COUNT, FRAMES, seed) for seed in (1, 2)],
    }
    return [_stage(name, *bits, machine) for name, bits in sets.items()]


def _stage(name: str, a: Bits, b: Bits, machine: Machine) -> Stage:
    _compare(a, b)
    ways: dict[str, Callable[[], Any]] = {"epibar": lambda: _core.match_barcodes(a, b, FRAMES, TOP, BEST)}
    missing = []
    for peer, make in (("NumKong dots_packed, counts alone", _numkong), ("FAISS IndexBinaryFlat", _faiss)):
        try:
            ways[peer] = make(a, b, machine.threads)
        except ImportError as error:
            missing.append(str(error.name))
    ways["OpenCV BFMatcher knnMatch, both ways"] = lambda: _opencv_knn(a, b)
    ways["OpenCV BFMatcher crossCheck (top 1)"] = lambda: _opencv_cross(a, b)
    ways["numpy float32 product and argpartition"] = lambda: numpy_matches(a, b, FRAMES, TOP)
    seconds = in_turn(ways)
    ours = seconds.pop("epibar")
    pairs = len(a) * len(b)
    return Stage(
        name=f"{name}, mutual top {TOP}",
        unit="pairs",
        units=pairs,
        seconds=ours,
        limit="popcount",
        limit_seconds=pairs * a.shape[1] / machine.words_per_second,
        peers=seconds,
        missing=missing,
    )


def _compare(a: Bits, b: Bits) -> None:
    """The best are the first of all pairs, and all pairs those of the matrix but for ties and rounding."""
    best, every = (_core.match_barcodes(a, b, FRAMES, TOP, limit) for limit in (BEST, len(a) * TOP))
    if not all(np.array_equal(part, whole[:BEST]) for part, whole in zip(best, every, strict=True)):
        raise AssertionError("the best matches are not the first of all")
    r = numpy_correlations(a, b, FRAMES)
    rounding = 1e-4
    i, j = every[:2]
    needed = np.ones(r.shape, bool)
    for axis in (0, 1):
        ordered = np.partition(r, (-TOP - 1, -TOP), axis)
        kept, left = ordered.take(-TOP, axis), ordered.take(-TOP - 1, axis)
        if (r[i, j] < kept[(j, i)[axis]] - rounding).any():
            raise AssertionError("a match is not among the best")
        needed &= r > np.expand_dims(left, axis) + rounding
    needed[i, j] = False
    if needed.any():
        raise AssertionError("a match is missing")


def _numkong(a: Bits, b: Bits, threads: int) -> Callable[[], Any]:
    import numkong

    # Shapes of packed bits are in bytes.
    bytes_a, bytes_b = a.view(np.uint8), b.view(np.uint8)
    left = numkong.from_pointer(bytes_a.ctypes.data, bytes_a.shape, "uint1", owner=bytes_a)
    right = numkong.from_pointer(bytes_b.ctypes.data, bytes_b.shape, "uint1", owner=bytes_b)
    packed = numkong.dots_pack(right)
    out = numkong.zeros((len(a), len(b)), dtype="uint32")
    edges = np.linspace(0, len(a), threads + 1).astype(int).tolist()
    pool = ThreadPoolExecutor(threads)

    def counts() -> Any:
        def part(i: int) -> None:
            numkong.dots_packed(left, packed, out=out, start_row=edges[i], end_row=edges[i + 1])

        list(pool.map(part, range(threads)))
        return out

    expected = np.bitwise_count(a[:3, None] & b[None]).sum(axis=-1)
    if not np.array_equal(np.asarray(counts())[:3], expected):
        raise AssertionError("NumKong counts something else")
    return counts


def _faiss(a: Bits, b: Bits, threads: int) -> Callable[[], Any]:
    import faiss

    faiss.omp_set_num_threads(threads)
    bytes_a, bytes_b = a.view(np.uint8), b.view(np.uint8)

    def both_ways() -> None:
        for queries, base in ((bytes_a, bytes_b), (bytes_b, bytes_a)):
            index = faiss.IndexBinaryFlat(base.shape[1] * 8)
            index.add(base)
            index.search(queries, TOP)

    return both_ways


def _opencv_knn(a: Bits, b: Bits) -> None:
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING)
    matcher.knnMatch(a.view(np.uint8), b.view(np.uint8), TOP)
    matcher.knnMatch(b.view(np.uint8), a.view(np.uint8), TOP)


def _opencv_cross(a: Bits, b: Bits) -> None:
    cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(a.view(np.uint8), b.view(np.uint8))


def numpy_correlations(a: Bits, b: Bits, frames: int) -> NDArray[np.float32]:
    """All of them, with a matrix product; (n, m)."""
    normalised = []
    for bits in (a, b):
        rows = np.unpackbits(bits.view(np.uint8), axis=1, bitorder="little")[:, :frames].astype(np.float32)
        rows -= rows.mean(axis=1, keepdims=True)
        normalised.append(rows / np.linalg.norm(rows, axis=1, keepdims=True))
    product: NDArray[np.float32] = normalised[0] @ normalised[1].T
    return product


def numpy_matches(a: Bits, b: Bits, frames: int, top: int) -> set[tuple[int, int]]:
    """Mutual top `top` by correlation; of equal ones any."""
    r = numpy_correlations(a, b, frames)
    of_rows = np.argpartition(r, -top, axis=1)[:, -top:]
    of_columns = np.argpartition(r, -top, axis=0)[-top:]
    in_rows = {(i, j) for i, row in enumerate(of_rows.tolist()) for j in row}
    return in_rows & {(i, j) for column in of_columns.tolist() for j, i in enumerate(column)}


def huge_stage(machine: Machine) -> Stage:
    """100,000 x 100,000, in a process of its own, which tells how much memory it took beyond its input."""
    program = Path(__file__).parent / "huge_match.py"
    run = subprocess.run([sys.executable, program], capture_output=True, text=True, check=True)
    seconds, extra, found = (float(part) for part in run.stdout.split())
    pairs = 1e10
    return Stage(
        name="matching, 100,000 x 100,000 random bits",
        unit="pairs",
        units=pairs,
        seconds=seconds,
        limit="popcount",
        limit_seconds=pairs * -(-FRAMES // 64) / machine.words_per_second,
        notes={"peak memory beyond the input": f"{extra:.0f} MB, {found:.0f} pairs found"},
    )
