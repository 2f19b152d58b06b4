"""What a stage's measurement is, and the tables in which it is printed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

__all__ = ["Stage", "print_tables", "to_json"]


@dataclass
class Stage:
    """One stage of epibar beside its limit and its peers.

    Attributes
    ----------
    name : str
    unit : str
        What the work is counted in.
    units : float
        How much of it was done.
    seconds : float
        By epibar.
    limit_seconds : float, optional
        What the machine needs at least, and ``limit`` says by which measure.
    peers : dict of str to float
        Seconds of others for the same work.
    notes : dict of str to str
        Anything else worth a line.
    missing : list of str
        Peers that are not installed.
    """

    name: str
    unit: str
    units: float
    seconds: float
    limit: str = ""
    limit_seconds: float | None = None
    peers: dict[str, float] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)

    @property
    def nanoseconds(self) -> float:
        """Per unit."""
        return 1e9 * self.seconds / self.units


def print_tables(stages: Sequence[Stage]) -> None:
    """Print the stages and then their peers, as Markdown."""
    print("\n| stage | work | seconds | ns per unit | share of the limit |")
    print("| --- | --- | --- | --- | --- |")
    for stage in stages:
        share = "-"
        if stage.limit_seconds is not None:
            share = f"{100 * stage.limit_seconds / stage.seconds:.0f} % ({stage.limit})"
        work = f"{stage.units:.3g} {stage.unit}"
        print(f"| {stage.name} | {work} | {stage.seconds:.3g} | {stage.nanoseconds:.3g} | {share} |")
    print("\n| stage | peer | seconds | times ours |")
    print("| --- | --- | --- | --- |")
    for stage in stages:
        for peer, seconds in stage.peers.items():
            print(f"| {stage.name} | {peer} | {seconds:.3g} | {seconds / stage.seconds:.3g} |")
    for stage in stages:
        for what, value in stage.notes.items():
            print(f"\n{stage.name}: {what}: {value}")
    missing = sorted({peer for stage in stages for peer in stage.missing})
    if missing:
        print(f"\nNot installed, so not compared: {', '.join(missing)} (make bench installs them)")


def to_json(stages: Sequence[Stage]) -> list[dict[str, Any]]:
    """All figures."""
    return [{**asdict(stage), "ns_per_unit": stage.nanoseconds} for stage in stages]
