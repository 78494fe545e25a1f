"""From a scene to another one: which thing to move next, which to put out of the way first, and why."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import KDTree

from topple.planner.building.build import Hold, build_order
from topple.planner.building.standing import falling_in
from topple.planner.decide.dependency import Dependency, dependencies
from topple.planner.planning.order import order
from topple.planner.rearranging.moves import fewest_moves
from topple.planner.rearranging.problem import Act, Move, Pair, Problem, To
from topple.planner.rearranging.steady import steadied
from topple.planner.rearranging.tolerances import SECONDS
from topple.planner.tolerances import DISTURBED
from topple.topology.arrays import FloatArray, bounds
from topple.topology.errors import InvalidInput
from topple.topology.evidence import Evidence
from topple.topology.situation import Situation
from topple.topology.sixim.table import classify
from topple.topology.statics.support import Support
from topple.topology.statics.sweep import swept_matrix
from topple.topology.values import ByValue

if TYPE_CHECKING:
    from topple.topology.scene import Scene

SIDES = DISTURBED * np.array([[np.cos(a), np.sin(a), 0.0] for a in np.arange(8) * np.pi / 4])
"""Pushes [m] that do not count as a move."""


@dataclass(frozen=True)
class Place:
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
        return f"{self.first} is where {self.then} shall be"


@dataclass(frozen=True, eq=False)
class Rearrangement(ByValue):
    """The order of moves that turns one arrangement into another.

    Attributes:
        moves: First to do first.
        bound: No sequence has fewer moves.
        removals: What must be taken before what, as the start lies.
        footings: What must be down before what, as the goal lies.
        places: What must be off whose place.
        supports: What carries what at the start.
        holds: What stands in the goal only when it is held until a later thing is down.
        assumptions: What was assumed and not seen, in sentences.
        explanation: One sentence per move.
    """

    moves: tuple[Move, ...]
    bound: int
    removals: tuple[Dependency, ...]
    footings: tuple[Dependency, ...]
    places: tuple[Place, ...]
    supports: tuple[Support, ...]
    holds: tuple[Hold, ...]
    assumptions: tuple[str, ...]
    explanation: tuple[str, ...]

    @property
    def optimal(self) -> bool:
        """Whether no sequence has fewer moves, given room beside everything."""
        return len(self.moves) <= self.bound

    def to_json(self) -> dict[str, Any]:
        """The object that `topple order START --to GOAL --json` prints."""
        return {
            "format": "topple.order",
            "format_version": 1,
            "targets": [],
            "order": [move.object for move in self.moves],
            "moves": [{"object": m.object, "buffer": m.to is To.BUFFER} for m in self.moves],
            "bound": self.bound,
            "optimal": self.optimal,
            "dependencies": [edge.to_json() for edge in self.removals],
            "footings": [edge.to_json() for edge in self.footings],
            "places": [place.to_json() for place in self.places],
            "supports": [support.to_json() for support in self.supports],
            "holds": [hold.to_json() for hold in self.holds],
            "groups": [],
            "unresolved": [],
            "risk": {},
            "assumptions": list(self.assumptions),
            "explanation": list(self.explanation),
        }


def rearrange(
    start: "Scene | Situation", goal: "Scene | Situation", *, seconds: float = SECONDS
) -> Rearrangement:
    """Find the fewest moves from one arrangement to another.

    Things are matched by name. What must go first at the start, what must be down first in the goal, and what
    must be off whose place are one graph; a cycle of it costs a buffer on free table, which is taken to be
    there.

    Args:
        start: How things lie.
        goal: How they shall lie, in the same frame.
        seconds: How long to search for proof that no sequence is shorter.

    Returns:
        The moves, with the least number there can be.

    Raises:
        InvalidInput: A scene has no `up` or nothing that moves, or the two have other things or another `up`.
        NoSafePlan: What must happen before what closes a cycle that no buffer opens.
    """
    before, after = Situation.of(start), Situation.of(goal)
    _check(before, after)
    taken, built = order(before), build_order(after)
    rank = {name: k for k, name in enumerate(taken.order)}
    full = dependencies(before, direct=False).dependencies
    removals = tuple(edge for edge in full if rank[edge.first] < rank[edge.then])
    footings = built.footings
    names, surfaces = before.movable, _aligned(after, before)
    staying = tuple(n for n in names if _same(before.surfaces[n], surfaces[n]))
    places = tuple(_places(before, surfaces, staying))
    first_off = steadied(names, ((e.then, e.first) for e in removals), falling_in(before.statics)).edges
    first_down = steadied(names, ((e.first, e.then) for e in footings), falling_in(after.statics)).edges
    pairs: set[Pair] = {((Act.TAKE, b), (Act.TAKE, a)) for a, b in first_off}
    pairs |= {((Act.PUT, a), (Act.PUT, b)) for a, b in first_down}
    pairs |= {((Act.TAKE, place.first), (Act.PUT, place.then)) for place in places}
    held = [f"{' and '.join(g)} hold each other at the start: hold the others" for g in taken.groups]
    moving = tuple(name for name in names if name not in staying)
    found = fewest_moves(Problem(moving, staying, frozenset(pairs)), seconds)
    return Rearrangement(
        moves=found.moves,
        bound=found.bound,
        removals=removals,
        footings=footings,
        places=places,
        supports=before.supports,
        holds=built.holds,
        assumptions=tuple(dict.fromkeys((*taken.assumptions, *held, *built.assumptions))),
        explanation=_explained(found.moves, removals, footings, places, built.holds),
    )


def _check(start: Situation, goal: Situation) -> None:
    """Refuse scenes that cannot be one another."""
    for here, there, words in ((start, goal, "the goal"), (goal, start, "the start")):
        missing = [name for name in here.movable if name not in there.movable]
        if missing:
            raise InvalidInput(f"{', '.join(missing)}: not among what moves in {words}; things match by name")
    if float(start.up @ goal.up) < np.cos(np.radians(5.0)):
        raise InvalidInput("start and goal have another up: give both in one frame")


def _aligned(goal: Situation, start: Situation) -> Mapping[str, FloatArray]:
    """The surfaces of the goal in the upright frame of the start."""
    turn = goal.statics.upright.rotation @ start.statics.upright.rotation.T
    return {name: goal.surfaces[name] @ turn for name in goal.movable}


def _same(a: FloatArray, b: FloatArray) -> bool:
    """Whether a thing is where it was, but for what does not count as a move."""
    far = max(float(np.quantile(KDTree(one).query(other)[0], 0.95)) for one, other in ((a, b), (b, a)))
    return far < DISTURBED and float(np.linalg.norm(a.mean(axis=0) - b.mean(axis=0))) < DISTURBED


def _places(start: Situation, goal: Mapping[str, FloatArray], staying: Iterable[str]) -> Iterable[Place]:
    """What is in, over or under a place of the goal at the start: a straight way would meet it."""
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
            yield Place(first, then, found)


def _meets(swept: FloatArray, other: FloatArray) -> bool:
    """Whether a straight way up or down meets something by more than what does not count as a move."""
    return all(swept_matrix(swept, other + push)[1, 0] > 0 for push in (np.zeros(3), *SIDES))


def _explained(
    moves: Iterable[Move],
    removals: Iterable[Dependency],
    footings: Iterable[Dependency],
    places: Iterable[Place],
    holds: Iterable[Hold],
) -> tuple[str, ...]:
    """One sentence per move: where it goes, and what waits for it."""
    told: list[str] = []
    off, down = set[str](), set[str]()
    for number, move in enumerate(moves, start=1):
        why: list[str] = []
        if move.object not in off:
            why += [e.sentence() for e in removals if e.first == move.object and e.then not in off]
            why += [p.sentence() for p in places if p.first == move.object and p.then not in down]
            off.add(move.object)
        if move.to is To.GOAL:
            down.add(move.object)
            why += [e.sentence() for e in footings if e.first == move.object and e.then not in down]
            why += [f"hold {h.object} until {h.until} is down" for h in holds if h.since == move.object]
        where = "to its place" if move.to is To.GOAL else "out of the way"
        told.append(f"{number}. {move.object} {where}: {'; '.join(why) or 'nothing waits for it'}")
    return tuple(told)
