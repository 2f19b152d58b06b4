"""The measuring program check.py: by how much an updated network differs from a fresh one."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"

UPDATED, FRESH = (
    {"focal": focal, "rotation": rotation, "position": position}
    for focal, rotation, position in ((0.003, 0.03, 0.3), (0.004, 0.04, 1.6))
)
"""Errors that are stated of each camera, positions in the units of the two networks."""

SCALE = 4.0


@pytest.fixture(scope="module")
def measured():
    """What holds updates against fresh cameras, and made-up cameras as a network."""
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import check_networks
        import check_updates

        made = check_networks.situation(1, 5, 1)
        yield check_updates, check_networks.true_network(made)
    finally:
        sys.path.remove(str(BENCHMARKS))


def with_errors(network, stated):
    return replace(
        network, cameras={name: replace(one, expected=stated) for name, one in network.cameras.items()}
    )


def elsewhere(network):
    """The same network in another world: X' = 4 Q X + shift."""
    Q = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    Q *= np.linalg.det(Q)
    shift = np.array([3.0, -1.0, 7.0])
    cameras = {
        name: replace(
            one, rotation=one.rotation @ Q.T, translation=SCALE * one.translation - one.rotation @ Q.T @ shift
        )
        for name, one in network.cameras.items()
    }
    return replace(network, cameras=cameras)


def test_differences_are_those_that_were_made(measured):
    program, network = measured
    updated = with_errors(network, UPDATED)
    angle = np.radians(2.0)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    cam = network.cameras["cam02"]
    aside = np.array([0.0, 0.0, 0.5])
    moved = replace(
        cam,
        matrix=cam.matrix * [[1.05, 1, 1], [1, 1.05, 1], [1, 1, 1]],
        rotation=turn @ cam.rotation,
        translation=turn @ (cam.translation - cam.rotation @ aside),
    )
    changed = replace(network, cameras={**network.cameras, "cam02": moved})
    fresh = with_errors(elsewhere(changed), FRESH)
    found = program.differences(updated, fresh, ["cam02", "cam03"])
    places = [one.position for one in network.cameras.values()]
    rig = max(np.linalg.norm(one - other) for one in places for other in places)
    assert found["cam02"][:3] == pytest.approx([0.05, 2.0, 0.5 / rig], rel=1e-6)
    assert found["cam03"][:3] == pytest.approx([0, 0, 0], abs=1e-5)
    for stated in (row[3:] for row in found.values()):
        assert stated == pytest.approx([0.005, 0.05, np.hypot(0.3, 1.6 / SCALE) / rig], rel=0.02)


def test_what_a_fresh_network_does_not_place_is_not_held_against_it(measured):
    program, network = measured
    updated = with_errors(network, UPDATED)
    left_out = replace(updated.cameras["cam02"], accepted=False)
    fresh = replace(updated, cameras={**updated.cameras, "cam02": left_out})
    assert list(program.differences(updated, fresh, ["cam02", "cam03"])) == ["cam03"]
