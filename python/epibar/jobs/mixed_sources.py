"""Saved recordings and ready masks, which both are ``.npz``: told apart before anything is computed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..errors import EpibarError, is_address
from ..files.archive import array_names

__all__ = ["refuse_mixed"]

SAVED = "core_seed"
MASKS = "masks"


def refuse_mixed(sources: Sequence[str], masks: bool, spelt: Callable[[str], str]) -> None:
    """Refuse archives of the other kind than was said, as far as they can be read here.

    Parameters
    ----------
    sources : sequence of str
        Of all cameras.
    masks : bool
        Whether all are said to be ready masks.
    spelt : callable
        How the caller writes an argument's name.

    Raises
    ------
    EpibarError
        One is a saved recording and was said to be masks, or the other way round.
    """
    files = [source for source in sources if source.lower().endswith(".npz") and not is_address(source)]
    inside = {source: array_names(source) for source in files}
    saved = [source for source, names in inside.items() if SAVED in names]
    ready = [source for source, names in inside.items() if MASKS in names and SAVED not in names]
    option = spelt("masks")
    if saved and ready:
        raise EpibarError(
            f"{saved[0]} is a saved recording and {ready[0]} holds masks, and {option} is for all cameras or "
            f"for none: record the masks by themselves, 'epibar record {ready[0]} --masks --out FILE.npz', "
            f"and give saved recordings without {option}"
        )
    if saved and masks:
        raise EpibarError(f"{saved[0]}: a saved recording, not masks, which {option} says that all are")
    if ready and not masks:
        raise EpibarError(f"{ready[0]}: its key 'masks' says that it holds masks: give {option}")
