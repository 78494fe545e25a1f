"""What has to happen before what, to turn one arrangement into another: removals, footings, places."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np

from topple.planner.building.standing import falling_in
from topple.planner.decide.arrange import Order
from topple.planner.decide.dependency import Dependency, dependencies
from topple.planner.decide.hold import Hold
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.problem import Act, Move, Pair, Problem, To
from topple.planner.rearranging.steady import brace
from topple.planner.rearranging.tolerances import NAMED
from topple.planner.tolerances import DISTURBED
from topple.topology.base.arrays import FloatArray, bounds
from topple.topology.geometry.axes import around
from topple.topology.situation.evidence import Evidence
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import classify
from topple.topology.statics.sweep import swept_matrix

SIDES = DISTURBED * np.column_stack([around(8), np.zeros(8)])
"""Pushes [m] that do not count as a move."""


@dataclass(frozen=True)
class OccupiedPlace:
    """`then` cannot be put to its place before `first` has left the one it has.

    Attributes:
        first: What is in the way.
        then: What shall be there.
        evidence: Relation of `then` as it is lowered to `first`, or of `first` as it is lifted to `then`.
    """

    first: str
    then: str
    evidence: tuple[Evidence, ...]

    def to_json(self) -> dict[str, Any]:
        """The entry of the JSON."""
        evidence = [each.to_json() for each in self.evidence]
        return {"first": self.first, "then": self.then, "evidence": evidence}

    def sentence(self) -> str:
        """The reason in words."""
        return f"{self.first} is where {self.then} goes"


@dataclass(frozen=True, eq=False)
class Precedences:
    """What a rearrangement has to heed.

    Attributes:
        problem: What is moved, and what must happen before what.
        removals: What must be taken before what, as things lie now.
        footings: What must be down before what, as they shall lie.
        places: What must be off whose place.
        holds: What stands in the goal only when it is held until a later thing is down.
    """

    problem: Problem
    removals: tuple[Dependency, ...]
    footings: tuple[Dependency, ...]
    places: tuple[OccupiedPlace, ...]
    holds: tuple[Hold, ...]

    def in_words(self, moves: Iterable[Move]) -> list[str]:
        """For each of some moves, the first to do first, where it goes and what waits for it, in words."""
        told: list[str] = []
        off, down = set[str](), set[str]()
        for move in moves:
            why: list[str] = []
            if move.object not in off:
                why += [e.sentence() for e in _direct(self.removals, off) if e.first == move.object]
                taken = [p.then for p in self.places if p.first == move.object and p.then not in down]
                why += (
                    [f"{move.object} is where {_count_words(taken)} {'goes' if len(taken) == 1 else 'go'}"]
                    if taken
                    else []
                )
                off.add(move.object)
            if move.to is To.GOAL:
                down.add(move.object)
                why += [
                    e.sentence()
                    for e in _direct(self.footings, down - {move.object})
                    if e.first == move.object
                ]
                why += [
                    f"hold {h.object} until {h.until} is down" for h in self.holds if h.since == move.object
                ]
            where = "to its place" if move.to is To.GOAL else "out of the way"
            told.append(f"{where}: {'; '.join(why) or 'nothing waits for it'}")
        return told


def precedences(
    before: Situation,
    arrangement: Arrangement,
    taken: Order,
    surfaces: Mapping[str, FloatArray],
    staying: Collection[str],
) -> Precedences:
    """Join what the removals, the building and the places ask for.

    Args:
        before: How things lie.
        arrangement: How they shall lie.
        taken: The order in which they could all be taken.
        surfaces: name -> (N, 3) points where it shall be, in the upright frame of `before` [m].
        staying: What is where it shall be.
    """
    rank = {name: k for k, name in enumerate(taken.order)}
    full = dependencies(before, direct=False).dependencies
    removals = tuple(e for e in full if rank[e.first] < rank[e.then])
    names = before.movable
    staying = tuple(name for name in names if name in staying)
    places = tuple(_places(before, surfaces, staying))
    first_off = brace(names, ((e.then, e.first) for e in removals), falling_in(before.sized.statics)).edges
    pairs: set[Pair] = {((Act.TAKE, b), (Act.TAKE, a)) for a, b in first_off}
    pairs |= {((Act.PUT, a), (Act.PUT, b)) for a, b in arrangement.first_down}
    pairs |= {((Act.TAKE, place.first), (Act.PUT, place.then)) for place in places}
    moving = tuple(name for name in names if name not in staying)
    problem = Problem(moving, staying, frozenset(pairs))
    return Precedences(problem, removals, arrangement.built.footings, places, arrangement.built.holds)


def _count_words(names: Sequence[str]) -> str:
    """Names as words, of many the first two and how many there are besides."""
    if len(names) > NAMED:
        return f"{', '.join(names[:2])} and {len(names) - 2} others"
    return " and ".join((", ".join(names[:-1]), names[-1])) if len(names) > 1 else names[0]


def _direct(edges: Iterable[Dependency], over: Collection[str]) -> list[Dependency]:
    """Those of some dependencies that do not follow from two others, among what is still to come.

    Args:
        edges: Dependencies, with those that follow.
        over: What has come already.
    """
    left = {(e.first, e.then): e for e in edges if not {e.first, e.then} & set(over)}
    later: dict[str, set[str]] = {}
    for first, then in left:
        later.setdefault(first, set()).add(then)
    return [
        edge
        for (first, then), edge in left.items()
        if not any(then in later.get(between, ()) for between in later[first] - {then})
    ]


def _places(
    start: Situation, goal: Mapping[str, FloatArray], staying: Iterable[str]
) -> Iterable[OccupiedPlace]:
    """Find objects in, over or under a place of the goal at the start: a straight way would meet them."""
    kept = frozenset(staying)  # about whose places start and goal say all there is
    for first, then in permutations(start.movable, 2):
        here, there = start.surfaces[first], goal[then]
        (low, high), (least, most) = bounds(here), bounds(there)
        if {first, then} & kept or (low > most)[:2].any() or (high < least)[:2].any():
            continue
        ways = ((then, there, first, here), (first, here, then, there))
        found = tuple(
            Evidence(a, b, classify(swept_matrix(body, met)), 0.0, True, swept=True)
            for a, body, b, met in ways
            if _meets(body, met)
        )
        if found:
            yield OccupiedPlace(first, then, found)


def _meets(swept: FloatArray, other: FloatArray) -> bool:
    """Whether a straight way up or down meets something by more than what does not count as a move."""
    return all(swept_matrix(swept, other + push)[1, 0] > 0 for push in (np.zeros(3), *SIDES))
