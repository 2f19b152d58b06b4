"""Seeds that nobody can have looked at: from the hash of the commit that is measured."""

from __future__ import annotations

import subprocess
from argparse import Namespace
from hashlib import sha256
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def commit() -> str:
    """Return the hash of HEAD; what is not committed would make a table that belongs to no commit.

    Raises
    ------
    SystemExit
        There are changes that are not committed, or there is no repository.
    """

    def git(*words: str) -> str:
        done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"git {' '.join(words)}: {done.stderr.strip()}; give --seeds for a trial")
        return done.stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no")
    if changed:
        raise SystemExit(f"not committed, so the seeds would be those of another program:\n{changed}")
    return git("rev-parse", "HEAD")


def commit_seed(origin: str, family: str, index: int) -> int:
    """Derive a seed of 64 bits from commit, family and number; its top bit is set.

    Development seeds are below 2³², so that the two can never be the same.
    """
    digest = sha256(f"{origin} {family} {index}".encode()).digest()
    return int.from_bytes(digest[:8], "big") | 1 << 63


def networks_asked_for(arguments: Namespace, of: str = "") -> tuple[str | None, list[tuple[str, int]]]:
    """List family and seed of each network that was asked for; ``of`` makes the seeds a program's own.

    Returns
    -------
    origin : str or None
        The commit whose seeds they are; None for seeds given by hand, which make no table to report.
    networks : list of (str, int)
        Of each family ``--networks``, or one for each of ``--seeds``.
    """
    origin = None if arguments.seeds else commit()
    return origin, [
        (family, seed)
        for family in arguments.families.split(",")
        for seed in arguments.seeds
        or [commit_seed(origin or "", of + family, index) for index in range(arguments.networks)]
    ]


def sizes_asked_for(arguments: Namespace, of: str) -> tuple[str | None, list[tuple[int, int]]]:
    """List size and seed of each network that was asked for; ``of`` makes the seeds a program's own.

    Returns
    -------
    origin : str or None
        As of :func:`networks_asked_for`.
    networks : list of (int, int)
        Of each of ``--cameras`` as many as ``--networks``, or one for each of ``--seeds``; the sizes in turn.
    """
    origin = None if arguments.seeds else commit()
    return origin, [
        (count, arguments.seeds[k] if arguments.seeds else commit_seed(origin or "", f"{of} {count}", k))
        for k in range(len(arguments.seeds or range(arguments.networks)))
        for count in arguments.cameras
    ]
