"""What stands for the compiled module where a camera is added to a network."""

import functools

import numpy as np
from check_input import some_masks
from network_input import looking_at

import epibar
from epibar import Recording, _core
from epibar.calibration import Calibration
from epibar.network import pair_search

REFUSED = "left out: what moves in it does not move as in the other cameras"


class Adding:
    """Stands for the compiled module: cam9 stands where it is told, other names are refused."""

    def __init__(self):
        self.R, t = looking_at((0.7, 0.7, 0.5))
        self.place = {
            "matrix": np.array([[650.0, 0, 319.5], [0, 650.0, 239.5], [0, 0, 1]]),
            "distortions": np.array([-0.1, 0.0, 0.0, 0.0, 0.0]),
            "rotation": self.R,
            "translation": t,
            "expected": {"focal": 0.012, "rotation": 0.3, "position": 0.004},
            "position_covariance": np.eye(3) * 1e-6,
        }

    def __call__(self, recordings, names, stored, known, pairs, clocks, progress):
        self.names, self.stored, self.known, self.pairs, self.clocks = names, stored, known, pairs, clocks
        if progress is not None:
            progress("network", 1.0)
        nothing = dict.fromkeys(self.place)
        answers, found = [], []
        for k, name in enumerate(names[len(stored) :], len(stored)):
            ok = name == "cam9"
            answers.append(
                {
                    "name": name,
                    "accepted": ok,
                    "status": "accepted" if ok else "nothing_in_common",
                    "reason": "calibrated: well" if ok else REFUSED,
                    **(self.place if ok else nothing),
                    "deviates": (9.0, 7.0),
                    "clock": (0.25, 20.0) if ok else None,
                    "offset_error": 0.001,
                }
            )
            found += [
                {
                    "a": a,
                    "b": k,
                    "status": "confirmed" if ok else "outside",
                    "accepted": ok,
                    "F": np.eye(3) / 3**0.5 if ok else None,
                    "deviates": (6.0, 5.0),
                }
                for a in range(k)
            ]
        return {"cameras": answers, "pairs": found}


def stand_in_adding(monkeypatch):
    stub = Adding()
    monkeypatch.setattr(_core, "add_cameras", stub)
    stub.searched = []

    def searched(rec_a, rec_b, **options):
        stub.searched.append(options)
        if options["progress"] is not None:
            options["progress"]("search", 1.0)
        return refused_pair()

    monkeypatch.setattr(pair_search, "calibrate", searched)
    return stub


@functools.cache
def refused_pair():
    one, other = (Recording.from_masks(some_masks(k), lines=50) for k in (0, 5))
    found = epibar.calibrate(one, other, time_offset=0.0)
    assert isinstance(found, Calibration)
    return found
