"""What a plan leads to: orders that are kept, and a goal that is reached."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree

from topple.planner.decide.goal import parse_goal
from topple.planner.decide.tolerances import LIKELY
from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import BROKEN, OFF_PLACE, Residual, Worst
from topple.planner.tolerances import DISTURBED
from topple.planner.verify.bodies import completed_of
from topple.planner.verify.tolerances import SURFACE
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import moved
from topple.topology.geometry.rigid import transformed
from topple.topology.geometry.samples import sampled
from topple.topology.scene import Scene
from topple.topology.situation import Situation

if TYPE_CHECKING:
    from topple.planner.decide.dependency import Dependency


def check_precedence(
    plan: PlanData, taken: Sequence[tuple[int, str]], situation: Situation | None
) -> tuple[Residual, ...]:
    """Check that nothing is taken before what has to go first.

    Args:
        plan: The plan.
        taken: What is taken, with the index of the step, as the actions have it.
        situation: What was seen; its dependencies are derived again. What a step says to go against is
            left out if it is more likely wrong than right.

    Returns:
        Residuals: dependencies of the plan, steps that do not wait for those before them, what steps say to
        go against and do not, and dependencies of the scene.
    """
    first = {name: index for index, name in reversed(taken)}
    last = {name: index for index, name in taken}
    never = len(plan.steps)
    own = Worst("dependencies of the plan broken", "1")
    waits = Worst("steps that wait for nothing and should", "1")
    excused = Worst("excuses for dependencies that are kept", "1")
    for edge in plan.dependencies:
        index = last.get(edge.then, -1)
        if edge.then in last and first.get(edge.first, never) > index:
            own.count(f"{edge.then} before {edge.first}", index)
        if first.get(edge.first, never) < index and first[edge.first] not in plan.steps[index].after:
            waits.count(f"step {index + 1} ({edge.then}) for {edge.first}", index)
    for index, step in enumerate(plan.steps):
        for edge in step.against:
            if edge.then != step.object or first.get(edge.first, never) < index or edge.confidence >= LIKELY:
                excused.count(f"step {index + 1} ({step.object}) for {edge.first}", index)
    if situation is None:
        return own.residual(), waits.residual(), excused.residual()
    again = Worst(BROKEN, "1")
    against = {(edge.first, edge.then) for step in plan.steps for edge in step.against}
    edges = [
        (edge.first, edge.then)
        for edge in _derived(plan, situation, first)
        if edge.confidence >= LIKELY or (edge.first, edge.then) not in against
    ]
    waited = _waited_for(plan)
    # what goes along with a container that is kept upright need not go before it
    along = {(held.object, step.object) for step in plan.steps for held in step.attachments if step.upright}
    for before, then in edges:
        if then not in first or (before, then) in along:
            continue
        if first.get(before, never) > first[then]:
            again.count(f"{then} before {before}", first[then])
        elif first[before] < first[then] and first[before] not in waited[first[then]]:
            again.count(f"step {first[then] + 1} ({then}) does not wait for {before}", first[then])
    return own.residual(), waits.residual(), excused.residual(), again.residual()


def _derived(plan: PlanData, situation: Situation, first: Mapping[str, int]) -> "tuple[Dependency, ...]":
    """The dependencies of what was seen, as a fixture leaves them that has not let go by then.

    Args:
        plan: The plan, which says what is clamped.
        situation: What was seen.
        first: The step that takes each object first.
    """
    from topple.planner.decide.dependency import DependencyGraph, dependencies, with_fixture

    if not plan.clamped:
        return dependencies(situation).dependencies
    full, never = dependencies(situation, direct=False), len(plan.steps)
    left: list[Dependency] = []
    for then in full.names:
        some = DependencyGraph(full.names, tuple(edge for edge in full.dependencies if edge.then == then))
        still = [name for name in plan.clamped if first.get(name, never) >= first.get(then, never)]
        left += with_fixture(some, situation.statics, still).dependencies
    return DependencyGraph(full.names, tuple(left)).reduced().dependencies


def _waited_for(plan: PlanData) -> list[set[int]]:
    """By step the steps that have to be done before it, directly or not."""
    found: list[set[int]] = []
    for step in plan.steps:
        found.append({index for before in step.after for index in (before, *found[before])})
    return found


def check_goal(
    plan: PlanData, poses: Mapping[str, FloatArray], taken: Sequence[tuple[int, str]], scene: Scene
) -> Residual:
    """Check the goal's relations on the clouds where the actions leave them.

    Args:
        plan: The plan.
        poses: Transforms (4, 4) of the objects since the plan began.
        taken: What is taken, with the index of the step.
        scene: What was seen.

    Returns:
        The number of clauses that do not hold.
    """
    after = scene
    for name in {name for _, name in taken}:
        cloud, pose = after.clouds[name], poses[name]
        after = after.with_cloud(name, transformed(cloud, pose))
    goal = parse_goal(plan.goal, scene)
    situation = Situation(after)
    missing = list(goal.unmet(situation.relations, scene.fixed, situation.supports))
    middles = {
        name: np.array([each.clouds[name].mean(axis=0) for each in (scene, after)]) for _, name in taken
    }
    freed = {name for name, (here, there) in middles.items() if np.linalg.norm(there - here) > DISTURBED}
    missing += [f"{name} is not taken elsewhere" for name in goal.free if name not in freed]
    worst = Worst("goal clauses unmet", "1")
    worst.note(float(len(missing)), "; ".join(missing))
    return worst.residual()


def check_poses(plan: PlanData, poses: Mapping[str, FloatArray]) -> Residual:
    """Check that what shall lie in a certain way does, where the actions leave it.

    Args:
        plan: The plan, which says how things shall lie, where that was given.
        poses: Transforms (4, 4) of the objects since the plan began.

    Returns:
        How far the surface of a body is from where it shall be, beyond what counts as a move.
    """
    worst = Worst(OFF_PLACE, "m", DISTURBED)
    wholes = completed_of(plan)  # what was seen of a round thing is another half once it is turned
    for name, wanted in plan.poses.items():
        surface = sampled(wholes[name], SURFACE)
        here, there = (moved((surface,), pose)[0] for pose in (poses[name], np.array(wanted)))
        ways = (KDTree(one).query(other)[0].max() for one, other in ((here, there), (there, here)))
        worst.note(float(max(ways)), name)
    return worst.residual()
