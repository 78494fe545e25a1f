"""A thing pushed over an edge: to its side, along the table, and back, each motion certified."""

from collections.abc import Callable, Sequence

import numpy as np

from topple.planner.failure import Check, FailedCheck, FailureLog, TransferFailure
from topple.planner.fallbacks import Fallback
from topple.planner.placement.slides import Slide
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.segments import SegmentKind
from topple.planner.transfer.stages import Stage, segments_of
from topple.planner.transfer.transfer import TRANSFER_LIMITS, Transfer, TransferLimits
from topple.topology.arrays import FloatArray

NO_EDGE = "no edge that it can be pushed over"
ASTRAY = "place: it would not go there as it is pushed, or no hand would reach it there"


def plan_push(
    handling: Handling,
    ways: Sequence[Slide],
    q_start: FloatArray,
    *,
    holds: Callable[[Transfer], bool] | None = None,
    limits: TransferLimits = TRANSFER_LIMITS,
) -> Transfer | TransferFailure:
    """Plan pushing a thing along the table to where it hangs over an edge.

    Args:
        handling: What is asked about the object.
        ways: Where it may be pushed, best first.
        q_start: (n,) joint values now [rad].
        holds: Whether the thing goes where a push has it; where None, it does.
        limits: How hard to look and how fast to move.

    Returns:
        The push as a transfer whose fingers stay open: move, approach, grasp, slide, release and retreat;
        or why there is none.
    """
    log = FailureLog(frozenset(handling.bodies) - {handling.name})
    if not ways:
        failed = FailedCheck(SegmentKind.PLACE, Check.ROOM, NO_EDGE)
        return TransferFailure(handling.name, {NO_EDGE: 1}, None, failed)
    for way in ways:
        hands = handling.hands([way.grasp], q_start, log)
        for state in handling.reached(hands, False, log):
            found = _pushed(handling, way, state, q_start, log, limits)
            if found is None:
                continue
            if holds is None or holds(found):
                return found
            log.note(SegmentKind.PLACE, Check.STAND, ASTRAY)
            break  # however the arm stands, the fingers push the same
    return log.failure(handling.name)


def _pushed(
    handling: Handling,
    way: Slide,
    state: Reached,
    q_start: FloatArray,
    log: FailureLog,
    limits: TransferLimits,
) -> Transfer | None:
    """The push that begins in a state; None, noted, where a motion of it is not proven."""
    inwards = way.ahead - handling.up  # down beside the thing and towards it: the fingers come to its side
    inwards /= np.linalg.norm(inwards)
    approach = handling.approach(state, limits.approach, log, inwards)
    slide = approach if approach.path is None else handling.slide(state, way.placement, log)
    if slide.path is None:
        return None
    retreat = handling.withdrawal(state, slide.way[-1], way.placement, limits.retreat, inwards, log)
    if retreat.path is None or not (approach.prove() and slide.prove() and retreat.prove()):
        return None
    move = Stage(SegmentKind.MOVE, handling.empty(state.grasp.opening), log)
    if move.search(q_start, approach.way[:1], handling.seed, limits.rounds) is None:
        return None
    segments = segments_of(
        (move, approach, slide, retreat), handling, state.grasp, way.placement,
        limits.speed, limits.straight_speed,
    )  # fmt: skip
    return Transfer(
        handling.name, state.grasp, way.placement, segments, retreat.way[-1], dict(log.reasons),
        fallbacks=(Fallback.TO_THE_EDGE,),
    )  # fmt: skip
