"""Networks for the tests of the report: made up, with everything that its page has to show."""

from dataclasses import replace

import numpy as np
from network_input import made_up
from report_input import make_report_input

import epibar
from epibar.network.parts import NetworkPairs
from epibar.report import NetworkReport, ReportCamera, ReportPair
from epibar.report.page import write_report


def network(count=5, **options):
    """Six cameras on a circle: cam3 refused, cam4 without a place, a pair of every status."""
    found = made_up(count, **{"refused": ("cam3",), "lost": ("cam4",), **options})
    statuses = {("cam1", "cam2"): "contradicts", ("cam1", "cam5"): "predicted"}
    pairs = [
        replace(pair, status=statuses.get(pair_names, pair.status))
        for pair_names, pair in found.pairs.items()
    ]
    return replace(found, pairs=NetworkPairs(pairs))


def walkers(count=3, length=80):
    """Tracks on the floor, (length, 3) each."""
    time = np.linspace(0, 20, length)
    return [
        np.column_stack([0.5 * np.cos(0.3 * time + k), 0.4 * np.sin(0.2 * time + 2 * k), 0 * time])
        for k in range(count)
    ]


def cameras(names):
    """A camera of the report for each name, in which little moves."""
    masks = np.zeros((80, 48, 64), bool)
    masks[::2, 10:30, 5:20] = True
    recording = epibar.Recording.from_masks(masks, lines=50)
    return [ReportCamera(name, None, True, recording, None) for name in names]


def network_report(count=5):
    """Network, cameras of a report without pairs, and tracks."""
    made = network(count)
    return cameras(made.cameras), NetworkReport(made, None, walkers())


def large_report(path):
    """20 cameras, all 190 pairs, each with as much to show as a well calibrated one has, and long tracks."""
    made = network(20, refused=(), lost=())
    report_cameras, pairs = make_report_input()
    known = {one.name: one for one in report_cameras}
    shown = [replace(known[f"cam{1 + k % 2}"], name=name) for k, name in enumerate(made.cameras)]
    both = [ReportPair(a, b, pairs[0].calibration, 1.0) for a, b in made.pairs]
    assert len(both) == 190
    tracks = walkers(60, 3000)
    return write_report(path, shown, both, network=NetworkReport(made, None, tracks))


def renamed(made, names):
    """The same network with other names of its cameras."""
    return replace(
        made,
        cameras={names[name]: replace(one, name=names[name]) for name, one in made.cameras.items()},
        clocks={names[name]: clock for name, clock in made.clocks.items()},
        pairs=NetworkPairs([replace(one, a=names[one.a], b=names[one.b]) for one in made.pairs.values()]),
    )
