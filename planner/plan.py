"""The whole sequence before anything moves: order, grasps, placements and motions, step by step."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from topple.planner.base import choose_base
from topple.planner.errors import NoSafePlan
from topple.planner.goal import Goal, Place, parse_goal
from topple.planner.order import Order, order
from topple.planner.placement import Placement, placements
from topple.planner.plan_data import step_data
from topple.planner.plan_format import DependencyData, Plan, Step
from topple.planner.solids import solids_of
from topple.planner.stacking import placements_on
from topple.planner.transfer import Transfer, TransferFailure, plan_transfer, scene_after
from topple.robots.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.arrays import FloatArray
from topple.topology.relate import relate
from topple.topology.scene import Scene
from topple.topology.support import supports

Progress = Callable[[str], None]


def plan(
    scene: Scene,
    goal: str | Sequence[str],
    robot: Arm | str,
    *,
    base: FloatArray | None = None,
    q_start: FloatArray | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Plan:
    """Plan everything that reaches a goal.

    Objects are taken in the safe order of `topple.planner.order`; of those that nothing has to precede, the
    first the arm can take goes, and the scene as it then should be is planned on.

    Args:
        scene: What is seen, with `up`.
        goal: In words ("free plate", "lemon within bowl", "red on green on blue", "empty bowl", "sort"), or
            names of objects to free.
        robot: The arm, or its name.
        base: (4, 4) pose_base_to_world; the scene's `robot_base`, or else searched for.
        q_start: (n,) joint values to start from [rad]; the arm's home where not given.
        seed: Of every search.
        progress: Called with a line for each step.

    Returns:
        The plan.

    Raises:
        NoSafePlan: There is none; the certificate has the cycle, or for each object why it cannot be moved.
        InvalidInput: The goal is none, or the scene does not know up.
    """
    arm = robot_named(robot) if isinstance(robot, str) else robot
    wanted = parse_goal(goal, scene)
    given = base if base is not None else scene.robot_base
    pose = choose_base(scene, arm) if given is None else np.asarray(given, dtype=np.float64)
    start = np.asarray(arm.home if q_start is None else q_start, dtype=np.float64)
    planning = _Planning(scene, wanted, arm, pose, start, seed, progress)
    planning.run()
    return Plan(
        goal=wanted.text,
        robot=arm.name,
        joints=list(arm.joints),
        seed=seed,
        pose_base_to_world=pose.tolist(),
        base_searched=given is None,
        q_start=start.tolist(),
        order=[step.object for step in planning.steps],
        dependencies=planning.dependencies(),
        steps=planning.steps,
        assumptions=list(scene.assumptions),
        seconds=round(planning.seconds, 3),
        tried=dict(planning.tried),
    )


@dataclass
class _Planning:
    """A plan in the making: the scene as it should be by now, and the steps that lead there."""

    scene: Scene
    goal: Goal
    arm: Arm
    pose_base_to_world: FloatArray
    q: FloatArray
    seed: int
    progress: Progress | None
    steps: list[Step] = field(default_factory=list[Step])
    tried: Counter[str] = field(default_factory=Counter[str])
    seconds: float = 0.0
    reasons: dict[tuple[str, str], DependencyData] = field(
        default_factory=dict[tuple[str, str], DependencyData]
    )

    def run(self) -> None:
        self._free(self.goal.free, "free")
        relations = relate(self.scene)
        for container, inside in self.goal.contents(relations, self.scene.fixed).items():
            self._free(inside, "free", avoid=container)
        for place in self.goal.places:
            if place.how == "on":
                self._free(self._resting_on(place), "remove")
            self._place(place)

    def dependencies(self) -> list[DependencyData]:
        handled = {step.object for step in self.steps}
        return [edge for pair, edge in sorted(self.reasons.items()) if set(pair) <= handled]

    def _resting_on(self, place: Place) -> tuple[str, ...]:
        """What stands on a supporter and is not what shall stand there."""
        settled = {other.object for other in self.goal.places if other.where == place.where}
        return tuple(
            support.supported
            for support in supports(self.scene)
            if support.supporter == place.where
            and support.kind == "rests"
            and support.supported not in settled
        )

    def _free(self, targets: Sequence[str], action: str, avoid: str | None = None) -> None:
        """Take targets, and what has to go before them, to free places on the table."""
        left = [name for name in targets if not self._handled(name)]
        while left:
            chosen = self._ordered(left)
            name = self._one(chosen, left, action)
            left = [other for other in left if other != name]

    def _place(self, place: Place) -> None:
        """Take an object where the goal wants it, after what has to go before it."""
        while True:
            chosen = self._ordered([place.object])
            if len(chosen.order) == 1:
                break
            self._one(chosen, [], "remove")
        solids = solids_of(self.scene)
        places = placements_on(place.object, self.scene, place.where, place.how, solids)
        if not places:
            words = f"{place.object} would not stay {place.how} {place.where}"
            raise NoSafePlan(words, (words,))
        found = self._transfer(place.object, places)
        if isinstance(found, TransferFailure):
            raise NoSafePlan(str(found), (str(found),))
        self._take(found, "place", f"{place.object} shall be {place.how} {place.where}", chosen)

    def _ordered(self, targets: Sequence[str]) -> Order:
        chosen = order(self.scene, targets, seed=self.seed)
        if chosen.unresolved:
            cycles = tuple("cycle: " + " before ".join([*cycle, cycle[0]]) for cycle in chosen.unresolved)
            raise NoSafePlan(f"no safe order frees {', '.join(targets)}: {cycles[0]}", cycles)
        for edge in chosen.graph.dependencies:
            self.reasons.setdefault(
                (edge.first, edge.then),
                DependencyData(edge.first, edge.then, str(edge.reason), round(float(edge.confidence), 4)),
            )
        return chosen

    def _one(self, chosen: Order, targets: Sequence[str], action: str) -> str:
        """Take the first object of an order that can be taken now."""
        rank = {name: place for place, name in enumerate(chosen.order)}
        # within a group of a cycle the order says who starts, so only what comes earlier is waited for
        waiting = {
            edge.then
            for edge in chosen.graph.dependencies
            if edge.first in rank and edge.then in rank and rank[edge.first] < rank[edge.then]
        }
        failures: list[str] = []
        for name in chosen.order:
            if name in waiting:
                continue
            found = self._transfer(name, None)
            if isinstance(found, Transfer):
                is_target = name in targets
                why = "nothing has to go before it" if is_target else self._why(name, chosen)
                self._take(found, action if is_target else "remove", why, chosen)
                return name
            failures.append(str(found))
        if not failures:
            failures = [f"each of {', '.join(chosen.order)} has to go before another one"]
        raise NoSafePlan("; ".join(failures), tuple(failures))

    def _why(self, name: str, chosen: Order) -> str:
        after = [
            f"{edge.then} ({edge.reason})"
            for edge in chosen.graph.dependencies
            if edge.first == name and edge.then in chosen.order
        ]
        return f"has to go before {', '.join(after)}" if after else "is in the way"

    def _transfer(self, name: str, places: list[Placement] | None) -> Transfer | TransferFailure:
        solids = solids_of(self.scene)
        if places is None:
            places = placements(name, self.scene, solids, pose_base_to_world=self.pose_base_to_world)
        return plan_transfer(
            name, self.scene, solids, self.arm, self.pose_base_to_world, self.q, places, seed=self.seed
        )

    def _take(self, transfer: Transfer, action: str, reason: str, chosen: Order) -> None:
        names = [step.object for step in self.steps]
        before = {first for first, then in self.reasons if then == transfer.object}
        after = [index for index, name in enumerate(names) if name in before or name == transfer.object]
        self.steps.append(step_data(transfer, action, reason, after))
        self.tried.update(transfer.tried)
        self.seconds += transfer.seconds
        self.scene, self.q = scene_after(self.scene, transfer), transfer.q_end
        if self.progress is not None:
            self.progress(f"{len(self.steps)}. {action} {transfer.object}: {reason}")

    def _handled(self, name: str) -> bool:
        return any(step.object == name and step.action == "free" for step in self.steps)
