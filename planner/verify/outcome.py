"""What a plan leads to: orders that are kept, and a goal that is reached."""

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.decide.goal import Action, parse_goal
from topple.planner.decide.tolerances import LIKELY
from topple.planner.placement.away import Away
from topple.planner.tolerances import DISTURBED
from topple.planner.transfer.prediction import rest_at
from topple.planner.verify.replay import Finding, Replay
from topple.planner.verify.tolerances import ROUNDED_SCORE, SURFACE
from topple.topology.bodies.solids import move_parts
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sample
from topple.topology.kernels.neighbours import PointTree
from topple.topology.situation.situation import Situation

if TYPE_CHECKING:
    from topple.planner.decide.dependency import Dependency

# -- what goes first


def _first(replay: Replay) -> dict[str, int]:
    """The index of the step that takes each object first, as the actions have it."""
    return {name: index for index, name in reversed(replay.taken)}


def out_of_order(replay: Replay) -> Iterator[Finding]:
    """Dependencies of the plan that it breaks."""
    first, last, never = _first(replay), dict(_by_name(replay)), len(replay.plan.steps)
    for edge in replay.plan.dependencies:
        if edge.then in last and first.get(edge.first, never) > last[edge.then]:
            yield Finding(1.0, f"{edge.then} before {edge.first}", last[edge.then])


def _by_name(replay: Replay) -> Iterator[tuple[str, int]]:
    return ((name, index) for index, name in replay.taken)


def waiting_otherwise(replay: Replay) -> Iterator[Finding]:
    """Steps that do not wait for what goes before them, or wait without a dependency."""
    plan, first, last = replay.plan, _first(replay), dict(_by_name(replay))
    for edge in plan.dependencies:
        index = last.get(edge.then, -1)
        if (
            first.get(edge.first, len(plan.steps)) < index
            and first[edge.first] not in plan.steps[index].after
        ):
            yield Finding(1.0, f"step {index + 1} ({edge.then}) for {edge.first}", index)
    known = {(edge.first, edge.then) for edge in plan.dependencies}
    for index, step in enumerate(plan.steps):
        known |= {(edge.first, edge.then) for edge in step.against}
        for before in step.after:
            name = plan.steps[before].object
            if name != step.object and (name, step.object) not in known:
                words = f"step {index + 1} ({step.object}) for {name}, without a dependency"
                yield Finding(1.0, words, index)


def excuses(replay: Replay) -> Iterator[Finding]:
    """Dependencies that steps say to go against, and keep, or that are likely."""
    first, never = _first(replay), len(replay.plan.steps)
    for index, step in enumerate(replay.plan.steps):
        for edge in step.against:
            if edge.then != step.object or first.get(edge.first, never) < index or edge.confidence >= LIKELY:
                yield Finding(1.0, f"step {index + 1} ({step.object}) for {edge.first}", index)


def out_of_seen_order(replay: Replay) -> Iterator[Finding]:
    """Dependencies of what was seen, derived again, that the plan breaks or does not wait for.

    What a step says to go against is left out if it is more likely wrong than right.
    """
    situation, plan, first = replay.situation, replay.plan, _first(replay)
    against = {(edge.first, edge.then) for step in plan.steps for edge in step.against}
    waited: list[set[int]] = []  # by step the steps that have to be done before it, directly or not
    for step in plan.steps:
        waited.append({index for before in step.after for index in (before, *waited[before])})
    # what goes along with a container that is kept upright need not go before it
    along = {(held.object, step.object) for step in plan.steps for held in step.attachments if step.upright}
    for edge in _derive(replay, situation):
        before, then = edge.first, edge.then
        doubted = edge.confidence < LIKELY and (before, then) in against
        if doubted or then not in first or (before, then) in along:
            continue
        if first.get(before, len(plan.steps)) > first[then]:
            yield Finding(1.0, f"{then} before {before}", first[then])
        elif first[before] < first[then] and first[before] not in waited[first[then]]:
            words = f"step {first[then] + 1} ({then}) does not wait for {before}"
            yield Finding(1.0, words, first[then])


def _derive(replay: Replay, situation: Situation) -> "tuple[Dependency, ...]":
    """The dependencies of what was seen, as a fixture leaves them that has not let go by then."""
    from topple.planner.decide.dependency import DependencyGraph, dependencies, with_fixture

    plan, first = replay.plan, _first(replay)
    if not plan.clamped:
        return dependencies(situation).dependencies
    full, never = dependencies(situation, direct=False), len(plan.steps)
    left: list[Dependency] = []
    for then in full.names:
        some = DependencyGraph(full.names, tuple(edge for edge in full.dependencies if edge.then == then))
        still = [name for name in plan.clamped if first.get(name, never) >= first.get(then, never)]
        left += with_fixture(some, situation.sized.statics, still).dependencies
    return DependencyGraph(full.names, tuple(left)).reduced().dependencies


def extra_dependencies(replay: Replay) -> Iterator[Finding]:
    """Dependencies that are not found again in what was seen, each with its reason and confidence.

    What a plan found of things that it had moved by then is looked for where its steps leave them.
    """
    here, plan = replay.situation, replay.plan
    last = {step.object: index for index, step in enumerate(plan.steps)}
    said = {(edge.first, edge.then): edge for edge in plan.dependencies}
    if len(said) < len(plan.dependencies):
        yield Finding(1.0, "one is there twice", 0)
    excused = {(edge.first, edge.then) for step in plan.steps for edge in step.against}
    fixture, left = set(plan.clamped), set(said)
    for index, step in enumerate(plan.steps):
        found = {(edge.first, edge.then): edge for edge in _graph(here, fixture)}
        for pair in sorted(left & found.keys()):
            told, edge = said[pair], found[pair]
            if told.reason != edge.reason or abs(told.confidence - edge.confidence) > ROUNDED_SCORE:
                words = f"{told.reason} {told.confidence:g}, found {edge.reason} {edge.confidence:.4g}"
                yield Finding(1.0, f"{pair[0]} before {pair[1]}: {words}", last.get(pair[1]))
        if index == 0:
            for pair in sorted(found.keys() - said.keys() - excused):
                if set(pair) <= last.keys() and last[pair[0]] < last[pair[1]]:
                    yield Finding(1.0, f"{pair[0]} before {pair[1]} is left out", last[pair[1]])
        left -= found.keys()
        if not left:
            break
        place, riding = step.placement, {held.object for held in step.attachments} - {step.object}
        pose = np.array(place.pose_before_to_after)
        pose[:3, 3] -= place.drop * here.up
        here = here.with_level_undersides() if index == 0 else here
        names = [step.object, *sorted(riding)]
        gone = place.how in tuple(Away)
        here = here.without(*names) if gone else rest_at(here, names, pose, place.into is None)
        fixture.discard(step.object)
    for first, then in sorted(left):
        yield Finding(1.0, f"{first} before {then}", last.get(then, last.get(first, 0)))


def _graph(situation: Situation, fixture: Collection[str]) -> "tuple[Dependency, ...]":
    """The dependencies that orders rest on, with what a fixture keeps."""
    from topple.planner.decide.dependency import dependencies, with_fixture

    if not fixture:
        return dependencies(situation).dependencies
    full = dependencies(situation, direct=False)
    return with_fixture(full, situation.sized.statics, fixture).reduced().dependencies


# -- what is reached


def not_asked_for(replay: Replay) -> Iterator[Finding]:
    """Steps that free, place or remove what the goal does not ask for, and none where it does."""
    plan, scene = replay.plan, replay.scene
    goal = parse_goal(plan.goal, scene)
    wanted: dict[str, set[str]] = {
        Action.FREE: set(goal.free) | (set(scene.movable) if goal.empty else set()),
        Action.PLACE: {*(place.object for place in goal.places), *plan.poses},
        Action.REMOVE: set(scene.movable),
    }
    for index, step in enumerate(plan.steps):
        if step.object not in wanted.get(step.action, ()):
            yield Finding(1.0, f"step {index + 1} ({step.object}): {step.action}", index)
    done = {(step.object, step.action) for step in plan.steps}
    for action, names in ((Action.FREE, goal.free), (Action.PLACE, wanted[Action.PLACE])):
        for name in names:
            if (name, action) not in done and any(step.object == name for step in plan.steps):
                yield Finding(1.0, f"{name}: no step says {action}")


def unmet(replay: Replay) -> Iterator[Finding]:
    """Clauses of the goal that do not hold of the clouds where the actions leave them."""
    scene = after = replay.scene
    names = {name for _, name in replay.taken}
    for name in names:
        after = after.with_cloud(name, move_points(after.clouds[name], replay.poses[name]))
    goal, situation = parse_goal(replay.plan.goal, scene), Situation(after)
    yield from (
        Finding(1.0, text) for text in goal.unmet(situation.relations, scene.fixed, situation.supports)
    )
    for name in goal.free:
        here, there = (each.clouds[name].mean(axis=0) for each in (scene, after))
        if name not in names or np.linalg.norm(there - here) <= DISTURBED:
            yield Finding(1.0, f"{name} is not taken elsewhere")


def off_wanted(replay: Replay) -> Iterator[Finding]:
    """How far surfaces of bodies are from where they shall be in the end, where that was given [m]."""
    for name, wanted in replay.plan.poses.items():
        surface = sample(replay.wholes[name], SURFACE)  # seen is another half of it once it is turned
        here, there = (move_parts((surface,), pose)[0] for pose in (replay.poses[name], np.array(wanted)))
        ways = (PointTree(one).query(other)[0].max() for one, other in ((here, there), (there, here)))
        yield Finding(float(max(ways)), name)
