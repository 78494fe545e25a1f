"""What a second hand does: it closes on an object where that is, keeps it there, and lets go of it there."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.failure import FailureLog, TransferFailure
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.placement import Placement
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.planner.transfer.stages import Stage, segments_of
from topple.planner.transfer.transfer import TRANSFER_LIMITS, Transfer, TransferLimits
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName, ToolState
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.situation import Situation

STAYS = Placement(np.eye(4), 1.0, "where it is")


@dataclass(frozen=True, eq=False)
class Grip:
    """A way to hold an object where it is.

    Attributes:
        transfer: What the arm does until its hand is closed.
        state: The grasp, with the joint values at which the arm then stands.
        hand: How the hand stands then.
    """

    transfer: Transfer
    state: Reached
    hand: ToolState


def grips(
    name: str,
    situation: Situation,
    arm: Arm,
    pose_base_to_world: FloatArray,
    q_start: FloatArray,
    log: FailureLog,
    *,
    avoid: Sequence[Grasp] = (),
    besides: Solids | None = None,
    seed: int = 0,
    limits: TransferLimits = TRANSFER_LIMITS,
) -> Iterator[Grip]:
    """Ways for fingers to close on an object that stays where it is, each with proven motions.

    Args:
        name: The object.
        situation: Where everything is.
        arm: The arm that holds.
        pose_base_to_world: (4, 4) where it stands.
        q_start: (n,) joint values now [rad].
        log: Takes down what others fail of.
        avoid: Grasps that failed: none near them is given.
        besides: Bodies that are in the way and no part of the scene: another arm, as it stands.
        seed: For inverse kinematics and sampling planners.
        limits: How hard to look and how fast to move.

    Yields:
        The best grasps first, each once.
    """
    handling = Handling(name, situation, arm, pose_base_to_world, (), seed, besides)
    found = grasp_candidates(name, situation, arm, wide=True)  # a thing is held that leans, and is not square
    grasps = [each for each in found if each.tool == ToolName.FINGERS and not any(map(each.near, avoid))]
    hands = handling.hands(grasps[: limits.grasps], q_start, log)
    given: list[Grasp] = []
    for state in handling.reached(hands, False, log):
        grasp = state.grasp
        if any(grasp.near(other) for other in given):
            continue
        approach = handling.approach(state, limits.approach, log)
        if approach.path is None or not approach.prove():
            continue
        move = Stage(SegmentKind.MOVE, handling.empty(grasp.opening), log)
        if move.search(q_start, approach.way[:1], seed, limits.budget) is None:
            continue
        given.append(grasp)
        ways = segments_of((move, approach), handling, grasp, STAYS, limits.speed, limits.straight_speed)
        hand = handling.closed(grasp)
        close = Segment(SegmentKind.GRASP, grasp.tool, hand, None, name, ways[-1].may_touch)
        yield Grip(Transfer(name, grasp, STAYS, (*ways, close), state.q, dict(log.reasons)), state, hand)


def letting_go(
    grip: Grip,
    situation: Situation,
    arm: Arm,
    pose_base_to_world: FloatArray,
    *,
    besides: Solids | None = None,
    limits: TransferLimits = TRANSFER_LIMITS,
) -> Transfer | TransferFailure:
    """Open the hand and draw it back, the object being where it was.

    Args:
        grip: How it is held.
        situation: Where everything is by then.
        arm: The arm that holds.
        pose_base_to_world: (4, 4) where it stands.
        besides: Bodies that are in the way and no part of the scene: another arm, as it stands.
        limits: How fast to move.
    """
    name, grasp = grip.transfer.object, grip.state.grasp
    handling = Handling(name, situation, arm, pose_base_to_world, (), 0, besides)
    log = FailureLog(frozenset(handling.bodies) - {name})
    back = handling.approach(grip.state, limits.retreat, log)
    if back.path is None:
        return log.failure(name)
    retreat = Stage(SegmentKind.RETREAT, handling.parting(grasp, STAYS), log)
    if not retreat.straight(back.way[::-1], grip.state.q) or not retreat.prove():
        return log.failure(name)
    ways = segments_of((retreat,), handling, grasp, STAYS, limits.speed, limits.straight_speed)
    return Transfer(name, grasp, STAYS, ways, retreat.way[-1], dict(log.reasons))
