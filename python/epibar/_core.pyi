from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ALL_PAIRS",
    "BASELINE",
    "GRID",
    "MAP_SHAPE",
    "MAX_EXPECTED_ERROR",
    "MAX_LINES",
    "MOST_DRIFT",
    "NINE_IN_TEN",
    "NINE_IN_TEN_IN_SPACE",
    "PAIR_DEVIATES",
    "RIVALS",
    "RIVAL_SHARE",
    "SEARCH_SECONDS",
    "SOME_Z",
    "TANGENTIAL",
    "Calibration",
    "Mixture",
    "Recorder",
    "Recording",
    "add_cameras",
    "barcodes",
    "calibrate",
    "check_network",
    "clean_mask",
    "clock_offsets",
    "clock_rate",
    "common_frames",
    "compare_light",
    "examine",
    "frame_interval",
    "join_network",
    "lens_directions",
    "lens_reach",
    "match_barcodes",
    "motion_lines",
    "paint_over",
    "pairs_to_add",
    "pairs_to_search",
    "positions",
    "score_lines",
    "score_tangents",
    "shrunk_green",
    "steady_background",
    "walker_tracks",
]

GRID: float
MAP_SHAPE: tuple[int, int]
ALL_PAIRS: int
BASELINE: float
MAX_EXPECTED_ERROR: float
MAX_LINES: int
MOST_DRIFT: float
NINE_IN_TEN: float
NINE_IN_TEN_IN_SPACE: float
PAIR_DEVIATES: float
RIVALS: int
RIVAL_SHARE: float
SEARCH_SECONDS: float
SOME_Z: float
TANGENTIAL: float

@final
class Mixture:
    def __new__(cls, width: int, height: int, threshold: float, shadows: bool) -> Mixture: ...
    def learn(self, frame: NDArray[np.uint8], rate: float) -> NDArray[np.uint8]: ...
    def prime(self, samples: NDArray[np.uint8], order: Sequence[int]) -> None: ...
    def look(self, frame: NDArray[np.uint8], rate: float) -> NDArray[np.uint8]: ...

@final
class Recorder:
    def __new__(
        cls,
        width: int,
        height: int,
        lines: int,
        seed: int,
        min_component_area: int,
        visible: NDArray[np.uint8] | None = None,
    ) -> Recorder: ...
    def push(self, mask: NDArray[np.uint8], time: float) -> None: ...
    def finish(self) -> Recording: ...

@final
class Recording:
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def frames(self) -> int: ...
    @property
    def seed(self) -> int: ...
    @property
    def informative(self) -> int: ...
    @property
    def times(self) -> NDArray[np.float64]: ...
    @property
    def segments(self) -> NDArray[np.float64]: ...
    @property
    def barcodes(self) -> NDArray[np.uint64]: ...
    @property
    def heat(self) -> NDArray[np.uint32]: ...
    @property
    def moving_pixels(self) -> NDArray[np.uint32]: ...
    @property
    def visible(self) -> NDArray[np.uint8] | None: ...
    def hulls(self, frame: int) -> list[NDArray[np.float64]]: ...
    def to_arrays(self) -> dict[str, NDArray[Any]]: ...
    @staticmethod
    def from_arrays(arrays: dict[str, NDArray[Any]]) -> Recording: ...

@final
class Calibration:
    @property
    def F(self) -> NDArray[np.float64] | None: ...
    @property
    def accepted(self) -> bool: ...
    @property
    def kind(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def expected_error(self) -> float | None: ...
    @property
    def time_offset(self) -> float: ...
    @property
    def timing(self) -> dict[str, Any]: ...
    @property
    def error_maps(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None: ...
    @property
    def source(self) -> str: ...
    @property
    def lines_a(self) -> NDArray[np.float64]: ...
    @property
    def lines_b(self) -> NDArray[np.float64]: ...
    @property
    def correlation(self) -> NDArray[np.float64]: ...
    @property
    def inliers(self) -> NDArray[np.bool_]: ...
    @property
    def frontier_frame(self) -> NDArray[np.int64]: ...
    @property
    def frontier_a(self) -> NDArray[np.float64]: ...
    @property
    def frontier_b(self) -> NDArray[np.float64]: ...
    @property
    def frontier_residual(self) -> NDArray[np.float64]: ...
    @property
    def counts(self) -> dict[str, int]: ...
    @property
    def floor(self) -> NDArray[np.float64] | None: ...
    @property
    def rivals(self) -> list[dict[str, Any]]: ...
    @property
    def evidence(self) -> dict[str, float]: ...
    @property
    def shift_curve(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

def calibrate(
    a: Recording,
    b: Recording,
    method: str,
    seed: int,
    time_offset: float | str,
    sharpen_offset: bool,
    search_seconds: float,
    upright: bool,
    cameras: tuple[NDArray[np.float64], NDArray[np.float64]] | None,
    candidates: int,
    draws: int,
    max_expected_error: float,
    progress: Callable[[str, float], None] | None,
) -> Calibration: ...
def barcodes(masks: NDArray[np.uint8], segments: NDArray[np.float64]) -> NDArray[np.uint64]: ...
def match_barcodes(
    bits_a: NDArray[np.uint64], bits_b: NDArray[np.uint64], frames: int, mutual: int, limit: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]: ...
def check_network(
    recordings: Sequence[Recording],
    names: Sequence[str],
    cameras: Sequence[Mapping[str, Any]],
    clocks: tuple[list[float], bool, bool],
    progress: Callable[[str, float], None] | None,
) -> list[dict[str, Any]]: ...
def clean_mask(
    mask: NDArray[np.uint8],
    median: int,
    closing: int,
    min_area: int,
    ignore: NDArray[np.uint8] | None = None,
) -> NDArray[np.uint8]: ...
def clock_offsets(
    recordings: Sequence[Recording], seconds: float, progress: Callable[[str, float], None] | None
) -> tuple[list[float], bool, bool]: ...
def clock_rate(a: Recording, b: Recording, frames_per_frame: float) -> float: ...
def common_frames(
    a: Recording, b: Recording, time_offset: float, frames_per_frame: float
) -> NDArray[np.int64]: ...
def frame_interval(recording: Recording) -> float: ...
def lens_directions(
    camera_matrix: NDArray[np.float64],
    distortions: tuple[float, float, float, float, float],
    pixels: list[list[float]],
) -> NDArray[np.float64]: ...
def lens_reach(
    camera_matrix: NDArray[np.float64],
    distortions: tuple[float, float, float, float, float],
    size: tuple[int, int],
) -> float | None: ...
def join_network(
    recordings: Sequence[Recording],
    names: Sequence[str],
    known: Sequence[Mapping[str, Any]],
    pairs: Sequence[Mapping[str, Any]],
    clocks: tuple[list[float], bool, bool],
    progress: Callable[[str, float], None] | None,
) -> dict[str, Any]: ...
def add_cameras(
    recordings: Sequence[Recording],
    names: Sequence[str],
    stored: Sequence[Mapping[str, Any]],
    known: Sequence[Mapping[str, Any]],
    pairs: Sequence[Mapping[str, Any]],
    clocks: tuple[list[float], bool, bool],
    progress: Callable[[str, float], None] | None,
) -> dict[str, Any]: ...
def pairs_to_add(
    recordings: Sequence[Recording], stored: int, clocks: tuple[list[float], bool, bool]
) -> list[tuple[int, int]]: ...
def pairs_to_search(
    recordings: Sequence[Recording], clocks: tuple[list[float], bool, bool]
) -> list[tuple[int, int]]: ...
def positions(
    a: Recording, b: Recording, time_offset: float, frames_per_frame: float
) -> NDArray[np.float64]: ...
def examine(
    a: Recording,
    b: Recording,
    f: NDArray[np.float64],
    radius: float,
    time_offset: float,
    upright: bool,
    refined: bool,
    cameras: tuple[NDArray[np.float64], NDArray[np.float64]] | None,
) -> dict[str, Any]: ...
def motion_lines(rec: Recording) -> NDArray[np.float64]: ...
def score_lines(
    lines_a: NDArray[np.float64],
    lines_b: NDArray[np.float64],
    sizes: Sequence[tuple[int, int]],
    matrices: NDArray[np.float64],
) -> NDArray[np.int64]: ...
def score_tangents(
    a: Recording,
    b: Recording,
    matrices: NDArray[np.float64],
    radius: float,
    time_offset: float,
    upright: bool,
    frames: int,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]: ...
def steady_background(samples: NDArray[np.uint8]) -> NDArray[np.uint8]: ...
def paint_over(
    samples: NDArray[np.uint8],
    background: NDArray[np.uint8],
    most: int,
    cleaning: tuple[int, int, int],
    margin: int,
) -> None: ...
def shrunk_green(frame: NDArray[np.uint8]) -> NDArray[np.uint8]: ...
def compare_light(
    now: NDArray[np.uint8],
    before: NDArray[np.uint8],
    first: NDArray[np.uint8],
    jump: int,
    counted: NDArray[np.uint8] | None = None,
) -> tuple[float, bool, int, int, NDArray[np.float64]]: ...
def walker_tracks(
    recordings: Sequence[Recording],
    cameras: Sequence[Mapping[str, Any]],
    height: float,
    progress: Callable[[str, float], None] | None,
) -> dict[str, Any]: ...
