"""Plans checked again by other means than they were made with, claim by claim."""

from collections.abc import Sequence

import msgspec

from topple.planner.decide.hold import fixture_assumptions
from topple.planner.formats.plan_robot import arm_from
from topple.planner.formats.plan_structs import ObjectData, PlanData
from topple.planner.verify.claims import OF_PLANS, OF_STEPS, UNASKED, Claim
from topple.planner.verify.hand import own_bodies
from topple.planner.verify.replay import Replay
from topple.planner.verify.rest import falls
from topple.planner.verify.sight import said
from topple.planner.verify.tolerances import STEP
from topple.planner.verify.verification import Proof, StepProofs, Verification
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.matter import MATTER
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


def verify(
    plan: PlanData,
    scene: Scene | Situation | None = None,
    robot: Arm | str | None = None,
    *,
    step: float = STEP,
) -> Verification:
    """Check a plan by other means than it was made with.

    The claims of the table are walked in order, each by its residuals. Trajectories are looked at every
    0.002 rad with python-fcl; what may touch by intent has to have a reason and may not be pressed into seen
    points; that nothing touches between these states is proven by certificates, derived again from the
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
    arm = _arm(plan, robot)
    situation = None if scene is None else Situation.of(scene)
    if situation is not None:
        _check_names(plan, situation.scene)
        plan = _among_matter(plan, situation)
    replay = Replay(plan, arm, step, situation)
    residuals = [check.residual(replay) for claim in (*OF_STEPS, *OF_PLANS) for check in claim.checks]
    found = {residual.name: residual for residual in residuals}

    def proofs(claims: Sequence[Claim], of: int | None = None) -> tuple[Proof, ...]:
        return tuple(proof for claim in claims if (proof := claim.proof(replay, found, of)) is not None)

    return Verification(
        tuple(residuals),
        sum(len(piece.states) for piece in replay.pieces),
        (*falls(replay), *fixture_assumptions(plan.clamped), *(() if situation is None else said(replay))),
        tuple(
            StepProofs(index, one.object, one.action, proofs(OF_STEPS, index))
            for index, one in enumerate(plan.steps)
        ),
        proofs(OF_PLANS),
        UNASKED,
    )


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
