"""Rules of thumb for what must go first, to compare with."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import networkx as nx
import numpy as np

from topple.benchmarks.contrasts.nine import nine
from topple.benchmarks.contrasts.support_tree import support_tree
from topple.topology.base.arrays import FloatArray
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

NAIVE_DEVIATION = 0.003
"""The deviation factor δ [m] of the naive rule: three times the noise."""

REACH = 0.01
"""Boxes that come this close may touch [m]."""


@dataclass(frozen=True)
class Guess:
    """An answer to what must go first.

    Attributes:
        pairs: (first, then), their transitive closure is meant.
        order: All objects, first to take first.
        groups: Objects said to be taken together.
    """

    pairs: frozenset[tuple[str, str]]
    order: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...] = ()


def guesses() -> Mapping[str, Callable[[Scene, int], Guess]]:
    """By name: a scene with `up` = z and a seed to a guess."""
    return {
        "top height": lambda scene, seed: top_height(scene),
        "AABB above": lambda scene, seed: box_above(scene),
        "plain 6IM + height": lambda scene, seed: naive(scene),
        "9IM on solids + height": lambda scene, seed: by_nine(scene),
        "support tree": lambda scene, seed: by_support_tree(scene),
        "random": at_random,
    }


def top_height(scene: Scene) -> Guess:
    """The highest top first."""
    return _one_after_the_other(sorted(scene.movable, key=lambda name: -_top(scene.clouds[name])))


def at_random(scene: Scene, seed: int) -> Guess:
    """Any order."""
    names = list(scene.movable)
    np.random.default_rng(seed).shuffle(names)
    return _one_after_the_other(names)


def box_above(scene: Scene) -> Guess:
    """Of two boxes that meet, one over the other: the one with the higher centre first."""
    pairs: set[tuple[str, str]] = set()
    for a, b in combinations(scene.movable, 2):
        low_a, high_a, low_b, high_b = (
            bound
            for name in (a, b)
            for bound in (scene.clouds[name].min(axis=0), scene.clouds[name].max(axis=0))
        )
        gap = np.maximum(low_a, low_b) - np.minimum(high_a, high_b)
        if gap[2] <= REACH and (gap[:2] < 0).all():
            pairs.add((a, b) if low_a[2] + high_a[2] > low_b[2] + high_b[2] else (b, a))
    return _in_order(scene, pairs)


def naive(scene: Scene) -> Guess:
    """Of two objects that are not disjoint by the paper's rule, the one with the higher mean first."""
    relations = relate(scene, deviation=NAIVE_DEVIATION, plain=True)
    return _higher_first(scene, {(pair.a, pair.b): pair.relation for pair in relations})


def by_nine(scene: Scene) -> Guess:
    """The same of two objects that are not disjoint by the 9-intersection model on complete solids."""
    return _higher_first(scene, nine(scene))


def by_support_tree(scene: Scene) -> Guess:
    """The highest level of the support tree first."""
    return Guess(*support_tree(scene))


def _higher_first(scene: Scene, relations: Mapping[tuple[str, str], Relation]) -> Guess:
    height = {name: float(cloud[:, 2].mean()) for name, cloud in scene.clouds.items()}
    pairs = {
        (a, b) if height[a] > height[b] else (b, a)
        for (a, b), relation in relations.items()
        if relation is not Relation.DISJOINT and {a, b} <= set(scene.movable)
    }
    return _in_order(scene, pairs)


def _one_after_the_other(names: list[str]) -> Guess:
    return Guess(frozenset(combinations(names, 2)), tuple(names))


def _in_order(scene: Scene, pairs: set[tuple[str, str]]) -> Guess:
    """An order that keeps the pairs; of those that could go, the one with the highest top goes."""
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(scene.movable)
    graph.add_edges_from(pairs)
    names = nx.lexicographical_topological_sort(graph, key=lambda name: -_top(scene.clouds[name]))
    return Guess(frozenset(pairs), tuple(names))


def _top(cloud: FloatArray) -> float:
    return float(cloud[:, 2].max())
