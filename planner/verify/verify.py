"""Plans checked again by other means: python-fcl state by state, PyBullet, limits, order, physics, goal."""

from dataclasses import replace

import msgspec
import numpy as np

from topple.planner.decide.hold import fixture_assumptions
from topple.planner.formats.plan_robot import arm_from
from topple.planner.formats.plan_structs import ObjectData, PlanData
from topple.planner.formats.verification import BROKEN, UNFOUND, Residual, Verification, not_evaluated
from topple.planner.verify.between import BetweenCheck
from topple.planner.verify.by_fcl import FclCheck
from topple.planner.verify.claims import check_claims, check_scene
from topple.planner.verify.clouds import CloudCheck
from topple.planner.verify.force import ForceCheck
from topple.planner.verify.handed import HandedCheck, own_bodies
from topple.planner.verify.handled import HandCheck
from topple.planner.verify.motions import check_motions
from topple.planner.verify.outcome import (
    check_actions,
    check_goal,
    check_poses,
    check_precedence,
    check_reasons,
)
from topple.planner.verify.proofs import UNASKED, Proofs
from topple.planner.verify.replay import Replay, SegmentReplay
from topple.planner.verify.rest import RestCheck
from topple.planner.verify.sight import UNSAID, SightCheck
from topple.planner.verify.tolerances import COARSE, STEP
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.matter import MATTER
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

NO_SCENE = "no scene was given"


def verify(
    plan: PlanData,
    scene: Scene | Situation | None = None,
    robot: Arm | str | None = None,
    *,
    step: float = STEP,
) -> Verification:
    """Check a plan by other means than it was made with.

    Trajectories are looked at every 0.002 rad with python-fcl, and every 0.01 rad with PyBullet, whose
    kinematics and hulls are its own; what may touch by intent has to have a reason and may not be pressed
    deeper; that nothing touches between these states is proven by certificates, derived again from the
    motions as they are written. Placements are let go in simulation. With the scene, seen points may not be
    entered, hands that come in where no camera saw have to say so, precedence is derived again, and the
    goal's relations are computed where the plan puts the clouds.

    Args:
        plan: The plan, fresh or read back from JSON.
        scene: What it was made for, or what was read of it; None: what needs clouds is not evaluated.
        robot: The arm or its name; the one the plan names where None, from the URDF it was made with.
        step: Spacing of the states [rad].

    Returns:
        The residuals, at most 0 where all is well, `inf` where not evaluated; with what they prove of each
        step, by which means, and what is not shown.

    Raises:
        InvalidInput: The plan's arm or its URDF is not found here and none was given, the URDF is another
            than the plan was made with, or the arm's joints or the scene's objects are not those of the plan.
        NotInstalled: PyBullet is not installed.
    """
    # here: a plan is made where PyBullet is not installed, too, and with it this module is imported
    from topple.planner.verify.by_bullet import BulletCheck

    arm = _arm(plan, robot)
    situation = None if scene is None else Situation.of(scene)
    scene = None if situation is None else situation.scene
    if situation is not None:
        _check_names(plan, situation.scene)
        plan = _among_matter(plan, situation)
    played, fcl_check, hands = Replay(plan, arm, step), FclCheck(plan, arm), HandCheck(plan, arm)
    handed = HandedCheck(plan, arm)
    clouds = None if scene is None else CloudCheck(plan, arm, scene)
    sight = None if situation is None else SightCheck(plan, arm, situation)
    masses = {} if scene is None else scene.masses
    between, force = BetweenCheck(plan, arm), ForceCheck(plan, arm, scene)
    proofs = Proofs(plan, between, force, masses, (step, COARSE * step))
    put: list[SegmentReplay] = []
    with BulletCheck(plan, arm) as bullet:
        for piece in played.segments():
            for check in (hands, handed, fcl_check, between, proofs):
                check.look(piece)
            for check in (bullet, force):
                check.look(_thinned(piece))
            for of_scene in (clouds, sight):
                if of_scene is not None:
                    of_scene.look(piece)
            if piece.segment.kind == "release":
                put.append(piece)
    rest = RestCheck(plan)
    for piece in put:
        rest.look(piece)
    residuals = [
        *played.residuals(),  # first: what is not in the hand meets what it is carried past
        *fcl_check.residuals(),
        *bullet.residuals(),
        *check_motions(plan, arm),
        *between.residuals(),
        *hands.residuals(),
        *handed.residuals(),
        *force.residuals(),
        *check_claims(plan),
        *check_precedence(plan, played.taken, situation),
        *rest.residuals(),
        check_poses(plan, played.poses),
    ]
    if scene is None or situation is None or clouds is None or sight is None:
        residuals += _left_out()
    else:
        residuals += [
            *clouds.residuals(),
            *sight.residuals(),
            *check_scene(plan, situation, arm),
            check_reasons(plan, situation),
            check_actions(plan, scene),
            check_goal(plan, played.poses, played.taken, scene),
        ]
    return Verification(
        tuple(residuals),
        fcl_check.states,
        (*rest.allowed, *fixture_assumptions(plan.clamped), *(() if sight is None else sight.said)),
        proofs.steps(residuals),
        proofs.whole(residuals),
        UNASKED,
    )


def _left_out() -> list[Residual]:
    return [
        not_evaluated(BROKEN, "1", NO_SCENE),
        not_evaluated("seen points entered", "m", NO_SCENE),
        not_evaluated("pressed into what it is put on or into", "m", NO_SCENE),
        not_evaluated("points outside of the plan's bodies", "m", NO_SCENE),
        not_evaluated("up of the plan against the scene's", "rad", NO_SCENE),
        not_evaluated("hidden sides of the plan beyond the scene's", "m", NO_SCENE),
        not_evaluated("base of the plan against the scene's", "m", NO_SCENE),
        not_evaluated("bodies of the plan beyond the scene's", "m", NO_SCENE),
        not_evaluated("objects fixed in the plan or the scene alone", "1", NO_SCENE),
        not_evaluated("assumptions of the scene or the arm left out", "1", NO_SCENE),
        not_evaluated(UNSAID, "1", NO_SCENE),
        not_evaluated(UNFOUND, "1", NO_SCENE),
        not_evaluated("actions that the goal does not ask for", "1", NO_SCENE),
        not_evaluated("goal clauses unmet", "1", NO_SCENE),
    ]


def _thinned(piece: SegmentReplay) -> SegmentReplay:
    """The piece with fewer states, its last one among them."""
    index = np.unique(np.append(np.arange(0, len(piece.states), COARSE), len(piece.states) - 1))
    return replace(piece, states=piece.states[index])


def _arm(plan: PlanData, robot: Arm | str | None) -> Arm:
    if isinstance(robot, Arm):
        arm = robot
    elif robot is None and plan.arm is not None:
        arm = arm_from(plan.arm, plan.robot)
    else:
        try:
            arm = robot_named(plan.robot if robot is None else robot)
        except InvalidInput as error:
            raise InvalidInput(
                f"the plan's arm {plan.robot!r} is not known here: give it ({error})"
            ) from error
    if list(arm.joints) != plan.joints:
        raise InvalidInput(
            f"the plan moves {', '.join(plan.joints)}; {arm.name} has {', '.join(arm.joints)}: give its arm"
        )
    return arm


def _among_matter(plan: PlanData, situation: Situation) -> PlanData:
    """The plan among what was seen that is no object, whatever it was made among."""
    if MATTER not in situation.solids:
        return plan
    parts = [part.tolist() for part in situation.solids[MATTER]]
    objects = [thing for thing in plan.objects if thing.name != MATTER]
    return msgspec.structs.replace(plan, objects=[*objects, ObjectData(MATTER, True, parts)])


def _check_names(plan: PlanData, scene: Scene) -> None:
    ours, theirs = {thing.name for thing in plan.objects} - {MATTER, *own_bodies(plan)}, set(scene.names)
    if ours != theirs:
        odd = ", ".join(sorted(ours ^ theirs))
        raise InvalidInput(f"the scene is not the one the plan was made for: {odd} is only in one of them")
