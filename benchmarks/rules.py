"""Other people's orders for the same arm: what `topple bench run` is compared with."""

from collections.abc import Callable, Collection, Sequence
from itertools import combinations

import numpy as np

from topple.benchmarks.guesses import Guess, naive, top_height
from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.dependency import Dependency, DependencyGraph, Reason
from topple.planner.planning.step import Orderer
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

RULES = ("nearest first", "top height first", "plain 6IM + height")
"""Names of the rules."""


def order_by(rule: str, base: FloatArray) -> Orderer:
    """A rule in the place of `topple.planner.order`.

    Args:
        rule: One of `RULES`.
        base: (4, 4) pose_base_to_world of the arm.

    Returns:
        What a `StepChooser` takes as its `order`.
    """
    guess: dict[str, Callable[[Scene], Guess]] = {
        "nearest first": lambda scene: nearest(scene, base[:3, 3]),
        "top height first": top_height,
        "plain 6IM + height": naive,
    }

    def chosen(
        situation: Situation, targets: Sequence[str], *, beliefs: Beliefs | None = None, **_: object
    ) -> Order:
        put_down = frozenset[str]() if beliefs is None else beliefs.alone
        return _as_order(situation.scene, targets, guess[rule](situation.scene), put_down)

    return chosen


def nearest(scene: Scene, point: FloatArray) -> Guess:
    """What is nearest to a point first, seen from above.

    Args:
        scene: What is seen.
        point: (3,) where the arm stands [m].
    """

    def distance(name: str) -> float:
        return float(np.linalg.norm(scene.clouds[name].mean(axis=0)[:2] - point[:2]))

    names = sorted(scene.movable, key=distance)
    return Guess(frozenset(combinations(names, 2)), tuple(names))


def _as_order(scene: Scene, targets: Sequence[str], guess: Guess, put_down: Collection[str]) -> Order:
    """All that a rule takes before the targets, in its order; what it put down it does not take again."""
    edges = tuple(
        Dependency(first, then, Reason.BLOCKING, 1.0)
        for first, then in sorted(guess.pairs)
        if first not in put_down
    )
    # One above the other in one place, all ways are equally short: the highest goes first.
    ranks = {name: np.array([0.0, 0.0, -float(place)]) for place, name in enumerate(guess.order)}
    return arrange(DependencyGraph(scene.movable, edges), targets, ranks)
