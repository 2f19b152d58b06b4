"""The job of ``many_cameras.py`` by whichever epibar stands first on the path, in a process of its own.

Takes masks, folder, method and lines as JSON, and prints what it took and what came out as JSON. It needs
nothing but ``calibrate_all``, so that other versions of the package can run it.
"""

from __future__ import annotations

import inspect
import json
import sys
import time
from pathlib import Path

import epibar


def main() -> None:
    asked = json.loads(sys.argv[1])
    # Versions that have no such option search every pair.
    every = {"every_pair": True} if "every_pair" in inspect.signature(epibar.calibrate_all).parameters else {}
    options = {"method": asked["method"], "lines": asked["lines"], "masks": True, "report": False, **every}
    began, busy = time.perf_counter(), time.process_time()
    epibar.calibrate_all(asked["masks"], asked["out"], **options)
    seconds, cpu = time.perf_counter() - began, time.process_time() - busy
    content = json.loads(Path(asked["out"], "calibration.json").read_text(encoding="utf-8"))
    pairs = {f"{pair['a']}-{pair['b']}": [pair["accepted"], pair["F"]] for pair in content["pairs"]}
    print(json.dumps({"package": epibar.__file__, "seconds": seconds, "cpu": cpu, "pairs": pairs}))


if __name__ == "__main__":
    main()
