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
count; `python -m topple.benchmarks.rates` counts them anew. Likelihoods and what is overlooked: 41 piles a
view, even seeds from 7,300,000, by the maker as of commit 88ce6e0 (from 3d582bb on there are more kinds of
things), reasoned about and lifted with the code of 4208c70. What is found: the 35 odd seeds from 7,300,001 by
the same maker and the seeds 7,400,025 to 7,400,044 by that of 3d582bb, with the code of 7371fa7.
"""

from dataclasses import dataclass

from topple.planner.decide.tolerances import CERTAIN, WIDE

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


WHOLE = Rates(
    steady=((0.076, 0.979), (0.022, 0.015), (0.057, 0.004), (0.845, 0.003)),
    shaky=((0.136, 0.942), (0.045, 0.032), (0.136, 0.019), (0.682, 0.006)),
    overlooked=((0.080, 0.293), (0.029, 0.090), (0.008, 0.008)),
    found=(0.996, 0.980, 0.679, 0.796),
)
"""Clouds of whole surfaces."""

SEVERAL = Rates(
    steady=((0.122, 0.982), (0.034, 0.011), (0.054, 0.005), (0.790, 0.003)),
    shaky=((0.083, 0.885), (0.226, 0.038), (0.274, 0.049), (0.417, 0.027)),
    overlooked=((0.065, 0.236), (0.029, 0.104), (0.005, 0.012)),
    found=(0.986, 0.954, 0.761, 0.475),
)
"""Clouds from several cameras."""

ONE = Rates(
    steady=((0.217, 0.985), (0.040, 0.013), (0.070, 0.001), (0.673, 0.002)),
    shaky=((0.447, 0.916), (0.174, 0.055), (0.098, 0.026), (0.280, 0.004)),
    overlooked=((0.088, 0.321), (0.039, 0.223), (0.019, 0.042)),
    found=(0.993, 0.946, 0.796, 0.357),
)
"""Clouds from one camera: what it did not see carries unseen."""


def rates_for(cameras: int | None) -> Rates:
    """The error rates for what was seen.

    Args:
        cameras: How many cameras saw the scene; None for whole surfaces.
    """
    if cameras is None:
        return WHOLE
    return ONE if cameras <= 1 else SEVERAL


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
