"""The whole sequence before anything moves: order, grasps, placements and motions, step by step."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from topple.planner.base import choose_base
from topple.planner.errors import NoSafePlan
from topple.planner.goal import Goal, parse_goal
from topple.planner.next_step import NextStep, Station, StepChooser
from topple.planner.plan_data import objects_data, step_data
from topple.planner.plan_format import DependencyData, Plan, Step
from topple.planner.solids import solids_of
from topple.planner.transfer import scene_after
from topple.robots.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene

Progress = Callable[[str], None]
MOST_STEPS = 3  # for each object: a plan that handles one more often goes in circles


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
    return planning.plan(scene, start, given is None, scene.assumptions)


def plan_as_done(scene: Scene, goal: Goal, station: Station, steps: Sequence[NextStep], seed: int) -> Plan:
    """The plan a closed loop followed: each step planned from a look of its own.

    Args:
        scene: What was seen at the start.
        goal: What was wanted.
        station: The arm as it stood at the start, and before each step again.
        steps: What was chosen and done, in order.
        seed: Of every search.

    Returns:
        The plan; an assumption says that the arm goes home between the steps.
    """
    arm, pose, start = station.arm, station.pose_base_to_world, station.q
    planning = _Planning(scene, goal, arm, pose, start, seed, None)
    for chosen in steps:
        planning.take(chosen)
    note = "each step was planned from a look of its own; between steps the arm goes home"
    return planning.plan(scene, start, False, (*scene.assumptions, note))


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
        done: list[tuple[str, str]] = []
        for _ in range(MOST_STEPS * len(self.scene.movable)):
            station = Station(self.arm, self.pose_base_to_world, self.q)
            chosen = StepChooser(self.scene, self.goal, station, done=done, seed=self.seed).choose()
            if chosen is None:
                return
            self.take(chosen)
            done.append((chosen.transfer.object, chosen.action))
        again = ", ".join(sorted({step.object for step in self.steps[-3:]}))
        words = f"no end after {len(self.steps)} steps: the last ones move {again} again and again"
        raise NoSafePlan(words, (words,))

    def plan(
        self, scene: Scene, q_start: FloatArray, base_searched: bool, assumptions: Sequence[str]
    ) -> Plan:
        """What was planned, as data; `scene` is how it was at the start."""
        return Plan(
            goal=self.goal.text,
            robot=self.arm.name,
            joints=list(self.arm.joints),
            seed=self.seed,
            pose_base_to_world=self.pose_base_to_world.tolist(),
            base_searched=base_searched,
            q_start=q_start.tolist(),
            order=[step.object for step in self.steps],
            dependencies=self.dependencies(),
            steps=self.steps,
            objects=objects_data(scene, solids_of(scene)),
            assumptions=list(assumptions),
            seconds=round(self.seconds, 3),
            tried=dict(self.tried),
        )

    def dependencies(self) -> list[DependencyData]:
        handled = {step.object for step in self.steps}
        return [edge for pair, edge in sorted(self.reasons.items()) if set(pair) <= handled]

    def take(self, chosen: NextStep) -> None:
        for edge in chosen.order.graph.dependencies:
            self.reasons.setdefault(
                (edge.first, edge.then),
                DependencyData(edge.first, edge.then, str(edge.reason), round(float(edge.confidence), 4)),
            )
        transfer = chosen.transfer
        names = [step.object for step in self.steps]
        before = {first for first, then in self.reasons if then == transfer.object}
        after = [index for index, name in enumerate(names) if name in before or name == transfer.object]
        self.steps.append(step_data(transfer, chosen.action, chosen.reason, after))
        self.tried.update(transfer.tried)
        self.seconds += transfer.seconds
        self.scene, self.q = scene_after(self.scene, transfer), transfer.q_end
        if self.progress is not None:
            self.progress(f"{len(self.steps)}. {chosen.action} {transfer.object}: {chosen.reason}")
