"""The fewest holds, against every order and every way to hold."""

from collections.abc import Callable
from itertools import chain, combinations, permutations

import networkx as nx
import numpy as np
import pytest

from topple.planner.building.apart import removals
from topple.planner.building.prefixes import fewest_holds

Names = frozenset[str]


def world(seed: int, count: int) -> tuple[list[frozenset[int]], Callable[[Names, Names], Names]]:
    """Units of one object each: what must be down before each, and what falls of what is there.

    Each object stands where it is held, where one of its sets of supporters is there, or where something it
    hangs together with is held; and some tip where a load is there and its counterweight is not.
    """
    rng = np.random.default_rng(seed)
    names = [str(k) for k in range(count)]
    rank = rng.permutation(count)
    before = [
        frozenset(int(j) for j in range(count) if rank[j] < rank[k] and rng.random() < 0.2)
        for k in range(count)
    ]

    def some(without: str) -> Names:
        others = [name for name in names if name != without]
        size = int(rng.integers(0, min(3, count)))
        return frozenset(str(name) for name in rng.choice(others, size, replace=False))

    carriers = {name: [some(name) for _ in range(int(rng.integers(1, 3)))] for name in names}
    helpers = {name: some(name) if rng.random() < 0.3 else frozenset() for name in names}
    tips = [
        tuple(map(str, rng.choice(names, 3, replace=False))) for _ in range(count // 3 if count > 2 else 0)
    ]

    def falling(placed: Names, held: Names) -> Names:
        def stands(name: str) -> bool:
            if name in held or helpers[name] & held & placed:
                return True
            tipped = any(name == t and load in placed and weight not in placed for t, load, weight in tips)
            return not tipped and any(each <= placed for each in carriers[name])

        return frozenset(name for name in placed if not stands(name))

    return before, falling


def subsets(names: Names) -> list[Names]:
    every = chain.from_iterable(combinations(sorted(names), k) for k in range(len(names) + 1))
    return [frozenset(each) for each in every]


def by_every_order(before: list[frozenset[int]], falling: Callable[[Names, Names], Names]) -> int:
    """Holds of the best order, each prefix held in every possible way; taking hold again counts again."""
    best = len(before)
    for order in permutations(range(len(before))):
        if any(not before[unit] <= set(order[:k]) for k, unit in enumerate(order)):
            continue
        costs = {frozenset[str](): 0}
        for k in range(len(order)):
            placed = frozenset(str(unit) for unit in order[: k + 1])
            standing = [held for held in subsets(placed) if not falling(placed, held)]
            costs = {
                held: min(cost + len(held - earlier) for earlier, cost in costs.items()) for held in standing
            }
        best = min(best, *costs.values())
    return best


def by_every_set(before: list[frozenset[int]], falling: Callable[[Names, Names], Names]) -> int:
    """Size of the smallest set that, held whenever it is there, lets some order stand."""
    names = frozenset(str(k) for k in range(len(before)))
    for held in subsets(names):  # the small ones first
        reached = {frozenset[int]()}
        for _ in before:
            reached = {
                down | {unit}
                for down in reached
                for unit, needed in enumerate(before)
                if unit not in down and needed <= down
                if not falling(there := frozenset(map(str, down | {unit})), held & there)
            }
        if reached:
            return len(held)
    raise AssertionError("everything held stands")


def solved(before: list[frozenset[int]], falling: Callable[[Names, Names], Names]) -> int:
    """Number of holds, after the order and the holds were checked."""
    count = len(before)
    units = [(str(k),) for k in range(count)]
    found = fewest_holds(units, before, falling, nx.complete_graph([str(k) for k in range(count)]))
    assert found.proven
    assert sorted(found.path) == list(range(count))
    for k, unit in enumerate(found.path):
        assert before[unit] <= set(found.path[:k])
        placed = frozenset(str(each) for each in found.path[: k + 1])
        held = frozenset(n for n, (first, last) in found.held.items() if first <= k < last)
        assert held <= placed
        assert not falling(placed, held)
    return len(found.held)


@pytest.mark.parametrize("seed", range(16))
def test_no_order_of_five_needs_fewer_holds(seed):
    before, falling = world(seed, 3 + seed % 3)
    assert solved(before, falling) == by_every_order(before, falling)


@pytest.mark.parametrize("seed", range(16))
def test_no_order_of_eight_needs_fewer_holds(seed):
    before, falling = world(1000 + seed, 6 + seed % 3)
    assert solved(before, falling) == by_every_set(before, falling)


def test_worlds_of_the_tests_need_holds_and_do_not():
    counts = {solved(*world(1000 + seed, 7)) for seed in range(20)}
    assert {0, 1, 2} <= counts


def test_the_first_order_found_is_taken_where_there_are_too_many():
    before, falling = world(1003, 8)
    units = [(str(k),) for k in range(8)]
    found = fewest_holds(units, before, falling, nx.complete_graph(list("01234567")), most_states=2)
    assert not found.proven
    placed = [frozenset(str(unit) for unit in found.path[: k + 1]) for k in range(8)]
    held = [frozenset(n for n, (a, b) in found.held.items() if a <= k < b) for k in range(8)]
    assert not any(falling(there, still) for there, still in zip(placed, held, strict=True))


def test_one_thing_is_held_that_steadies_two():
    def falling(placed: Names, held: Names) -> Names:
        if "last" in placed or "post" in held:
            return frozenset()
        return (placed & {"left", "right"}) - held

    units = [("post",), ("left",), ("right",), ("last",)]
    before = [frozenset[int](), frozenset({0}), frozenset({0}), frozenset({1, 2})]
    found = fewest_holds(units, before, falling, nx.star_graph(["post", "left", "right", "last"]))
    assert found.held == {"post": (1, 3)}


def by_every_removal(before: list[frozenset[int]], falling: Callable[[Names, Names], Names]) -> int:
    """Holds of the best order of removals, whatever is held at each; taking hold again counts again."""
    best = len(before)
    for taken in permutations(range(best)):
        if any(not before[unit] <= set(taken[k + 1 :]) for k, unit in enumerate(taken)):
            continue
        costs = {frozenset[str](): 0}
        for k in range(len(taken)):
            left = frozenset(str(unit) for unit in taken[k + 1 :])
            standing = [held for held in subsets(left) if not falling(left, held)]
            costs = {
                held: min(cost + len(held - earlier) for earlier, cost in costs.items()) for held in standing
            }
        best = min(best, *costs.values())
    return best


def taken_apart(before: list[frozenset[int]], falling: Callable[[Names, Names], Names]) -> int:
    """Number of holds, after every removal was looked at."""
    names = [str(k) for k in range(len(before))]
    over = [(str(low), str(high)) for high, lows in enumerate(before) for low in lows]
    units, found = removals(names, over, falling, nx.complete_graph(names))
    taken = [units[k] for k in found.path]
    assert found.proven
    assert sorted(taken) == [(name,) for name in names]
    for k, (name,) in enumerate(taken):
        left = frozenset(other for (other,) in taken[k + 1 :])
        assert not {str(low) for low in before[int(name)]} - left, "what is lifted meets nothing"
        held = frozenset(n for n, (since, until) in found.held.items() if since <= k < until)
        assert held <= left
        assert not falling(left, held)
    return len(found.held)


@pytest.mark.parametrize("seed", range(12))
def test_no_order_of_five_removals_needs_fewer_holds(seed):
    before, falling = world(seed, 3 + seed % 3)
    assert taken_apart(before, falling) == by_every_removal(before, falling)


@pytest.mark.parametrize("seed", range(12))
def test_no_order_of_eight_removals_needs_fewer_holds(seed):
    before, falling = world(1000 + seed, 6 + seed % 3)
    assert taken_apart(before, falling) == by_every_set(before, falling)


def test_what_hooks_into_each_other_is_taken_at_once():
    units, found = removals(
        ["a", "b", "c"], [("a", "b"), ("b", "a")], lambda *_: frozenset(), nx.complete_graph(["a", "b", "c"])
    )
    assert sorted(units[k] for k in found.path) == [("a", "b"), ("c",)]
