"""What a plan leads to: orders that are kept, things that stay where they are put, a goal that is reached."""

import networkx as nx
import numpy as np
from scipy.spatial import ConvexHull

from topple.planner.goal import parse_goal
from topple.planner.place.drops import Drops
from topple.planner.plan_format import Plan, Step
from topple.planner.solids import moved
from topple.planner.verify.record import Residual, Worst
from topple.planner.verify.replay import Beat, parts_of, whole_of
from topple.robots.poses import angle_between
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene

SHIFT = 0.015  # [m] a thing may move until it rests: its body is a guess from noisy points
TURN = 0.35  # [rad] and turn: it lies down on the face next to the one that was meant
ROUNDED = 1e-4  # [m] what six digits and joggled hulls are off


def check_precedence(plan: Plan, scene: Scene | None) -> tuple[Residual, ...]:
    """Check that nothing is taken before what has to go first.

    Args:
        plan: The plan.
        scene: What was seen; its dependencies are derived again. Edges of cycles are left out, and what a
            step says to go against if it is more likely wrong than right.

    Returns:
        Residuals: dependencies of the plan, of the scene, and steps that do not wait for those before them.
    """
    first = {step.object: index for index, step in reversed(list(enumerate(plan.steps)))}
    last = {step.object: index for index, step in enumerate(plan.steps)}
    own = Worst("dependencies of the plan broken", "1")
    waits = Worst("steps that wait for nobody and should", "1")
    late = [f"{e.then} before {e.first}" for e in plan.dependencies if first[e.first] > last[e.then]]
    own.note(float(len(late)), "; ".join(late))
    lazy: list[str] = []
    for edge in plan.dependencies:
        index = last[edge.then]
        if first[edge.first] < index and first[edge.first] not in plan.steps[index].after:
            lazy.append(f"step {index + 1} ({edge.then}) for {edge.first}")
    waits.note(float(len(lazy)), "; ".join(lazy))
    if scene is None:
        return own.residual(), waits.residual()
    from topple.planner.dependency import dependencies
    from topple.planner.turn import LIKELY

    again = Worst("dependencies of the scene broken", "1")
    against = {(edge.first, edge.then) for step in plan.steps for edge in step.against}
    edges = [
        (edge.first, edge.then)
        for edge in dependencies(scene).dependencies
        if edge.confidence >= LIKELY or (edge.first, edge.then) not in against
    ]
    graph: nx.DiGraph[str] = nx.DiGraph(edges)
    group = {name: i for i, names in enumerate(nx.strongly_connected_components(graph)) for name in names}
    never = len(plan.steps)
    broken = [
        f"{then} before {before}"
        for before, then in edges
        if then in first and group[before] != group[then] and first.get(before, never) > first[then]
    ]
    again.note(float(len(broken)), "; ".join(broken))
    return own.residual(), waits.residual(), again.residual()


def check_goal(plan: Plan, scene: Scene) -> Residual:
    """Check the goal's relations on the clouds where the plan puts them.

    Args:
        plan: The plan.
        scene: What was seen.

    Returns:
        The number of clauses that do not hold.
    """
    from topple.topology.relate import relate
    from topple.topology.support import supports

    up = np.array(plan.up)
    after = scene
    for step in plan.steps:
        pose = _at_rest(step, up)
        for held in step.attachments:
            cloud = after.clouds[held.object]
            after = after.with_cloud(held.object, cloud @ pose[:3, :3].T + pose[:3, 3])
    goal = parse_goal(plan.goal, scene)
    relations = relate(after)
    missing = list(goal.unmet(relations, scene.fixed, supports(after, relations)))
    taken = {step.object for step in plan.steps if step.action == "free"}
    missing += [f"{name} is not taken" for name in goal.free if name not in taken]
    worst = Worst("goal clauses unmet", "1")
    worst.note(float(len(missing)), "; ".join(missing))
    return worst.residual()


def check_rest(plan: Plan, before: "list[Beat]") -> tuple[Residual, ...]:
    """Let everything fall from where it is let go, in PyBullet, among the other bodies held in place.

    What is put on a table is asked with the sides that nobody saw, which it may have to stand on; what is put
    on or into another thing was lowered by what was seen of both.

    Args:
        plan: The plan.
        before: The beats in which something is put down, one for each step.

    Returns:
        Residuals: how far things shift and turn; what is put into a container may roll but has to stay in it;
        and how far what was seen of a body is outside of the whole that is taken for it.
    """
    shift, turn = Worst("shift after letting go", "m", SHIFT), Worst("turn after letting go", "rad", TURN)
    out = Worst("outside of its container after letting go", "m")
    up, parts, whole = np.array(plan.up), parts_of(plan), whole_of(plan)
    for beat in before:
        step = beat.step
        into, name = step.placement.into, step.object
        riding = {held.object for held in step.attachments} - {name}
        bodies = {n: moved(parts[n], pose) for n, pose in beat.poses.items() if n not in riding}
        if into is None:
            bodies[name] = moved(whole[name], beat.poses[name])
        release = np.eye(4)
        release[:3, 3] += step.placement.drop * up
        with Drops(name, bodies, up) as drops:
            after, centre = drops.rest(release), drops.centre_of_mass
        place = after[:3, :3] @ centre + after[:3, 3]
        where = f"step {beat.index + 1} ({name})"
        if into is not None and step.placement.rest.startswith("within"):
            out.note(_beyond(place, np.vstack(bodies[into]), up), where)
        else:
            shift.note(float(np.linalg.norm(place - centre)), where)
            turn.note(angle_between(np.eye(4), after), where)
    return shift.residual(), turn.residual(), out.residual(), _around(plan)


def _around(plan: Plan) -> Residual:
    """How far what was seen of the objects sticks out of the bodies that are taken for whole."""
    worst = Worst("bodies outside of their wholes", "m", ROUNDED)
    for thing in plan.objects:
        hulls = [ConvexHull(np.array(part), qhull_options="QJ").equations for part in thing.whole]
        if hulls:
            seen = np.vstack(thing.parts)
            beyond = [(seen @ faces[:, :3].T + faces[:, 3]).max(axis=1) for faces in hulls]
            worst.note(float(np.min(beyond, axis=0).max()), thing.name)
    return worst.residual()


def _beyond(place: FloatArray, points: FloatArray, up: FloatArray) -> float:
    """How far a place (3,) is beside the level outline of points, or below them [m]."""
    from topple.planner.place.stacking import inset
    from topple.planner.solids import level_axes

    axes = np.stack(level_axes(up))
    aside = -float(inset(points @ axes.T, (place @ axes.T)[None])[0])
    below = float((points @ up).min() - place @ up)
    return max(0.0, aside, below)


def _at_rest(step: Step, up: FloatArray) -> FloatArray:
    pose = np.array(step.placement.pose_before_to_after)
    pose[:3, 3] -= step.placement.drop * up
    return pose
