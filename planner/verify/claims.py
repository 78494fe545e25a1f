"""What a plan says of its scene, its grasps and what is kept upright, held against these."""

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.grasp.grasp import KINDS, GraspKind
from topple.planner.grasp.score import score_of
from topple.planner.verify.bodies import completed_of, parts_of
from topple.planner.verify.tolerances import ROUNDED_SCORE, SAME, UPWARD
from topple.topology.bodies.matter import MATTER
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.situation import Situation


def check_claims(plan: PlanData) -> tuple[Residual, ...]:
    """Check what can be checked of a plan by itself.

    Args:
        plan: The plan.

    Returns:
        Residuals: scores that are not what their terms make, marks of what is kept upright, and the order.
    """
    scores = Worst("scores against their terms", "1", ROUNDED_SCORE)
    upright = Worst("steps upright that are not to be, or the other way round", "1")
    for index, step in enumerate(plan.steps):
        where = f"step {index + 1} ({step.object})"
        grasp = step.grasp
        if grasp.terms and grasp.kind in KINDS:
            try:
                off = abs(score_of(GraspKind(grasp.kind), grasp.terms) - grasp.score)
            except KeyError as error:
                off = 1.0
                where = f"{where}: a {grasp.kind} has a term {error}"
            scores.note(off, where, index)
        if step.upright != (step.object in plan.upright):
            upright.count(where, index)
    order = Worst("order against the steps", "1")
    order.note(float(plan.order != [step.object for step in plan.steps]), ", ".join(plan.order))
    return scores.residual(), upright.residual(), order.residual()


def check_scene(plan: PlanData, situation: Situation) -> tuple[Residual, ...]:
    """Check whether a plan is of a scene.

    Args:
        plan: The plan.
        situation: What was seen.

    Returns:
        Residuals: the angle between their up directions, how far the plan's bodies stand out beyond those of
        the scene, and objects that never move in one of them alone.
    """
    tilt = Worst("up of the plan against the scene's", "rad", UPWARD)
    bodies = Worst("bodies of the plan beyond the scene's", "m", SAME)
    scene = situation.scene
    cosine = float(np.clip(np.array(plan.up) @ situation.up, -1.0, 1.0))
    tilt.note(float(np.arccos(cosine)), f"the plan has {list(plan.up)}, the scene {situation.up.tolist()}")
    shown = parts_of(plan) if len(scene.viewpoints) else completed_of(plan)  # nothing is hidden then
    for name in scene.names:
        faces = [joggled_sides(part) for part in situation.solids[name]]
        corners = np.vstack(shown[name])
        bodies.note(float(np.min([beyond(each, corners) for each in faces], axis=0).max()), name)
    fixed = Worst("objects fixed in the plan or the scene alone", "1")
    odd = {thing.name for thing in plan.objects if thing.fixed} - {MATTER} ^ set(scene.fixed)
    fixed.note(float(len(odd)), ", ".join(sorted(odd)))
    return tilt.residual(), bodies.residual(), fixed.residual()
