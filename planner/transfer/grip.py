"""What a second hand does: it closes on an object where that is, keeps it there, and lets go of it there."""

from collections.abc import Sequence

import numpy as np

from topple.planner.failure import FailureLog, TransferFailure
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.shape import shapes_of
from topple.planner.grasp.surroundings import Dropped
from topple.planner.placement.placement import Placement
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.limits import TRANSFER_LIMITS
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.planner.transfer.stages import Stage, segments_of
from topple.planner.transfer.transfer import Transfer
from topple.topology.base.arrays import FloatArray

STAYS = Placement(np.eye(4), 1.0, "where it is")


class Grips:
    """Ways for a hand to hold an object that stays where it is, fingers first.

    Args:
        handling: What is asked about the object.
        q_start: (n,) joint values now [rad].
        log: Takes down what is left out and why.
        avoid: Grasps that failed: none near them is among these.

    Attributes:
        states: In which the open hand is free, best grasps first. Each grasp is there with the hand turned
            half as well, and with the arm bent in two ways: equal for the object, not for what is beside it.
    """

    def __init__(
        self, handling: Handling, q_start: FloatArray, log: FailureLog, avoid: Sequence[Grasp]
    ) -> None:
        self._handling, self._q_start, self._log = handling, q_start, log
        name, situation, dropped = handling.name, handling.situation, Dropped(log.reasons, log.barring)
        tools = sorted(shapes_of(handling.arm).values(), key=lambda one: not one.tool.gripper.limits.opening)
        grasps = [
            grasp
            for tool in tools  # fingers hold what leans and is not square, a cup what is too wide for them
            for grasp in grasp_candidates(name, situation, tools=[tool], wide=True, dropped=dropped)
            if not any(map(grasp.near, avoid))
        ]
        hands = handling.hands(grasps[: TRANSFER_LIMITS.grasps], q_start, log)
        self.states = list(handling.reach(hands, False, log))

    def prove(self, state: Reached) -> Transfer | None:
        """Plan and prove the motions until the hand is closed in a state; None, noted, without a proof."""
        grasp, handling, limits = state.grasp, self._handling, TRANSFER_LIMITS
        approach = handling.approach(state, limits.approach, self._log)
        if approach.path is None or not approach.prove():
            return None
        move = Stage(SegmentKind.MOVE, handling.checker(SegmentKind.MOVE, grasp), self._log)
        if move.search(self._q_start, approach.way[:1], handling.seed, limits.rounds) is None:
            return None
        ways = segments_of((move, approach), grasp, limits)
        hand = handling.hand(grasp).closed(grasp)
        close = Segment(SegmentKind.GRASP, grasp.tool, hand, None, handling.name, ways[-1].may_touch)
        return Transfer(handling.name, grasp, STAYS, (*ways, close), state.q, dict(self._log.reasons))


def letting_go(state: Reached, handling: Handling) -> Transfer | TransferFailure:
    """Open the hand and draw it back, the object being where it was.

    Args:
        state: How it is held.
        handling: What is asked about the object, everything being where it is by then.
    """
    name, grasp, limits = handling.name, state.grasp, TRANSFER_LIMITS
    log = FailureLog(frozenset(handling.bodies) - {name})
    back = handling.approach(state, limits.retreat, log)
    if back.path is None:
        return log.failure(name)
    retreat = Stage(SegmentKind.RETREAT, handling.checker(SegmentKind.RETREAT, grasp, STAYS), log)
    if not retreat.straight(back.way[::-1], state.q) or not retreat.prove():
        return log.failure(name)
    ways = segments_of((retreat,), grasp, limits)
    return Transfer(name, grasp, STAYS, ways, retreat.way[-1], dict(log.reasons))
