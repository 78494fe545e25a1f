"""What a plan leads to: orders that are kept, and a goal that is reached."""

import networkx as nx
import numpy as np

from topple.planner.decide.goal import parse_goal
from topple.planner.formats.plan_format import Plan, Step
from topple.planner.formats.verification import BROKEN, Residual, Worst
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene


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
    waits = Worst("steps that wait for nothing and should", "1")
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
    from topple.planner.decide.dependency import dependencies
    from topple.planner.decide.tolerances import LIKELY

    again = Worst(BROKEN, "1")
    against = {(edge.first, edge.then) for step in plan.steps for edge in step.against}
    edges = [
        (edge.first, edge.then)
        for edge in dependencies(scene).dependencies
        if edge.confidence >= LIKELY or (edge.first, edge.then) not in against
    ]
    graph: nx.DiGraph[str] = nx.DiGraph(edges)
    group = {name: i for i, names in enumerate(nx.strongly_connected_components(graph)) for name in names}
    never = len(plan.steps)
    # what goes along with a container that is kept upright need not go before it
    along = {(held.object, step.object) for step in plan.steps for held in step.attachments if step.upright}
    broken = [
        f"{then} before {before}"
        for before, then in edges
        if then in first
        and group[before] != group[then]
        and (before, then) not in along
        and first.get(before, never) > first[then]
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
    from topple.topology.situation import Situation

    up = np.array(plan.up)
    after = scene
    for step in plan.steps:
        pose = _at_rest(step, up)
        for held in step.attachments:
            cloud = after.clouds[held.object]
            after = after.with_cloud(held.object, cloud @ pose[:3, :3].T + pose[:3, 3])
    goal = parse_goal(plan.goal, scene)
    situation = Situation(after)
    missing = list(goal.unmet(situation.relations, scene.fixed, situation.supports))
    taken = {step.object for step in plan.steps if step.action == "free"}
    missing += [f"{name} is not taken" for name in goal.free if name not in taken]
    worst = Worst("goal clauses unmet", "1")
    worst.note(float(len(missing)), "; ".join(missing))
    return worst.residual()


def _at_rest(step: Step, up: FloatArray) -> FloatArray:
    pose = np.array(step.placement.pose_before_to_after)
    pose[:3, 3] -= step.placement.drop * up
    return pose
