"""Of all orders that a dependency graph allows, the one that risks least, and of those the shortest way."""

from collections.abc import Mapping, Sequence
from itertools import product, repeat

import numpy as np

from topple.planner.decide.tolerances import EFFORT, LEAST_KEPT, SURE
from topple.topology.base.arrays import FloatArray, IntArray


def safest(
    units: Sequence[Sequence[str]],
    before: Sequence[frozenset[int]],
    chances: Mapping[tuple[str, str], float],
    places: Mapping[str, FloatArray],
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
        places: name -> (2,) where it is taken [m]; there is no way to and from others.
        wanted: Positions of the units that have to be taken; the others are where that lessens the risk. All
            of them if None.
        removal_risk: Chance that taking a unit does harm by itself, 0..1.

    Returns:
        Positions of the units to take, first to take first. The best there is of up to eight units, and of
        those looked at otherwise (a beam search that keeps the partial orders which risked least).
    """
    count = len(units)
    goal = np.isin(np.arange(count), range(count) if wanted is None else list(wanted))
    risk, way = _risk_of(units, chances), _way_of(units, places)
    first = np.array([[i in earlier for earlier in before] for i in range(count)], dtype=np.int64)
    effort, most = _percents(np.array(removal_risk)), max(LEAST_KEPT, EFFORT // max(count, 1))
    # A row for each partial order, in the order of their paths: of equals the first one is taken.
    paths, cost, last = np.zeros((1, 0), dtype=np.int64), np.zeros(1, dtype=np.int64), np.array([-1])
    there, moved, waits = np.ones((1, count), dtype=bool), risk.sum(axis=0)[None], first.sum(axis=0)[None]
    ended: list[tuple[int, list[int]]] = []
    while True:
        done = np.asarray(~(there & goal).any(axis=1))
        ended = sorted([*ended, *zip(cost[done].tolist(), paths[done].tolist(), strict=True)])[:1]
        if ended:  # what has risked as much already will not end better
            done |= np.array([each >= ended[0] for each in zip(cost.tolist(), paths.tolist(), strict=True)])
        if done.all():
            return ended[0][1]
        rows, taken = np.nonzero(there & (waits == 0) & ~done[:, None])
        # a percent more of risk counts for more than any way [mm]
        longer = cost[rows] + (moved[rows, taken] + effort << 32) + way[last[rows], taken]
        sets = np.unique(np.packbits(there, axis=1), axis=0, return_inverse=True)[1].ravel()
        chosen = _least(longer, sets[rows] * count + taken, most, len(there))
        rows, last, cost = rows[chosen], taken[chosen], longer[chosen]
        there, moved, waits = there[rows], moved[rows] - risk[last], waits[rows] - first[last]
        there[np.arange(len(last)), last] = False
        paths = np.column_stack([paths[rows], last])


def _least(costs: IntArray, keys: IntArray, most: int, alike: int) -> IntArray:
    """Positions, rising, of the least costs with different keys; of equal ones the first.

    Args:
        costs: (N,) costs.
        keys: (N,) what each is of.
        most: How many are wanted.
        alike: How many at most have one key.
    """
    enough = min(most * alike, len(costs)) - 1
    near = np.flatnonzero(costs <= np.partition(costs, enough)[enough])
    ranked = near[np.argsort(costs[near], kind="stable")]
    return np.sort(ranked[np.sort(np.unique(keys[ranked], return_index=True)[1])[:most]])


def _risk_of(units: Sequence[Sequence[str]], chances: Mapping[tuple[str, str], float]) -> IntArray:
    """(U, U) risk [percent, added up] that the one unit moves as the other is taken while both are there."""
    names = [name for unit in units for name in unit]
    risk = _percents(np.reshape([*map(chances.get, product(names, names), repeat(0.0))], 2 * [len(names)]))
    begin = np.cumsum([0, *map(len, units)])[:-1]
    risk = np.add.reduceat(np.add.reduceat(risk, begin, axis=0), begin, axis=1)
    np.fill_diagonal(risk, 0)  # what is taken together is held
    return risk


def _way_of(units: Sequence[Sequence[str]], places: Mapping[str, FloatArray]) -> IntArray:
    """(U + 1, U) level way [mm] from where one unit ends to where another begins; none before the first."""
    at = [[places.get(unit[k], [np.nan] * 2) for k in (-1, 0)] for unit in units]
    end, begin = np.array(at).reshape(-1, 2, 2).swapaxes(0, 1)
    way = np.hypot(*(begin - end[:, None]).transpose(2, 0, 1))
    return np.vstack([np.rint(1e3 * np.nan_to_num(way)), np.zeros(len(units))]).astype(np.int64)


def _percents(chance: FloatArray) -> IntArray:
    """Minus the logarithm of the chance that nothing happens, in hundredths: sums stand for products."""
    return np.rint(-100 * np.log(1 - np.minimum(chance, SURE))).astype(np.int64)
