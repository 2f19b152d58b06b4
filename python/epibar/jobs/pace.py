"""How far a job is, and how long it may still take, from tasks that end and from those that tell their share.

Every task has a prior: the seconds that it takes on the machine that the priors were measured on. What was
measured so far says by which factor this job is slower, of each stage by itself where something of it is
known, else of all. What is left is then played through: so many tasks at a time, stage by stage.

    left of a task = (1 - share) * (what its stage takes, and with its share what it takes by itself)

No clock is read but the one that is given, so a job that never ran can be estimated too.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice

__all__ = ["JobProgress", "Pace", "Row", "left_in_words", "played_through"]

TRUST, TRUST_ALL = 0.1, 0.02
"""How many tasks as large as the mean the prior of a stage counts as, against what is measured of it; and
that of all stages."""

OVERDUE = 0.15
"""Share of the time that a task has taken, which it is thought to take still once it has overrun."""

UNKNOWN = 10.0
"""Prior of a task of which nothing is known, seconds."""

DONE = 1e-9
"""Seconds that are none."""

AGAIN = 0.5
"""Seconds between two estimates that are played through; in between the time left runs like a clock."""

EARLIEST = 2.0
"""Seconds before which nothing is said of the time left."""

INERTIA = 0.04
"""Of the whole time: how long the stated time left takes to follow a new estimate."""

FASTEST, LAZIEST = 1.0, 20.0
"""Seconds, bounds of that."""

ALMOST = 0.999
"""What the share of a job that goes on is at most."""


@dataclass(frozen=True)
class Row:
    """One task that is running.

    Attributes
    ----------
    name : str
        Of the camera.
    share : float
        That is done, 0 to 1; 0 where the source does not tell how many frames it has.
    frames_per_second : float or None
        At which it is recorded; None until a second look.
    """

    name: str
    share: float
    frames_per_second: float | None = None


@dataclass(frozen=True)
class JobProgress:
    """How far a whole job is.

    Attributes
    ----------
    share : float
        Of the job's time that is over, 0 to 1. It never goes back, and is 1 when all is written.
    seconds_left : float or None
        What the job may still take, None while nothing can be said.
    doing : str
        What is going on, in a few words.
    rows : tuple of Row
        One for each camera of which frames have been recorded, and more are.
    """

    share: float
    seconds_left: float | None
    doing: str
    rows: tuple[Row, ...] = ()

    def __str__(self) -> str:
        left = "" if self.seconds_left is None else f", {left_in_words(self.seconds_left)}"
        return f"{self.doing}, {math.floor(100 * self.share)} %{left}"


def left_in_words(seconds: float) -> str:
    """Say how long it may take, no more exactly than is known."""
    if seconds < 10:
        return "a few seconds left"
    if seconds < 90:
        return f"about {10 * round(seconds / 10)} s left"
    minutes = round(seconds / 60)
    if minutes < 90:
        return f"about {minutes} min left"
    minutes = 5 * round(minutes / 5)
    return f"about {minutes // 60} h {minutes % 60} min left"


@dataclass(eq=False)
class _Work:
    """A task as the estimate knows it; seconds are those that it had to itself, see :meth:`Pace._advance`."""

    stage: str
    prior: float | None
    elapsed: float = 0.0
    share: float = 0.0
    first: tuple[float, float] | None = None

    def tell(self, share: float) -> None:
        """Take the share that is done; the first tells when the task was ready to begin."""
        if share > self.share:
            self.share = min(share, 1.0)
            self.first = self.first or (self.elapsed, self.share)

    @property
    def progress(self) -> tuple[float, float] | None:
        """Seconds and share since the first share; None before a second one."""
        if self.first is None or self.share <= self.first[1]:
            return None
        return self.elapsed - self.first[0], self.share - self.first[1]


@dataclass(eq=False)
class _Stage:
    """What is known of the tasks of one stage."""

    seconds: float = 0.0
    """What tasks have taken that ended, and the priors of these."""
    prior: float = 0.0
    ended: int = 0
    starts: list[float] = field(default_factory=list)
    """Seconds before tasks told their first share."""


class Pace:
    """The estimate of one job.

    Parameters
    ----------
    stages : sequence of sequence of str
        In their order; those that stand together run at the same time.
    workers : int
        How many tasks run at a time.
    sharing : mapping of str to float, optional
        By stage: 0, as of those without, where tasks at the same time do not slow each other down, 1 where n
        of them take n times as long.
    clock : callable
        Seconds, of any origin.
    """

    def __init__(
        self,
        stages: Sequence[Sequence[str]],
        workers: int,
        sharing: Mapping[str, float] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._phases = [tuple(phase) for phase in stages]
        self._workers = max(workers, 1)
        self._sharing = dict.fromkeys((stage for phase in stages for stage in phase), 0.0) | dict(
            sharing or {}
        )
        self._clock = clock
        self._began = self._now = self._looked = clock()
        self._stages = {stage: _Stage() for phase in stages for stage in phase}
        self._ahead: dict[str, dict[Hashable, float | None]] = {stage: {} for stage in self._stages}
        self._running: dict[Hashable, _Work] = {}
        self._left: float | None = None
        self._stated = False
        self._share = 0.0

    def expect(self, stage: str, priors: Mapping[Hashable, float | None]) -> None:
        """Say which tasks of a stage are to come, instead of those said before.

        Their priors are in seconds, None where nothing is known.
        """
        self._ahead[stage] = dict(priors)

    def started(self, stage: str, task: Hashable) -> None:
        """Take a task that was handed over; it runs as soon as those before it leave a worker free."""
        self._advance()
        self._running[task] = _Work(stage, self._ahead[stage].pop(task, None))

    def ended(self, task: Hashable, seconds: float | None = None) -> None:
        """Take the end of a task and, where it tells, the seconds it took."""
        self._advance()
        work = self._running.pop(task)
        stage = self._stages[work.stage]
        stage.seconds += work.elapsed if seconds is None else seconds
        stage.prior += self._prior(work.stage, work.prior)
        stage.ended += 1

    def failed(self, task: Hashable) -> bool:
        """Take a task that ended early, of which nothing is learned, or will not begin; says if it ran."""
        self._advance()
        for ahead in self._ahead.values():
            ahead.pop(task, None)
        return self._running.pop(task, None) is not None

    def finish(self) -> None:
        """Nothing is left."""
        self._share, self._left = 1.0, 0.0

    def look(self, shares: Mapping[Hashable, float]) -> tuple[float, float | None]:
        """Take the shares of running tasks; returns that of the job, and the seconds that are left.

        Parameters
        ----------
        shares : mapping of task to float
            0 to 1, in proportion to the time a task takes, as far as possible. Those without may be left out.

        Returns
        -------
        share : float
            Of the time that is over. It never becomes less.
        left : float or None
            Seconds, None as long as nothing can be said.
        """
        if self._share >= 1.0:
            return 1.0, 0.0
        self._advance()
        for task, share in shares.items():
            if task in self._running:
                work = self._running[task]
                first_report = work.first is None
                work.tell(share)
                if first_report and work.first is not None:
                    self._stages[work.stage].starts.append(work.first[0])
        now, known = self._now, self._known and self._now - self._began >= EARLIEST
        if known and not self._stated:  # there is nothing yet that could jump
            self._left, self._stated = None, True
        if self._left is None or now - self._looked >= AGAIN:
            self._follow(self._estimate(), now - self._looked)
            self._looked = now
        left = max((self._left or 0.0) - (now - self._looked), 0.0)
        whole = now - self._began + left
        share = (now - self._began) / whole if whole > 0 else 0.0
        self._share = max(self._share, min(share, ALMOST))
        return self._share, left if known else None

    @property
    def _known(self) -> bool:
        """Whether anything was measured, and something is known of the size of all that is left."""
        for name, stage in self._stages.items():
            of_it = [work for work in self._running.values() if work.stage == name]
            unknown = any(work.prior is None and work.progress is None for work in of_it)
            if not stage.ended and (unknown or None in self._ahead[name].values()):
                return False
        ended = any(stage.ended for stage in self._stages.values())
        return ended or any(work.progress is not None for work in self._running.values())

    def _prior(self, stage: str, prior: float | None) -> float:
        """Prior of a task; where there is none, the mean of others of its stage."""
        if prior is not None:
            return prior
        known = [
            work.prior for work in self._running.values() if work.stage == stage and work.prior is not None
        ]
        known += [other for other in self._ahead[stage].values() if other is not None]
        if known:
            return sum(known) / len(known)
        done = self._stages[stage]
        return done.prior / done.ended if done.ended else UNKNOWN

    def _advance(self) -> None:
        """Let time pass: the first tasks that were handed over have had their part of it."""
        now = self._clock()
        passed, self._now = now - self._now, now
        busy = min(len(self._running), self._workers)
        for work in islice(self._running.values(), self._workers):
            work.elapsed += passed / busy ** self._sharing[work.stage]

    def _follow(self, estimate: float, passed: float) -> None:
        """Let the time left run down, and go towards a new estimate without a jump."""
        if self._left is None:
            self._left = estimate
            return
        running_down = max(self._left - passed, 0.0)
        inertia = INERTIA * (self._now - self._began + estimate)
        inertia = min(max(inertia, FASTEST), LAZIEST)
        self._left = estimate + (running_down - estimate) * math.exp(-passed / inertia)

    def _estimate(self) -> float:
        """Seconds that are left by what is known now."""
        everywhere = self._factor(self._stages, 1.0, TRUST_ALL)
        works = list(self._running.values())
        total = 0.0
        for phase in self._phases:
            running: list[tuple[float, float]] = []
            queued: list[tuple[float, float]] = []
            for name in phase:
                factor = self._factor([name], everywhere, TRUST)
                starts = self._stages[name].starts
                start = sum(starts) / len(starts) if starts else 0.0
                for place, work in enumerate(works):
                    if work.stage == name:
                        whole = self._prior(name, work.prior) * factor
                        left = _left(work, whole, start), self._sharing[name]
                        (running if place < self._workers else queued).append(left)
                ahead = (self._prior(name, prior) * factor + start for prior in self._ahead[name].values())
                queued += [(left, self._sharing[name]) for left in ahead]
            total += played_through(running, queued, self._workers)
        return total

    def _factor(self, stages: Iterable[str], before: float, trust: float) -> float:
        """How many times their priors tasks of some stages take; ``before`` as far as little is measured."""
        seconds = prior = 0.0
        whole = 0.0
        tasks = 0
        for name in stages:
            stage = self._stages[name]
            seconds, prior = seconds + stage.seconds, prior + stage.prior
            whole, tasks = whole + stage.prior, tasks + stage.ended
            for work in self._running.values():
                if work.stage == name and work.progress is not None:
                    spent, share = work.progress
                    of_it = self._prior(name, work.prior)
                    seconds, prior = seconds + spent, prior + share * of_it
                    whole, tasks = whole + of_it, tasks + 1
        if not prior > 0:
            return before
        weight = trust * whole / tasks
        return (weight * before + seconds) / (weight + prior)


def _left(work: _Work, whole: float, start: float) -> float:
    """Seconds that a task still takes, which takes ``whole`` after a start, as far as others tell."""
    if work.progress is None:
        return max(start + whole - work.elapsed, OVERDUE * work.elapsed)
    spent, share = work.progress
    itself = spent / share
    return (1.0 - work.share) * (work.share * itself + (1.0 - work.share) * whole)


def played_through(
    running: Sequence[tuple[float, float]], queued: Sequence[tuple[float, float]], workers: int
) -> float:
    """Seconds until all tasks are done, so many at a time, of which each slows the others down.

    Parameters
    ----------
    running, queued : sequence of (float, float)
        What each still takes by itself, seconds, and its sharing: beside others, n in all, it takes
        n ** sharing times as long. Those in the queue begin in its order.
    workers : int
    """
    waiting, now = deque(queued), list(running)
    seconds = 0.0
    while now or waiting:
        while waiting and len(now) < workers:
            now.append(waiting.popleft())
        step = min(left * len(now) ** sharing for left, sharing in now)
        seconds += step
        after = [(left - step / len(now) ** sharing, sharing) for left, sharing in now]
        now = [one for one in after if one[0] > DONE]
    return seconds
