"""How far reasoning and simulated lifts are believed: rates of error measured on piles whose truth is known.

The odds that a dependency holds are multiplied by how much more often simulation says what it said where one
holds than where none does (Bayes' rule with measured likelihoods). The three trials of a pair are not
independent, as they share most of the rebuilt bodies, so their count has a likelihood of its own. From
cameras only a move counts: bodies with guessed sides are completed so that they stand, and standing is no
news.

What reasoning found is believed as often as what was found in the same way was right: a dependency that both
questions answer yes (would a lift meet it, would it fall) hardly ever fails. What it did not find is
overlooked more often of two things that touch than of two that only hang together through others, and mostly
of the higher of the two.

The rates are of piles of `topple.benchmarks.piles` that no score is reported on, half a case added to every
count. They stand in `rates.json` with what they were counted on; `python -m topple.benchmarks.rates` counts
them anew.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TypedDict

import msgspec

from topple.planner.decide.tolerances import CERTAIN, WIDE
from topple.topology.confidence import view_of

Likelihoods = tuple[tuple[float, float], ...]
"""For 0 to 3 of three trials in which it moved: how often that happens with a dependency, and without."""

Overlooked = tuple[tuple[float, float], ...]
"""For things that touch, that hang together through others, and that do neither: how often a dependency
holds where reasoning found none, if the first one is the lower and if it is the higher of the two."""

Found = tuple[float, float, float, float]
"""How often a dependency holds that reasoning found by both questions, by a lift that meets more than
`WIDE` of it, by one that meets less, and by a fall alone."""


@dataclass(frozen=True)
class Rates:
    """Error rates of reasoning and of simulation.

    Attributes:
        steady: Likelihoods where both rebuilt bodies stood still by themselves.
        shaky: Likelihoods where one of them did not.
        overlooked: How often a dependency holds where reasoning found none.
        found: How often one holds where reasoning found it.
    """

    steady: Likelihoods
    shaky: Likelihoods
    overlooked: Overlooked
    found: Found


def rates_for(cameras: int | None) -> Rates:
    """The error rates for what was seen.

    Args:
        cameras: How many cameras saw the scene; None for whole surfaces.
    """
    return _counted()[view_of(cameras or 0)]


class _Kept(TypedDict):
    rates: dict[str, Rates]


@cache
def _counted() -> Mapping[str, Rates]:
    kept = files("topple.planner.decide").joinpath("rates.json").read_bytes()
    return msgspec.json.decode(kept, type=_Kept)["rates"]


def way_found(push: float | None, falls: bool) -> int:
    """In which way reasoning found a dependency.

    Args:
        push: How far a lift pushes the object aside [m]; None where it meets nothing.
        falls: Whether the object falls once the other one is gone.

    Returns:
        Position in `Found`.
    """
    if push is None:
        return 3
    return 0 if falls else 1 if push > WIDE else 2


def posterior(prior: float, moved: int, trials: int, steady: bool, rates: Rates) -> float:
    """Chance that a dependency holds after it was tried in simulation.

    Args:
        prior: Chance by reasoning.
        moved: Trials in which the object moved.
        trials: Trials made; of less than three the share counts.
        steady: Whether both rebuilt bodies stood still by themselves.
        rates: Error rates.

    Returns:
        0..1; what reasoning alone says where there was no trial.
    """
    if trials == 0:
        return prior
    prior = min(prior, CERTAIN)
    odds = prior / (1 - prior)
    table = rates.steady if steady else rates.shaky
    with_it, without = table[round(moved * (len(table) - 1) / trials)]
    odds *= with_it / without
    return odds / (1 + odds)
