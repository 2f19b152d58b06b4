"""A clock that is told the time, and jobs that are not there, for the tests of progress."""

import random

from epibar.jobs.pace import Pace


class Clock:
    """Seconds that pass when it is told so."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


def simulated(stages, *, workers=2, tells=True, fails=(), step=0.25, sharing=None):
    """Run a job that is not there; returns (seconds, share, left) of each look.

    ``stages`` has of each stage the prior and the real seconds of its tasks by name.
    """
    clock = Clock()
    pace = Pace([(stage,) for stage, _ in stages], workers, sharing, clock)
    for stage, tasks in stages:
        pace.expect(stage, {name: prior for name, (prior, _) in tasks.items()})
    began, looks = clock.now, []
    for stage, tasks in stages:
        queue = [(name, real) for name, (_, real) in tasks.items()]
        left = dict(queue)
        for name, _ in queue:
            pace.started(stage, name)
        while left:
            for name in list(left)[:workers]:
                left[name] -= step
            clock.now += step
            for name in [name for name, seconds in left.items() if seconds <= 0]:
                del left[name]
                if name in fails:
                    assert pace.failed(name)
                else:
                    pace.ended(name)
            real = dict(queue)
            shares = {name: 1 - left[name] / real[name] for name in left if tells}
            looks.append((clock.now - began, *pace.look(shares)))
    pace.finish()
    looks.append((clock.now - began, *pace.look({})))
    return looks


def job_of(cameras, slower=1.0, pairs=6, spread=0.0, seed=0):
    """Priors and seconds of a usual job whose machine is slower than that of the priors."""
    rng = random.Random(seed)

    def real(prior):
        return prior, prior * slower * rng.uniform(1 - spread, 1 + spread)

    return [
        ("record", {f"cam{k}": real(prior) for k, prior in enumerate(cameras)}),
        ("clocks", {"clocks": real(8.0)}),
        ("match", {f"pair{k}": real(11.0) for k in range(pairs)}),
        ("join", {"join": real(6.0)}),
    ]
