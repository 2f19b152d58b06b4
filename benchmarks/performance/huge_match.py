"""Match 100,000 x 100,000 barcodes; prints seconds, megabytes beyond the input and the number of pairs."""

import time

from data import FRAMES, random_barcodes
from machine import memory_mb

from epibar import _core

COUNT = 100_000

if __name__ == "__main__":
    bits = []
    for seed in (1, 2):
        bits.append(random_barcodes(COUNT, FRAMES, seed))
    before = memory_mb("VmRSS")
    memory_mb("VmHWM", reset=True)
    started = time.perf_counter()
    found = _core.match_barcodes(*bits, FRAMES, 3, 1000)
    seconds = time.perf_counter() - started
    print(seconds, memory_mb("VmHWM") - before, len(found[0]))
