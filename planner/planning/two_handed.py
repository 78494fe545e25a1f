"""A whole sequence for two arms before anything moves: what one takes, and what the other holds for it."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from topple.planner.errors import NoSafePlan
from topple.planner.fallbacks import RELAXATIONS, select
from topple.planner.planning.follow import follow, next_step
from topple.planner.planning.holding import SECOND, check_second, standing_by
from topple.planner.planning.next_step import GoalTask
from topple.planner.planning.start import check_start
from topple.planner.planning.step import Context, NextStep, Task
from topple.planner.planning.tolerances import MOST_STEPS
from topple.planner.simulate.sandbox import Sandbox
from topple.planner.transfer.prediction import after
from topple.robots.arm.arm import Arm, Station
from topple.robots.catalog import robot as robot_named
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_pose
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.gravity import check_up


@checked_arguments
def plan_two_handed(
    scene: AnyScene,
    goal: str | Collection[str] | Task,
    robot: Arm | str,
    *,
    pose_base_to_world: FloatArray,
    pose_second_to_world: FloatArray,
    allow_drop: bool = False,
    relaxations: Collection[str] = RELAXATIONS,
    seed: int = 0,
) -> tuple[NextStep, ...]:
    """Plan everything that reaches a goal with two arms of a kind.

    The first arm does what takes one. What would not stand is held: one arm closes on it and keeps it where
    it is, the other takes the rest, and then the first takes it away, or lets go where it stands by itself.
    One arm moves at a time. Each motion is certified with the other arm as something that stands in the way,
    5 mm larger than it is. After a step the arm that took goes home, by a way that is left to whoever acts.

    Args:
        scene: What is seen, with `up`, or the path of it.
        goal: In words, names of objects to free, or any other task.
        robot: The arm, or its name.
        pose_base_to_world: (4, 4) where the first stands.
        pose_second_to_world: (4, 4) likewise of the second.
        allow_drop: As for `topple.planner.plan`.
        relaxations: Likewise.
        seed: Of every search.

    Returns:
        The steps in order. Before one with a `grip` the other arm takes hold; after one with `let_go` it lets
        go. Every motion of their segments has its certificate.

    Raises:
        NoSafePlan: There is none; the certificate has what each object fails of.
        InvalidInput: The goal is none, the scene does not know up, the arm has no fingers, or an arm touches
            something where it stands.

    Examples:
        >>> opposite = np.diag([-1.0, -1, 1, 1])
        >>> opposite[0, 3] = 1.0
        >>> places = {"pose_base_to_world": np.eye(4), "pose_second_to_world": opposite}
        >>> steps = plan_two_handed(scene, "free cup", "panda", **places)
        >>> [(step.transfer.object, step.by_second) for step in steps]
        [('cup', False)]
    """
    scene, arm = as_scene(scene), robot_named(robot) if isinstance(robot, str) else robot
    check_second(arm)
    allowed = select(relaxations)
    task = GoalTask.of(goal)
    wanted = task.goal(scene)
    check_up(scene)
    situation = Situation(scene).with_level_undersides()
    given = {"pose_base_to_world": pose_base_to_world, "pose_second_to_world": pose_second_to_world}
    first, second = (Station(arm, as_pose(pose, name), np.asarray(arm.home)) for name, pose in given.items())
    for station in (first, second):
        check_start(situation, arm, station.pose_base_to_world, station.q)
    steps: list[NextStep] = []

    def choose() -> NextStep | None:
        done = [(step.transfer.object, step.action) for step in steps]
        context = Context(
            first, done, allow_drop=allow_drop, relaxations=allowed, seed=seed,
            second=second, obstacles=standing_by(SECOND, second), sandbox=sandbox,
        )  # fmt: skip
        return next_step(task, situation, wanted, context)

    def do(chosen: NextStep) -> None:
        nonlocal situation
        for step in (replace(chosen, then=()), *chosen.then):
            steps.append(step)
            situation = after(situation, step.transfer)

    with Sandbox() as sandbox:
        if follow(choose, do, MOST_STEPS * len(situation.movable)):
            return tuple(steps)
    words = f"no end after {len(steps)} steps"
    raise NoSafePlan(words, (words,))
