"""What a plan leads to: orders that are kept, and a goal that is reached."""

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.decide.goal import Action, parse_goal
from topple.planner.decide.tolerances import LIKELY
from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import BROKEN, OFF_PLACE, UNFOUND, Residual, Worst
from topple.planner.placement.away import Away
from topple.planner.tolerances import DISTURBED
from topple.planner.transfer.prediction import rested
from topple.planner.verify.bodies import completed_of
from topple.planner.verify.tolerances import ROUNDED_SCORE, SURFACE
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import moved
from topple.topology.geometry.rigid import transformed
from topple.topology.geometry.samples import sampled
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

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
    waits = Worst("steps that wait otherwise than dependencies say", "1")
    excused = Worst("excuses for dependencies that are kept", "1")
    for edge in plan.dependencies:
        index = last.get(edge.then, -1)
        if edge.then in last and first.get(edge.first, never) > index:
            own.count(f"{edge.then} before {edge.first}", index)
        if first.get(edge.first, never) < index and first[edge.first] not in plan.steps[index].after:
            waits.count(f"step {index + 1} ({edge.then}) for {edge.first}", index)
    known = {(edge.first, edge.then) for edge in plan.dependencies}
    for index, step in enumerate(plan.steps):
        known |= {(edge.first, edge.then) for edge in step.against}
        for before in step.after:
            name = plan.steps[before].object
            if name != step.object and (name, step.object) not in known:
                waits.count(f"step {index + 1} ({step.object}) for {name}, without a dependency", index)
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


def check_reasons(plan: PlanData, situation: Situation) -> Residual:
    """Check that a plan's dependencies are those of what was seen: each, with its reason and confidence.

    What a plan found of things that it had moved by then is looked for where its steps leave them.

    Args:
        plan: The plan.
        situation: What was seen.

    Returns:
        The number of dependencies that are not found again.
    """
    worst = Worst(UNFOUND, "1")
    last = {step.object: index for index, step in enumerate(plan.steps)}
    said = {(edge.first, edge.then): edge for edge in plan.dependencies}
    if len(said) < len(plan.dependencies):
        worst.count("one is there twice", 0)
    excused = {(edge.first, edge.then) for step in plan.steps for edge in step.against}
    here, fixture, left = situation, set(plan.clamped), set(said)
    for index, step in enumerate(plan.steps):
        found = {(edge.first, edge.then): edge for edge in _graph(here, fixture)}
        for pair in sorted(left & found.keys()):
            told, edge = said[pair], found[pair]
            if told.reason != edge.reason or abs(told.confidence - edge.confidence) > ROUNDED_SCORE:
                words = f"{told.reason} {told.confidence:g}, found {edge.reason} {edge.confidence:.4g}"
                worst.count(f"{pair[0]} before {pair[1]}: {words}", last.get(pair[1]))
        if index == 0:
            for pair in sorted(found.keys() - said.keys() - excused):
                if set(pair) <= last.keys() and last[pair[0]] < last[pair[1]]:
                    worst.count(f"{pair[0]} before {pair[1]} is left out", last[pair[1]])
        left -= found.keys()
        if not left:
            break
        place, riding = step.placement, {held.object for held in step.attachments} - {step.object}
        pose = np.array(place.pose_before_to_after)
        pose[:3, 3] -= place.drop * situation.up
        here = here.with_level_undersides() if index == 0 else here
        names = [step.object, *sorted(riding)]
        if place.how in tuple(Away):
            here = here.without(*names)
        else:
            here = rested(here, names, pose, place.into is None)
        fixture.discard(step.object)
    for first, then in sorted(left):
        worst.count(f"{first} before {then}", last.get(then, last.get(first, 0)))
    return worst.residual()


def _graph(situation: Situation, fixture: Collection[str]) -> "tuple[Dependency, ...]":
    """The dependencies that orders rest on, with what a fixture keeps."""
    from topple.planner.decide.dependency import dependencies, with_fixture

    if not fixture:
        return dependencies(situation).dependencies
    full = dependencies(situation, direct=False)
    return with_fixture(full, situation.sized.statics, fixture).reduced().dependencies


def check_actions(plan: PlanData, scene: Scene) -> Residual:
    """Check that each step is for what it says, by the goal.

    Args:
        plan: The plan.
        scene: What was seen.

    Returns:
        The number of steps that free, place or remove what they should not.
    """
    worst = Worst("actions that the goal does not ask for", "1")
    goal = parse_goal(plan.goal, scene)
    free = set(goal.free) | (set(scene.movable) if goal.empty else set())
    wanted = {Action.FREE: free, Action.PLACE: {*(place.object for place in goal.places), *plan.poses}}
    wanted[Action.REMOVE] = set(scene.movable)
    for index, step in enumerate(plan.steps):
        if step.object not in wanted.get(step.action, ()):  # type: ignore[call-overload]
            worst.count(f"step {index + 1} ({step.object}): {step.action}", index)
    done = {(step.object, step.action) for step in plan.steps}
    for action, names in ((Action.FREE, goal.free), (Action.PLACE, wanted[Action.PLACE])):
        for name in names:
            if (name, action) not in done and any(step.object == name for step in plan.steps):
                worst.count(f"{name}: no step says {action}")
    return worst.residual()


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
        left += with_fixture(some, situation.sized.statics, still).dependencies
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
        ways = (PointTree(one).query(other)[0].max() for one, other in ((here, there), (there, here)))
        worst.note(float(max(ways)), name)
    return worst.residual()
