"""Of all orders that a dependency graph allows, the one that risks least, and of those the shortest way."""

from collections.abc import Mapping, Sequence
from math import log

import numpy as np

from topple.planner.decide.tolerances import EFFORT, LEAST_KEPT, SURE
from topple.topology.base.arrays import IntArray

Pairs = Mapping[tuple[str, str], float]
"""(first, then) -> a value of the ordered pair."""


def safest(
    units: Sequence[Sequence[str]],
    before: Sequence[frozenset[int]],
    chances: Pairs,
    ways: Pairs,
    wanted: frozenset[int] | None = None,
    removal_risk: float = 0.0,
) -> list[int]:
    """Choose among the orders that take every unit after those that must precede it.

    The chance that an order moves nothing is the product, over its steps, of the chances that the object
    taken carries none that is still there. Orders whose risks differ by less than about a percent are ranked
    by the way between successive takes, and then by the order in which the units are given.

    Args:
        units: Names that are taken together, one unit after another, those to be preferred first.
        before: Positions of the units that must precede each.
        chances: (first, then) -> chance that taking `then` moves `first`; 0 where not given.
        ways: (a, b) -> distance between two objects [m]; 0 where not given.
        wanted: Positions of the units that have to be taken; the others are where that lessens the risk. All
            of them if None.
        removal_risk: Chance that taking a unit does harm by itself, 0..1.

    Returns:
        Positions of the units to take, first to take first. The best there is of up to eight units, and of
        those looked at otherwise (a beam search that keeps the partial orders which risked least).
    """
    count = range(len(units))
    needed = frozenset(count) if wanted is None else wanted
    effort, goal = _percents(removal_risk), sum(1 << i for i in needed)
    risk = _risk_of(units, chances)
    way = [[round(1e3 * ways.get((one[-1], two[0]), 0.0)) for two in units] for one in units]
    first = [sum(1 << i for i in earlier) for earlier in before]
    kept: dict[tuple[int, int], _Partial] = {(0, -1): (0, 0, ())}
    done: list[_Partial] = []
    while True:
        done += [partial for (taken, _), partial in kept.items() if taken & goal == goal]
        kept = {key: partial for key, partial in kept.items() if key[0] & goal != goal}
        if done:  # what has risked as much already will not end better
            kept = {key: partial for key, partial in kept.items() if partial < min(done)}
        if not kept:
            return list(min(done)[2])
        longer: dict[tuple[int, int], tuple[int, int, tuple[int, ...], int]] = {}
        size = -(-len(units) // 8)
        packed = np.array([list(taken.to_bytes(size, "little")) for taken, _ in kept], dtype=np.uint8)
        there = 1 - np.unpackbits(packed, axis=1, count=len(units), bitorder="little").astype(np.int64)
        moves = (there @ risk).tolist()
        for ((taken, last), (risked, gone, path)), moved in zip(kept.items(), moves, strict=True):
            for j in count:
                if taken >> j & 1 or first[j] & ~taken:
                    continue
                step = way[last][j] if path else 0
                found = (risked + moved[j] + effort, gone + step, path, j)
                key = (taken | 1 << j, j)
                if key not in longer or found < longer[key]:
                    longer[key] = found
        best = sorted(longer.items(), key=lambda each: each[1])[: max(LEAST_KEPT, EFFORT // len(units))]
        kept = {key: (risked, gone, (*path, j)) for key, (risked, gone, path, j) in best}


def _risk_of(units: Sequence[Sequence[str]], chances: Mapping[tuple[str, str], float]) -> IntArray:
    """(U, U) risk [percent, added up] that the one unit moves as the other is taken while both are there."""
    unit_of = {name: number for number, unit in enumerate(units) for name in unit}
    risk = np.zeros((len(units), len(units)), dtype=np.int64)
    for (first, then), chance in chances.items():
        if first in unit_of and then in unit_of:
            risk[unit_of[first], unit_of[then]] += _percents(chance)
    np.fill_diagonal(risk, 0)  # what is taken together is held
    return risk


_Partial = tuple[int, int, tuple[int, ...]]
"""Risk [percent, added up], way [mm] and the positions taken so far."""


def _percents(chance: float) -> int:
    """Minus the logarithm of the chance that nothing happens, in hundredths: sums stand for products."""
    return round(-100 * log(1 - min(chance, SURE)))
