"""What this machine can do: measured in the same run by the crate's bench `stages`."""

from __future__ import annotations

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["Machine", "memory_mb"]

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Machine:
    """Limits, and seconds of the stages of a recording that Python cannot call one by one.

    `packing`, `reading`, `components`, `hulls`, `barcodes` and `recorder` are of all masks and lines.
    """

    threads: int
    words_per_second: float
    bytes_per_second: float
    reading: float
    packing: float
    components: float
    hulls: float
    barcodes: float
    line_pixels: float
    recorder: float


def measure(masks: NDArray[np.uint8], lines: int) -> Machine:
    """Run the bench on these masks (T, H, W)."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "masks"
        masks.tofile(path)
        arguments = [str(path), str(masks.shape[2]), str(masks.shape[1]), str(lines)]
        command = ["cargo", "bench", "--quiet", "--locked", "-p", "epibar", "--bench", "stages", "--"]
        run = subprocess.run([*command, *arguments], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    return Machine(**json.loads(run.stdout))


def memory_mb(key: str, reset: bool = False) -> float:
    """Memory of this process (Linux), megabytes: ``VmRSS`` now, ``VmHWM`` at most since the reset."""
    if reset:
        Path("/proc/self/clear_refs").write_text("5")
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return float(line.split()[1]) / 1024
    raise KeyError(key)
