"""How far simulated lifts are believed: rates of error measured on piles whose truth is known.

The odds that a dependency holds are multiplied by how much more often simulation says what it said where one
holds than where none does (Bayes' rule with measured likelihoods). The three trials of a pair are not
independent, as they share most of the rebuilt bodies, so their count has a likelihood of its own. From
cameras only a move counts: bodies with guessed sides are completed so that they stand, and standing is no
news. What reasoning did not find is overlooked more often of two things that touch than of two that only hang
together through others, and mostly of the higher of the two.

The rates are of piles of `topple.benchmarks.piles` that no score is reported on, half a case added to every
count. They stand in `rates.json` with what they were counted on; `python -m topple.benchmarks.rates` counts
them anew.
"""

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import TypedDict

import msgspec

from topple.planner.decide.tolerances import CERTAIN
from topple.topology.confidence import view_of

Likelihoods = tuple[tuple[float, float], ...]
"""For 0 to 3 of three trials in which it moved: how often that happens with a dependency, and without."""


class _Kept(TypedDict):
    rates: dict[str, dict[str, Likelihoods]]


def overlooked(cameras: int) -> Likelihoods:
    """How often a dependency holds where reasoning found none.

    Args:
        cameras: How many cameras saw the scene; 0 for whole surfaces.

    Returns:
        For things that touch, that hang together through others, and that do neither: how often it does if
        the first one is the lower, and if it is the higher of the two.
    """
    return _counted()[view_of(cameras)]["overlooked"]


def likelihoods(cameras: int | None, steady: bool) -> Likelihoods:
    """How often simulated lifts say what they say.

    Args:
        cameras: How many cameras saw the scene; None for whole surfaces.
        steady: Whether both rebuilt bodies stood still by themselves.
    """
    return _counted()[view_of(cameras or 0)]["steady" if steady else "shaky"]


@cache
def _counted() -> Mapping[str, Mapping[str, Likelihoods]]:
    kept = files("topple.planner.decide").joinpath("rates.json").read_bytes()
    return msgspec.json.decode(kept, type=_Kept)["rates"]


def posterior(prior: float, moved: int, trials: int, table: Likelihoods) -> float:
    """Chance that a dependency holds after it was tried in simulation.

    Args:
        prior: Chance by reasoning.
        moved: Trials in which the object moved.
        trials: Trials made; of less than three the share counts.
        table: How often that many move with a dependency, and without.

    Returns:
        0..1; what reasoning alone says where there was no trial.
    """
    if trials == 0:
        return prior
    prior = min(prior, CERTAIN)
    odds = prior / (1 - prior)
    with_it, without = table[round(moved * (len(table) - 1) / trials)]
    odds *= with_it / without
    return odds / (1 + odds)
