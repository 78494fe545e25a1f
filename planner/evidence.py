"""How far a simulated lift is believed: rates of error measured on piles whose truth is known.

The odds that a dependency holds are multiplied by how much more often simulation says what it said where one
holds than where none does (Bayes' rule with measured likelihoods). The three trials of a pair are not
independent, as they share most of the rebuilt bodies, so their count has a likelihood of its own.

The rates were counted on piles of `topple.planner.piles` with even seeds from 7,300,000 (39 whole, 22 seen by
three cameras, 45 by one), which no score is reported on, half a case added to every count.
"""

from dataclasses import dataclass

Likelihoods = tuple[tuple[float, float], ...]
"""For 0 to 3 of three trials in which it moved: how often that happens with a dependency, and without."""


@dataclass(frozen=True)
class Rates:
    """Error rates of reasoning and of simulation.

    Attributes:
        steady: Likelihoods where both rebuilt bodies stood still by themselves.
        shaky: Likelihoods where one of them did not.
        overlooked: How often a dependency holds where reasoning found none.
    """

    steady: Likelihoods
    shaky: Likelihoods
    overlooked: float


WHOLE = Rates(
    steady=((0.055, 0.978), (0.038, 0.018), (0.038, 0.002), (0.869, 0.002)),
    shaky=((0.155, 0.921), (0.052, 0.050), (0.155, 0.007), (0.638, 0.021)),
    overlooked=0.041,
)
"""Clouds of whole surfaces."""

SEVERAL = Rates(
    steady=((0.108, 0.989), (0.057, 0.009), (0.077, 0.001), (0.758, 0.001)),
    shaky=((0.136, 0.908), (0.136, 0.071), (0.227, 0.010), (0.500, 0.010)),
    overlooked=0.051,
)
"""Clouds from several cameras."""

ONE = Rates(
    steady=((0.282, 0.988), (0.052, 0.009), (0.052, 0.003), (0.615, 0.001)),
    shaky=((0.456, 0.868), (0.115, 0.085), (0.060, 0.034), (0.368, 0.014)),
    overlooked=0.086,
)
"""Clouds from one camera: what it did not see carries unseen."""

CERTAIN = 0.98
"""Reasoning is never believed more than this."""


def rates_for(cameras: int | None) -> Rates:
    """The error rates for what was seen.

    Args:
        cameras: How many cameras saw the scene; None for whole surfaces.
    """
    if cameras is None:
        return WHOLE
    return ONE if cameras <= 1 else SEVERAL


def posterior(confidence: float | None, moved: int, trials: int, steady: bool, rates: Rates) -> float:
    """Chance that a dependency holds after it was tried in simulation.

    Args:
        confidence: That of reasoning, or None where it found no dependency.
        moved: Trials in which the object moved.
        trials: Trials made; of less than three the share counts.
        steady: Whether both rebuilt bodies stood still by themselves.
        rates: Error rates.

    Returns:
        0..1; what reasoning alone says where there was no trial.
    """
    prior = rates.overlooked if confidence is None else min(max(confidence, 1 - CERTAIN), CERTAIN)
    odds = prior / (1 - prior)
    if trials == 0:
        return prior if confidence is None else max(prior, 0.5)
    table = rates.steady if steady else rates.shaky
    with_it, without = table[round(moved * (len(table) - 1) / trials)]
    odds *= with_it / without
    return odds / (1 + odds)
