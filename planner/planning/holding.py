"""What one arm takes while a second one holds what would not stand: all of it planned before either moves."""

from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import islice

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.hold import Hold
from topple.planner.failure import FailureLog, TransferFailure
from topple.planner.motion.other_arm import arm_bodies
from topple.planner.planning.step import Action, Context, NextStep, Station
from topple.planner.planning.tolerances import GRIPS
from topple.planner.planning.transfers import Transfers
from topple.planner.transfer.grip import Grip, grips, letting_go
from topple.planner.transfer.transfer import after
from topple.topology.bodies.solids import Solids
from topple.topology.situation import Situation

FIRST, SECOND = "the first arm's", "the second arm's"


def standing_by(whose: str, station: Station) -> Solids:
    """The bodies of an arm that stands still, however far its fingers are open."""
    arm = station.arm
    return arm_bodies(whose, arm, station.pose_base_to_world, station.q, (arm.on_the_way(0.0), arm.open_hand))


def held_steps(
    hold: Hold,
    chosen: Order,
    situation: Situation,
    context: Context,
    remaining: Callable[[str], Collection[str]],
    action: Callable[[str], Action],
) -> NextStep | TransferFailure:
    """The steps of a hold, from the hand that closes on an object until it is let go, or taken away itself.

    One arm moves at a time, the other stands, so each motion is certified against the other arm as something
    that stands in the way. Between its steps the first arm goes home. The two grasps are chosen together: a
    grip from which the rest cannot be done is given up for the next one.

    Args:
        hold: What is held, and while what is taken.
        chosen: The order it is of.
        situation: What is seen, or what should be there by now.
        context: What the steps are chosen in, with a second arm.
        remaining: What is still to be taken once an object is gone.
        action: What taking an object is for.

    Returns:
        The first step, with the others in `then`; or why there are none.
    """
    second = context.second
    assert second is not None, "a hold takes a second arm"
    log = FailureLog(frozenset(situation.scene.clouds) - {hold.object})
    found = grips(
        hold.object, situation, second.arm, second.pose_base_to_world, second.q, log,
        avoid=context.avoid.get(hold.object, ()), besides=standing_by(FIRST, context.station),
        seed=context.seed,
    )  # fmt: skip
    failure: TransferFailure | None = None
    for grip in islice(found, GRIPS):
        steps = _steps(grip, hold, chosen, situation, context, remaining, action)
        if isinstance(steps, NextStep):
            return steps
        failure = failure or steps
    return failure or log.failure(hold.object)


def _steps(
    grip: Grip,
    hold: Hold,
    chosen: Order,
    situation: Situation,
    context: Context,
    remaining: Callable[[str], Collection[str]],
    action: Callable[[str], Action],
) -> NextStep | TransferFailure:
    """The steps with one grip, or what the first of them that fails fails of."""
    second = context.second
    assert second is not None
    arm, base = second.arm, second.pose_base_to_world
    holding = arm_bodies(SECOND, arm, base, grip.state.q, (grip.hand,))
    home = replace(context.station, q=np.asarray(context.station.arm.home))
    taking = replace(context, besides=holding)
    steps: list[NextStep] = []
    for name in hold.meanwhile(chosen.order):
        found = Transfers(situation, taking).aside(name, remaining(name))
        if isinstance(found, TransferFailure):
            return found
        why = f"the second arm holds {hold.object}: {hold.because}"
        steps.append(NextStep(found, action(name), why, chosen))
        situation, taking = after(situation, found), replace(taking, station=home)
    away, name = standing_by(FIRST, home), hold.object
    steps[0] = replace(steps[0], grip=grip.transfer)
    if hold.until != name:
        left = letting_go(grip, situation, arm, base, besides=away)
        if isinstance(left, TransferFailure):
            return left
        steps[-1] = replace(steps[-1], let_go=left)
    else:
        there = replace(context, station=Station(arm, base, grip.state.q), besides=away)
        last = Transfers(situation, there, held=grip.state).aside(name, remaining(name))
        if isinstance(last, TransferFailure):
            return last
        why = f"the second arm holds it, and it would not stand without {hold.since}"
        steps.append(NextStep(last, action(name), why, chosen, by_second=True))
    return replace(steps[0], then=tuple(steps[1:]))
