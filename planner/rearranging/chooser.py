"""The next move of a rearrangement that an arm can make; where it finds none, what has to make room first."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.goal import Action, Goal, Place, holds
from topple.planner.errors import NoSafePlan
from topple.planner.failure import TransferFailure
from topple.planner.fallbacks import Relaxation
from topple.planner.placement.lowered import lower
from topple.planner.placement.placement import Placement
from topple.planner.placement.resting import about
from topple.planner.planning.next_step import StepChooser, no_room
from topple.planner.planning.step import Context, NextStep
from topple.planner.planning.tolerances import CHOICE
from topple.planner.planning.transfers import Transfers
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.moves import Moves, contract, fewest_moves
from topple.planner.rearranging.precedences import Precedences, precedences
from topple.planner.rearranging.problem import Act, Move, Pair, Problem, To
from topple.planner.rearranging.registration import Registration, turns
from topple.planner.rearranging.tolerances import MOST_LEARNED, RAISED, RISK_STEP, TURNS
from topple.planner.transfer.segments import SegmentKind
from topple.planner.transfer.transfer import Transfer
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points, turned_to
from topple.topology.situation.situation import Situation

Starting = Callable[[Move], Order]
"""The order of which a move is the first."""

TAKING = (SegmentKind.GRASP, SegmentKind.APPROACH, SegmentKind.LIFT)


class MoveChooser:
    """Chooses the next move of a rearrangement in one situation.

    Args:
        situation: What is seen, or what should be there by now.
        goal: What shall hold in the end.
        context: What it is chosen in; an order of its own decides what lies on what.
        arrangement: How things shall lie.
        learned: What was found to have to happen before what, for the arm.
        learn: Told of each further such pair.
    """

    def __init__(
        self,
        situation: Situation,
        goal: Goal,
        context: Context,
        arrangement: Arrangement,
        *,
        learned: frozenset[Pair],
        learn: Callable[[Pair], object],
    ) -> None:
        self._situation, self._scene, self._goal, self._context = situation, situation.scene, goal, context
        self._arrangement = arrangement
        self._learned, self._learn = set(learned), learn
        known = [name for name in situation.movable if name in arrangement.situation.movable]
        self._fits = {name: arrangement.fit(name, situation) for name in known}
        self._moving = tuple(name for name in known if not self._is_there(name))
        self._transfers = Transfers(situation, _avoiding_misplacement(context, self._moving))
        self._failed: dict[Move, TransferFailure] = {}

    def unmet(self) -> tuple[str, ...]:
        """Say which objects are not where, or not in or on what, they shall be."""
        told = (name for name in self._moving if name not in self._arrangement.pose_free)
        far = tuple(f"{name} is {_off(self._fits[name])}" for name in told)
        return (
            *self._lost(),
            *far,
            *self._goal.unmet(self._situation.relations, self._scene.fixed, self._situation.supports),
        )

    def choose(self) -> NextStep | None:
        """The next step; None where everything is where it shall be.

        Raises:
            NoSafePlan: No order of moves leads there, or the arm can make none of those that may come next.
        """
        if lost := self._lost():
            raise NoSafePlan("; ".join(lost), lost)
        if not self._moving:
            return None
        taken = self._context.ask(self._situation, self._situation.movable)
        needed = self._precedences(taken)
        while True:
            problem = replace(needed.problem, before=needed.problem.before | self._learned)
            found = fewest_moves(problem)
            starting = partial(_as_moves, taken, needed, found.moves)
            ready = sorted(_ready(problem, found), key=lambda move: _risk_now(taken, move.object))
            several = Relaxation.ANOTHER_FIRST in self._context.relaxations
            for move in ready if several else ready[:1]:
                if (step := self._step(move, needed, starting)) is not None:
                    return step
            if not several or len(self._failed) > MOST_LEARNED or not self._learned_more(problem):
                failures = tuple(self._failed.values())
                words = tuple(map(str, failures))
                raise NoSafePlan("; ".join(words), words, failures)

    def _lost(self) -> tuple[str, ...]:
        return tuple(
            f"{name} is seen nowhere any more"
            for name in self._arrangement.situation.movable
            if name not in self._scene.clouds
        )

    def _is_there(self, name: str) -> bool:
        """Whether an object is where it shall be; in a plan what was put there is."""
        last = next((action for other, action in reversed(self._context.done) if other == name), None)
        if last is not None and not self._context.observed:
            return last == Action.PLACE
        place = self._arrangement.pose_free.get(name)
        if place is not None:
            return holds(place, self._situation.relations, self._situation.supports)
        return self._fits[name].stays

    def _precedences(self, taken: Order) -> Precedences:
        """Find which moves have to happen before which."""
        upright = self._situation.statics.upright.rotation
        surfaces = dict(self._situation.surfaces)
        for name in self._moving:
            pose = self._fits[name].pose
            surfaces[name] = move_points(surfaces[name] @ upright, pose) @ upright.T
        staying = set(self._situation.movable) - set(self._moving)
        return precedences(self._situation, self._arrangement, taken, surfaces, staying)

    def _step(self, move: Move, needed: Precedences, starting: Starting) -> NextStep | None:
        """A move as a step, where the arm can make it; it is tried once."""
        if move in self._failed:
            return None
        found = self._to_goal(move.object) if move.to is To.GOAL else self._aside(move.object)
        if isinstance(found, TransferFailure):
            self._failed[move] = self._transfers.explain(found)
            return None
        buffer = move.to is To.BUFFER
        why = needed.in_words([move])[0]
        said = "; ".join([why, *map(str, self._failed.values())])
        fallbacks = (Relaxation.ANOTHER_FIRST,) if self._failed else ()
        action = Action.REMOVE if buffer else Action.PLACE
        return NextStep(found, action, said, starting(move), fallbacks=fallbacks, buffer=buffer)

    def _to_goal(self, name: str) -> Transfer | TransferFailure:
        """An object to where it shall be, however round things are turned there."""
        if name in self._arrangement.pose_free:
            return self._into(self._arrangement.pose_free[name])
        pose, up = self._fits[name].pose, self._situation.up
        place = lower(name, self._situation, pose)
        raised = 0.0 if place is None else float(up @ (place.pose_at_rest(up) - pose)[:3, 3])
        # what is still to be moved carries nothing: it bars the place, however little it sticks in there
        if place is None or raised > RAISED or place.into in self._moving:
            below = "nothing" if place is None else place.into or "something"
            text = f"{name} has {below} under its place"
            barring = {} if place is None or place.into is None else {place.into: 1}
            return TransferFailure.no_place(name, text, barring)
        # It comes to lie as it is told: higher by the noise of two clouds each, upper ones of a tower float.
        told = replace(place, drop=place.drop + max(0.0, raised))
        return self._transfers.to(name, self._equal_placements(name, told))

    def _into(self, place: Place) -> Transfer | TransferFailure:
        """An object to a spot in what it shall lie in: best where it pushes nothing that lies there."""
        name, contents = place.object, self._transfers.inside(place.where)
        every, gentle, kept = StepChooser(self._situation, self._goal, self._context).spots(place, CHOICE)
        spots = gentle if set(contents) - {name} else gentle or kept or every
        return self._transfers.to(name, spots) if spots else no_room(place)

    def _equal_placements(self, name: str, place: Placement) -> list[Placement]:
        """A placement, and those that look the same as the object is turned onto itself."""
        up, upright = self._situation.up, self._situation.statics.upright.rotation
        pose = place.pose_before_to_after
        there = move_points(self._situation.surfaces[name] @ upright, pose)
        middle = (there.min(axis=0) + there.max(axis=0)) / 2.0
        angles = turns(there, up)
        found: list[Placement] = []
        for angle in angles[:: max(1, len(angles) // TURNS)]:
            turn = turned_to(about(up, angle), middle, middle)
            found.append(replace(place, pose_before_to_after=turn @ pose))
        return found

    def _aside(self, name: str) -> Transfer | TransferFailure:
        """An object to free table, off every place that is still to be taken."""
        places = [self._there(other) for other in self._moving]
        return self._transfers.aside(name, set(self._moving) - {name}, places)

    def _there(self, name: str) -> FloatArray:
        """(N, 3) what is seen of an object, where it shall be [m]."""
        pose = self._fits[name].pose
        return move_points(self._scene.clouds[name], pose)

    def _learned_more(self, problem: Problem) -> bool:
        """Take down what has to make room for a move that failed, where some order heeds it."""
        for move, failure in self._failed.items():
            for other in dict.fromkeys((*failure.barring, *self._transfers.barriers(failure))):
                if other not in (*problem.moving, *problem.staying) or other == move.object:
                    continue
                pairs = self._precedences_of(move, failure, other, problem)
                if pairs <= problem.before or not _possible(problem, pairs):
                    continue
                self._learned |= pairs
                for pair in pairs:
                    self._learn(pair)
                return True
        return False

    def _precedences_of(
        self, move: Move, failure: TransferFailure, other: str, problem: Problem
    ) -> frozenset[Pair]:
        """Learn what has to happen before a move whose hand or load another object is in the way of.

        What is where it shall be, and makes room, comes back only when the room is no longer needed.
        """
        got, name = failure.furthest, move.object
        if move.to is To.BUFFER or got is None or got.step in TAKING:
            back = {((Act.TAKE, name), (Act.PUT, other))} if other in problem.staying else set[Pair]()
            return frozenset({((Act.TAKE, other), (Act.TAKE, name)), *back})
        if other in self._moving:
            return frozenset({((Act.TAKE, other), (Act.PUT, name))})
        return frozenset({((Act.PUT, name), (Act.PUT, other))})


def _avoiding_misplacement(context: Context, moving: Sequence[str]) -> Context:
    """The context in which grasps count as failed that put what is to be moved again beside its place.

    What is held by its rim swings under the pads, is put down askew and comes level beside its place.
    """
    avoid = {name: (*context.avoid.get(name, ()), *context.placed.get(name, ())) for name in moving}
    return replace(context, avoid={**context.avoid, **avoid})


def _as_moves(taken: Order, needed: Precedences, moves: Sequence[Move], first: Move) -> Order:
    """An order as the moves that are made, what makes room among them, with one of them first."""
    moves = (first, *(move for move in moves if move != first))
    names = tuple(move.object for move in moves)
    told = zip(names, needed.in_words(moves), strict=True)
    said = tuple(f"{k}. {name}: {why}" for k, (name, why) in enumerate(told, start=1))
    return replace(taken, order=names, explanation=said)


def _risk_now(taken: Order, name: str) -> float:
    """The chance, in steps that matter, that something else moves as an object is taken now."""
    still = [1.0 - chance for (_, then), chance in taken.chances.items() if then == name]
    return RISK_STEP * round((1.0 - float(np.prod(still))) / RISK_STEP)


def _ready(problem: Problem, found: Moves) -> list[Move]:
    """The moves that wait for no other, in the order of a sequence."""
    graph = contract(problem, found.in_buffers)
    ready = {
        Move(name, To.BUFFER if kind == "take" else To.GOAL)
        for kind, name in graph
        if graph.in_degree((kind, name)) == 0
    }
    return [move for move in dict.fromkeys(found.moves) if move in ready]


def _possible(problem: Problem, pairs: frozenset[Pair]) -> bool:
    """Whether some sequence of moves heeds more pairs."""
    try:
        fewest_moves(replace(problem, before=problem.before | pairs))
    except NoSafePlan:
        return False
    return True


def _off(fit: Registration) -> str:
    """How far something is from where it should be, in words."""
    return f"{1e3 * fit.way:.0f} mm and {np.degrees(fit.turn):.0f} degrees from where it should be"
