"""From a scene to another one: which thing to move next, which to put out of the way first, and why."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from topple.planner.budget import within_budget
from topple.planner.decide.dependency import Dependency
from topple.planner.decide.hold import Hold
from topple.planner.planning.order import order
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.moves import fewest_moves
from topple.planner.rearranging.precedences import OccupiedPlace, precedences
from topple.planner.rearranging.problem import Move, To
from topple.planner.tolerances import DISTURBED
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import ByValue
from topple.topology.io.load import AnyScene
from topple.topology.kernels.neighbours import PointTree
from topple.topology.situation.situation import Situation
from topple.topology.statics.support import Support

if TYPE_CHECKING:
    from topple.planner.planning.plan_format import Plan
    from topple.robots.arm.arm import Arm


MATCHES = ("name", "shape")
"""By what a thing of one scene is found in the other."""


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

    Examples:
        >>> rearrange(scene, scene).moves
        ()
    """

    moves: tuple[Move, ...]
    bound: int
    removals: tuple[Dependency, ...]
    footings: tuple[Dependency, ...]
    places: tuple[OccupiedPlace, ...]
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


@overload
def rearrange(
    start: AnyScene | Situation,
    goal: AnyScene | Situation | Mapping[str, Any],
    *,
    match: str = ...,
    budget: float | None = ...,
) -> Rearrangement: ...


@overload
def rearrange(
    start: AnyScene | Situation,
    goal: AnyScene | Situation | Mapping[str, Any],
    robot: "Arm | str",
    *,
    match: str = ...,
    budget: float | None = ...,
    **options: Any,
) -> "Plan": ...


@checked_arguments
@within_budget
def rearrange(
    start: AnyScene | Situation,
    goal: AnyScene | Situation | Mapping[str, Any],
    robot: "Arm | str | None" = None,
    *,
    match: str = "name",
    budget: float | None = None,
    **options: Any,
) -> "Rearrangement | Plan":
    """Find the fewest moves from one arrangement to another; for an arm, with their motions.

    What must go first at the start, what must be down first in the goal, and what
    must be off whose place are one graph; a cycle of it costs a buffer on free table, which is taken to be
    there. An arm needs more: where it finds no motion for a move, another move comes first, or what is in
    its way has to make room.

    Args:
        start: How things lie.
        goal: How they shall lie: a scene in the same frame; words, as "bowl on plate, spoon left of plate";
            or a document of relations, as `Relations.to_json` gives it.
        robot: The arm, or its name; None: the moves alone.
        match: By what things are matched: "name", or "shape", where those of the goal have other names; what
            is taken to be what, and how far their clouds are apart, is among the assumptions.
        budget: Wall-clock seconds for the whole call: what takes longer fails.
        **options: With an arm, those of `topple.planner.plan`: base, q_start, grasps, check, seed and others.

    Returns:
        The moves, with the least number there can be; with an arm, the certified plan.

    Raises:
        InvalidInput: A scene has no `up` or nothing that moves, the two have other things or another `up`,
            nothing is matched by what `match` says, or nothing can lie as the goal has it.
        NoSafePlan: What must happen before what closes a cycle that no buffer opens; or the arm cannot do it.
        OutOfBudget: The budget ran out.

    Examples:
        >>> beside = scene.with_cloud("cup", scene.clouds["cup"] + [0, 0.2, -0.04])
        >>> [(move.object, str(move.to)) for move in rearrange(scene, beside).moves]
        [('cup', 'goal')]
    """
    if match not in MATCHES:
        raise InvalidInput(f"match is {match!r}: expected one of {', '.join(MATCHES)}")
    before = Situation.of(start)
    wanted = _goal_of(goal, before, match)
    if robot is None:
        return _fewest(before, wanted)
    from topple.planner.planning.plan import plan
    from topple.planner.rearranging.task import ArrangementTask

    return plan(before.scene, ArrangementTask(wanted), robot, **options)


def _goal_of(goal: AnyScene | Situation | Mapping[str, Any], before: Situation, match: str) -> Arrangement:
    """How things shall lie, worked out where it is told."""
    if isinstance(goal, str):
        from topple.planner.rearranging.words import arrange_by_words  # lets things go in simulation

        return arrange_by_words(goal, before)
    if isinstance(goal, Mapping):
        from topple.planner.rearranging.related import arrange_by_relations

        return arrange_by_relations(goal, before)
    after = Situation.of(goal)
    return Arrangement(after) if match == "name" else Arrangement.alike(before.scene, after.scene)


def _fewest(before: Situation, arrangement: Arrangement) -> Rearrangement:
    """The fewest moves, given room beside everything."""
    arrangement.check(before)
    taken, built = order(before), arrangement.built
    surfaces = _align(arrangement.situation, before)
    staying = [name for name in before.movable if _same(before.surfaces[name], surfaces[name])]
    needed = precedences(before, arrangement, taken, surfaces, staying)
    told = map(str, arrangement.matches)
    held = [f"{' and '.join(g)} hold each other at the start: hold the others" for g in taken.groups]
    found = fewest_moves(needed.problem)
    said = zip(found.moves, needed.in_words(found.moves), strict=True)
    return Rearrangement(
        moves=found.moves,
        bound=found.bound,
        removals=needed.removals,
        footings=needed.footings,
        places=needed.places,
        supports=before.supports,
        holds=needed.holds,
        assumptions=tuple(dict.fromkeys((*told, *taken.assumptions, *held, *built.assumptions))),
        explanation=tuple(f"{k}. {move.object} {why}" for k, (move, why) in enumerate(said, start=1)),
    )


def _align(goal: Situation, start: Situation) -> Mapping[str, FloatArray]:
    """The surfaces of the goal in the upright frame of the start."""
    turn = goal.statics.upright.rotation @ start.statics.upright.rotation.T
    return {name: goal.surfaces[name] @ turn for name in goal.movable}


def _same(a: FloatArray, b: FloatArray) -> bool:
    """Whether a thing is where it was, but for what does not count as a move."""
    far = max(float(np.quantile(PointTree(one).query(other)[0], 0.95)) for one, other in ((a, b), (b, a)))
    return far < DISTURBED and float(np.linalg.norm(a.mean(axis=0) - b.mean(axis=0))) < DISTURBED
