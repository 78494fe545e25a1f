"""What a plan says of its scene, its grasps and what is kept upright, held against these."""

import numpy as np

from topple.planner.decide.goal import Action
from topple.planner.fallbacks import Fallback
from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.grasp.grasp import KINDS, GraspKind
from topple.planner.grasp.score import score_of
from topple.planner.verify.bodies import completed_of, off_by, parts_of
from topple.planner.verify.handed import own_bodies
from topple.planner.verify.tolerances import ROUNDED_SCORE, ROUNDED_TIME, SAME, UPWARD
from topple.robots.arm.arm import Arm
from topple.topology.bodies.matter import MATTER
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.situation.situation import Situation


def check_claims(plan: PlanData) -> tuple[Residual, ...]:
    """Check what can be checked of a plan by itself.

    Args:
        plan: The plan.

    Returns:
        Residuals: scores that are not what their terms make, marks of what is kept upright and of what makes
        room, the order, and what is told of all motions together.
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
    buffers = Worst("steps said to make room or come unseen, or not, against the rest", "1")
    for index, step in enumerate(plan.steps):
        again = any(later.object == step.object for later in plan.steps[index + 1 :])
        making_room = bool(plan.poses) and step.action == Action.REMOVE
        unseen = step.unseen == (Fallback.UNSEEN in step.fallbacks)
        if step.buffer != making_room or (step.buffer and not again) or not unseen:
            buffers.count(f"step {index + 1} ({step.object})", index)
    parts = [part for step in plan.steps for part in step.segments]
    driven = [part for part in parts if part.motion is not None]
    proofs = Worst("proofs against those of the motions", "1")
    proofs.note(
        float(plan.certified != all(part.certified for part in driven)), f"certified: {plan.certified}"
    )
    for part in parts:
        if (part.certified and part.motion is None) or (part.certified and part.witness is not None):
            proofs.count(f"{part.kind}: certified, and nothing moves or something meets")
    seconds = sum(part.motion.times[-1] for part in driven if part.motion is not None)
    lasts = Worst("seconds against those of the motions", "s", ROUNDED_TIME)
    lasts.note(abs(plan.seconds - seconds), f"{plan.seconds:g} s, the motions take {seconds:g} s")
    order = Worst("order against the steps", "1")
    order.note(float(plan.order != [step.object for step in plan.steps]), ", ".join(plan.order))
    found = (scores, upright, order, buffers, proofs, lasts)
    return tuple(worst.residual() for worst in found)


def check_scene(plan: PlanData, situation: Situation, arm: Arm) -> tuple[Residual, ...]:
    """Check whether a plan is of a scene.

    Args:
        plan: The plan.
        situation: What was seen.
        arm: The arm.

    Returns:
        Residuals: the angle between their up directions, how far apart the arm stands, how far the plan's
        bodies stand out beyond those of the scene, as seen and with the sides that nobody saw, and objects
        that never move in one of them alone; and what the plan does not say that was assumed.
    """
    tilt = Worst("up of the plan against the scene's", "rad", UPWARD)
    base = Worst("base of the plan against the scene's", "m", SAME)
    bodies = Worst("bodies of the plan beyond the scene's", "m", SAME)
    hidden = Worst("hidden sides of the plan beyond the scene's", "m", SAME)
    scene = situation.scene
    cosine = float(np.clip(np.array(plan.up) @ situation.up, -1.0, 1.0))
    tilt.note(float(np.arccos(cosine)), f"the plan has {list(plan.up)}, the scene {situation.up.tolist()}")
    if scene.robot_base is not None:
        told = np.array(plan.pose_base_to_world)
        at, its = (f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in (told[:3, 3], scene.robot_base[:3, 3]))
        base.note(off_by(told, scene.robot_base), f"the plan has it at {at}, the scene at {its}")
    for worst, said, own in (
        (bodies, parts_of(plan), situation.solids),
        (hidden, completed_of(plan), situation.with_level_undersides().completed),
    ):
        for name in scene.names:
            faces = [joggled_sides(part) for part in own[name]]
            corners = np.vstack(said[name])
            worst.note(float(np.min([beyond(each, corners) for each in faces], axis=0).max()), name)
    quiet = Worst("assumptions of the scene or the arm left out", "1")
    for words in (*scene.assumptions, *arm.assumptions):
        if words not in plan.assumptions:
            quiet.count(words)
    fixed = Worst("objects fixed in the plan or the scene alone", "1")
    odd = {thing.name for thing in plan.objects if thing.fixed} - {MATTER, *own_bodies(plan)} ^ set(
        scene.fixed
    )
    fixed.note(float(len(odd)), ", ".join(sorted(odd)))
    return (
        tilt.residual(),
        base.residual(),
        bodies.residual(),
        hidden.residual(),
        fixed.residual(),
        quiet.residual(),
    )
