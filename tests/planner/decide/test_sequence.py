from itertools import permutations
from math import prod

import numpy as np
import pytest

from topple.planner.decide.sequence import safest


def _safety(order: tuple[int, ...], chances: dict[tuple[str, str], float]) -> float:
    """Chance that nothing moves when units named by their positions go in an order."""
    return prod(
        1 - chances.get((str(later), str(now)), 0.0)
        for step, now in enumerate(order)
        for later in order[step + 1 :]
    )


@pytest.mark.parametrize("seed", range(12))
def test_no_allowed_order_is_safer(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    chances = {(str(i), str(j)): float(rng.uniform(0, 0.6)) for i, j in permutations(range(count), 2)}
    before = [frozenset(i for i in range(j) if rng.random() < 0.2) for j in range(count)]
    found = tuple(safest([(str(i),) for i in range(count)], before, chances, {}))
    allowed = [
        order
        for order in permutations(range(count))
        if all(order.index(i) < order.index(j) for j in range(count) for i in before[j])
    ]
    assert found in allowed
    best = max(_safety(order, chances) for order in allowed)
    assert _safety(found, chances) >= best * 0.9  # pairs count in hundredths, as the docstring says


@pytest.mark.parametrize("seed", range(12))
def test_no_set_of_removals_that_is_allowed_is_safer(seed):
    rng = np.random.default_rng(seed)
    count, harm = int(rng.integers(2, 6)), 0.1
    chances = {(str(i), str(j)): float(rng.uniform(0, 0.6)) for i, j in permutations(range(count), 2)}
    before = [frozenset(i for i in range(j) if rng.random() < 0.2) for j in range(count)]
    wanted = frozenset([count - 1])
    found = tuple(safest([(str(i),) for i in range(count)], before, chances, {}, wanted, harm))

    def safety(order: tuple[int, ...]) -> float:
        left = [order[: step + 1] for step in range(len(order))]
        return (1 - harm) ** len(order) * prod(
            1 - chances.get((str(other), str(gone[-1])), 0.0)
            for gone in left
            for other in set(range(count)) - set(gone)
        )

    allowed = [
        order
        for length in range(1, count + 1)
        for order in permutations(range(count), length)
        if order[-1] == count - 1 and all(before[j].issubset(order[:k]) for k, j in enumerate(order))
    ]
    assert found in allowed
    assert safety(found) >= max(map(safety, allowed)) * 0.9


def test_many_units_keep_what_must_precede():
    count = 40
    before = [frozenset({j - 1}) if j % 2 else frozenset[int]() for j in range(count)]
    found = safest([(str(i),) for i in range(count)], before, {}, {})
    assert sorted(found) == list(range(count))
    assert all(found.index(j - 1) < found.index(j) for j in range(1, count, 2))


def test_of_orders_equally_safe_the_shortest_way_is_taken_and_then_the_first_given():
    places = {str(i): np.array([at, 0.0]) for i, at in enumerate((0.0, 0.2, 0.1, 0.3))}
    units, free = [(str(i),) for i in range(4)], [frozenset[int]()] * 4
    assert safest(units, free, {}, places) == [0, 2, 1, 3]
    assert safest(units, free, {("2", "0"): 0.3}, places) == [3, 1, 2, 0]


def test_nothing_to_order():
    assert safest([], [], {}, {}) == []
