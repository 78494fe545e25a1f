"""What reasoning overlooks, and how far simulated lifts are believed: rates counted on piles of known truth.

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
from itertools import permutations
from typing import TypedDict

import msgspec
import networkx as nx

from topple.planner.decide.disturbance import Pair
from topple.planner.decide.tolerances import CERTAIN, MEETING
from topple.topology.sixim.confidence import view_of
from topple.topology.statics.rest import Statics

Rates = tuple[tuple[float, float], ...]
"""For 0 to 3 of three trials in which it moved: how often that happens with a dependency, and without. For
things as they stand to each other (`stances`): how often a dependency is overlooked if the first one is the
lower, and if it is the higher."""


class _Kept(TypedDict):
    rates: dict[str, dict[str, Rates]]


def oversights(statics: Statics, cameras: int) -> dict[Pair, float]:
    """How likely a dependency holds where reasoning finds none.

    Args:
        statics: The scene at rest.
        cameras: How many cameras saw it; 0 for whole surfaces.

    Returns:
        (first, then) -> 0..1 for every ordered pair of movable objects.
    """
    rates = _counted_rates()[view_of(cameras)]["overlooked"]
    return {pair: rates[row][column] for pair, (row, column) in stances(statics).items()}


def stances(statics: Statics) -> dict[Pair, tuple[int, int]]:
    """How objects stand to each other, which says how often a dependency of theirs is overlooked.

    Args:
        statics: The scene at rest.

    Returns:
        (first, then) -> whether they touch (0), hang together through others (1) or neither (2); whether the
        first one is the higher. For every ordered pair of movable objects.
    """
    names = statics.upright.movable
    meeting: nx.Graph[str] = nx.Graph()
    meeting.add_nodes_from(names)
    for contact in statics.contacts:
        if {contact.a, contact.b} <= meeting.nodes and contact.gaps.min() <= MEETING:
            meeting.add_edge(contact.a, contact.b)
    top = {name: float(statics.surfaces[name][:, 2].max()) for name in names}
    apart = (2, 0), (2, 1)  # most pairs of many
    found = {(first, then): apart[top[first] > top[then]] for first, then in permutations(names, 2)}
    for part in nx.connected_components(meeting):
        for pair in permutations(part, 2):
            found[pair] = 1 - meeting.has_edge(*pair), found[pair][1]
    return found


def likelihoods(cameras: int | None, steady: bool) -> Rates:
    """How often simulated lifts say what they say.

    Args:
        cameras: How many cameras saw the scene; None for whole surfaces.
        steady: Whether both rebuilt bodies stood still by themselves.
    """
    return _counted_rates()[view_of(cameras or 0)]["steady" if steady else "shaky"]


@cache
def _counted_rates() -> Mapping[str, Mapping[str, Rates]]:
    kept = files("topple.planner.decide").joinpath("rates.json").read_bytes()
    return msgspec.json.decode(kept, type=_Kept)["rates"]


def posterior(prior: float, moved: int, trials: int, table: Rates) -> float:
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
