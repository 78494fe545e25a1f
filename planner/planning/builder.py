"""A plan in the making: one step after the other, each in the situation that the ones before it leave."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.goal import Goal
from topple.planner.decide.hold import fixture_assumptions
from topple.planner.decide.tolerances import LIKELY
from topple.planner.errors import NoSafePlan
from topple.planner.formats.plan_robot import arm_data
from topple.planner.formats.plan_structs import DependencyData, ObjectData, Step
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.away import Away, Destination
from topple.planner.planning.follow import follow, next_step
from topple.planner.planning.order import ordered
from topple.planner.planning.plan_data import (
    DIGITS,
    away_data,
    dependency_data,
    objects_data,
    rounded_parts,
    said_unseen,
    step_data,
)
from topple.planner.planning.plan_format import Plan
from topple.planner.planning.step import Context, NextStep, Task
from topple.planner.planning.tolerances import MOST_STEPS
from topple.planner.transfer.prediction import after
from topple.planner.transfer.transfer import Transfer
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.solids import move_parts
from topple.topology.relations.relate import Relations
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

Progress = Callable[[str], None]
_Before = tuple[Situation, Context, dict[str, FloatArray]]
"""The situation, what the step was chosen in, and how things were moved."""


@dataclass
class PlanBuilder:
    """A plan in the making: the situation as it should be by now, and the steps that lead there.

    `context` is what the next step is chosen in, but for what follows from the steps. `reasons` has each
    dependency with the index of the step it was first seen at, `chosen` each step as it was chosen, `before`
    what held before each, and `barred` what was undone.
    """

    situation: Situation
    goal: Goal
    context: Context
    progress: Progress | None = None
    steps: list[Step] = field(default_factory=list[Step])
    tried: Counter[str] = field(default_factory=Counter[str])
    chosen: list[NextStep] = field(default_factory=list[NextStep])
    before: list[_Before] = field(default_factory=list[_Before])
    barred: list[Transfer] = field(default_factory=list[Transfer])
    reasons: dict[tuple[str, str], tuple[int, DependencyData]] = field(
        default_factory=dict[tuple[str, str], tuple[int, DependencyData]]
    )

    def __post_init__(self) -> None:
        self.started = self.last = time.perf_counter()
        self.up, self.start = self.situation.up, self.context.station.q
        self.objects = objects_data(self.situation)
        self.moved: dict[str, FloatArray] = {}
        self._known: Order | None = None
        self._ordered_in = self.situation

    def run(self, task: Task, asked: Callable[[Scene], Relations] | None) -> None:
        """Choose one step after the other; `asked` gives the relations before each where there is one."""
        self._known, most = None, MOST_STEPS * len(self.situation.movable)
        with self.context.sandbox:
            if follow(partial(self._choose, task), partial(self._go_on, asked), most):
                return
        again = ", ".join(sorted({step.object for step in self.steps[-3:]}))
        words = f"no end after {len(self.steps)} steps: the last ones move {again} again and again"
        raise NoSafePlan(words, (words,))

    def _choose(self, task: Task) -> NextStep | None:
        """The next step, by what the order of the last one leaves where that leads on."""
        context = self._context()
        try:
            return next_step(task, self.situation, self.goal, context)
        except NoSafePlan:
            if context.known is None:
                raise
        return next_step(task, self.situation, self.goal, replace(context, known=None))

    def _go_on(self, asked: Callable[[Scene], Relations] | None, chosen: NextStep) -> None:
        """Add a step, with what its order leaves and the relations where it leads."""
        if self._known is None or chosen.order.supports is not self._known.supports:
            self._ordered_in = self.situation  # it was asked anew
        plain = self.context.orderer is ordered and asked is None and not self.context.upright
        self._known = _left_by(chosen, self._ordered_in) if plain else None
        self.take(chosen)
        if asked is not None:
            scene = self.situation.scene
            self.situation = Situation.of(self.situation, check_relations(asked(scene), scene))

    def _context(self) -> Context:
        """Make the context in which the next step is chosen, with the rest of an earlier order."""
        avoid = dict[str, list[Grasp]]()
        for transfer in self.barred:
            avoid.setdefault(transfer.object, []).append(transfer.grasp)
        own = {
            name: [grasp.move(self.moved[name]) for grasp in some] if name in self.moved else some
            for name, some in self.context.grasps.items()
        }
        return replace(
            self.context, done=[(chosen.transfer.object, chosen.action) for chosen in self.chosen],
            grasps=own, clamped=self.context.clamped - self.moved.keys(), avoid=avoid,
            barred=[transfer.placement for transfer in self.barred], known=self._known,
        )  # fmt: skip

    def send_away(self, destination: Destination) -> None:
        """Have things go somewhere else than to what is seen.

        Raises:
            InvalidInput: There is no room for it, or the goal is an arrangement.
        """
        away = destination.at(self.situation, self.context.station.pose_base_to_world)
        if away is None:
            return
        if self.goal.poses:
            raise InvalidInput(f"away {destination.how}: an arrangement puts things to places of its own")
        self.context = replace(self.context, away=away, obstacles=away.bodies)
        self.objects += [ObjectData(name, True, rounded_parts(some)) for name, some in away.bodies.items()]

    def undo(self, index: int) -> None:
        """Take back the steps from one on, whose grasp and place are not tried again if there are others."""
        self.barred.append(self.chosen[index].transfer)
        self.situation, self.context, self.moved = self.before[index]
        self.reasons = {pair: since for pair, since in self.reasons.items() if since[0] < index}
        del self.steps[index:], self.chosen[index:], self.before[index:]

    def plan(self, base_searched: bool, assumptions: Sequence[str]) -> Plan:
        """Build the plan, as data."""
        context, arm = self.context, self.context.station.arm
        made = Plan(
            goal=self.goal.text,
            poses={name: np.round(pose, DIGITS).tolist() for name, pose in self.goal.poses.items()},
            robot=arm.name,
            arm=arm_data(arm),
            joints=list(arm.joints),
            seed=context.seed,
            pose_base_to_world=context.station.pose_base_to_world.tolist(),
            base_searched=base_searched,
            q_start=self.start.tolist(),
            order=[step.object for step in self.steps],
            dependencies=self.dependencies(),
            steps=self.steps,
            objects=self.objects,
            up=(float(self.up[0]), float(self.up[1]), float(self.up[2])),
            upright=sorted(context.upright),
            clamped=sorted(context.clamped),
            assumptions=[
                *assumptions,
                *fixture_assumptions(context.clamped),
                *said_unseen(self.steps),
                *([] if context.away is None else [context.away.assumption()]),
            ],
            away=None if context.away is None else away_data(context.away),
            certified=all(
                segment.certified for step in self.steps for segment in step.segments if segment.motion
            ),
            seconds=round(sum(chosen.transfer.seconds for chosen in self.chosen), 3),
            planning_seconds=round(self.last - self.started, 3),
            tried=dict(self.tried),
        )
        # for the names in its print
        vars(made)["scene"] = self.before[0][0].scene if self.before else self.situation.scene
        return made

    def dependencies(self) -> list[DependencyData]:
        """Why the steps come in this order: what had to go first when an object was taken."""
        handled = {step.object for step in self.steps}
        kept = {
            pair
            for pair in self.reasons
            if pair[0] in handled and self.reasons[pair][0] <= self.last_of(pair[1])
        }
        return [self.reasons[pair][1] for pair in sorted(kept)]

    def last_of(self, name: str) -> int:
        """Index of the last step of an object, -1 where it has none."""
        return max((index for index, step in enumerate(self.steps) if step.object == name), default=-1)

    def doubts(self, name: str) -> list[DependencyData]:
        """Unlikely dependencies that taking an object now violates: seen before and no more."""
        gone = {step.object for step in self.steps}
        return [
            data
            for (first, then), (_, data) in self.reasons.items()
            if then == name and first not in gone and data.confidence < LIKELY
        ]

    def take(self, chosen: NextStep) -> None:
        """Add a step, and go on from where it leads."""
        self.before.append((self.situation, self.context, dict(self.moved)))
        self.chosen.append(chosen)
        for edge in chosen.order.graph.dependencies:
            self.reasons.setdefault((edge.first, edge.then), (len(self.steps), dependency_data(edge)))
        transfer = chosen.transfer
        names = [step.object for step in self.steps]
        against = self.doubts(transfer.object)
        for edge in against:
            self.reasons.pop((edge.first, edge.then), None)
        below = {first for first, then in self.reasons if then == transfer.object}
        since = [index for index, name in enumerate(names) if name in below or name == transfer.object]
        before, self.last = self.last, time.perf_counter()
        falls = transfer.placement.falls
        reason = f"{chosen.reason}; it is let go to fall as it will" if falls else chosen.reason
        if transfer.object in self.context.clamped - self.moved.keys():
            reason = f"{reason}; the fixture lets go once the hand holds it"
        self.steps.append(step_data(chosen, reason, since, self.moved, self.last - before, against))
        self.tried.update(transfer.tried)
        pose = transfer.placement.pose_at_rest(self.up)
        context = self.context
        if transfer.placement.how is Away.ZONE:
            there = {transfer.object: move_parts(self.situation.solids[transfer.object], pose)}
            context = replace(context, obstacles={**context.obstacles, **there})
        self.context = replace(context, station=replace(context.station, q=transfer.q_end))
        self.situation = after(self.situation, transfer)
        for name in (transfer.object, *transfer.riding):
            self.moved[name] = pose @ self.moved.get(name, np.eye(4))
        if self.progress is not None:
            least = len(self.steps) + len(chosen.order.order) - 1
            count = f"{len(self.steps)} of {least}" if least >= len(self.steps) else str(len(self.steps))
            self.progress(f"{count}: {chosen.action} {transfer.object}: {reason}")


def _left_by(chosen: NextStep, situation: Situation) -> Order | None:
    """Shorten an order by its first object.

    None where that met others, which it may have held, and where what stood first could not be taken: then
    something else may better be next.

    Args:
        chosen: The step.
        situation: In which the order was asked for.
    """
    name, order = chosen.transfer.object, chosen.order
    meeting = {frozenset((each.a, each.b)) for each in situation.contacts} | situation.relations.meeting
    beside = {other for pair in meeting if name in pair for other in pair} - situation.scene.fixed
    if beside > {name} or chosen.fallbacks or order.order[:1] != (name,):
        return None
    left = tuple(target for target in order.targets if target != name)
    return replace(order.as_taken(order.order[1:]), targets=left)


def check_relations(relations: Relations | None, scene: Scene) -> Relations | None:
    """Refuse relations of other objects than the scene's."""
    if relations is not None and tuple(relations.objects) != tuple(scene.names):
        told = ", ".join(relations.objects)
        raise InvalidInput(f"the relations are of {told}, expected {', '.join(scene.names)}")
    return relations
