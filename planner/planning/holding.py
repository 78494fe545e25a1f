"""What one arm takes while another holds what would not stand: all of it planned before either moves."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from topple.planner.decide.arrange import Order
from topple.planner.decide.hold import Hold
from topple.planner.failure import FailureLog, TransferFailure
from topple.planner.motion.other_arm import arm_bodies, surface_points
from topple.planner.planning.step import Action, Context, NextStep, Station
from topple.planner.planning.tolerances import APART, GRIPS
from topple.planner.planning.transfers import Transfers
from topple.planner.transfer.grip import Grip, Grips, letting_go
from topple.planner.transfer.handling import Reached
from topple.planner.transfer.transfer import after
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName, ToolState
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.errors import InvalidInput
from topple.topology.situation import Situation

FIRST, SECOND = "the first arm's", "the second arm's"


def check_second(arm: Arm) -> None:
    """Refuse a second arm that cannot hold a thing where it is.

    Raises:
        InvalidInput: It has no fingers.
    """
    if ToolName.FINGERS not in arm.tools:
        raise InvalidInput(f"{arm.name} has no fingers: a second arm holds with a parallel jaw")


def standing_by(prefix: str, station: Station) -> Solids:
    """The bodies of an arm that stands still, however far its fingers are open."""
    arm = station.arm
    return arm_bodies(
        prefix, arm, station.pose_base_to_world, station.q, (arm.on_the_way(0.0), arm.open_hand)
    )


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
    that stands in the way. Between its steps the arm that takes goes home. The two grasps, and which arm does
    which, are chosen together: of all grips of both arms those come first beside which the other hand has
    room, and one from which the rest cannot be done is given up for the next.

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
    first, second = context.station, context.second
    assert second is not None, "a hold takes a second arm"
    log = FailureLog(frozenset(situation.scene.clouds) - {hold.object})
    failure: TransferFailure | None = None
    choices = [
        choice
        for taker, holder in ((first, second), (second, first))
        for choice in _choices(hold, taker, holder, chosen, situation, context, log)
    ]
    tried: list[_Choice] = []
    for choice in sorted(choices, key=lambda choice: -choice.room):
        if len(tried) >= GRIPS:
            break
        if any(map(choice.alike, tried)) or (grip := choice.grips.proven(choice.state)) is None:
            continue
        tried.append(choice)
        steps = _steps(grip, hold, choice.taker, choice.holder, chosen, situation, context, remaining, action)
        if isinstance(steps, NextStep):
            return steps
        failure = failure or steps
    return failure or log.failure(hold.object)


@dataclass(frozen=True, eq=False)
class _Choice:
    """A way to hold an object, and the room it leaves.

    Attributes:
        grips: What it is one of.
        state: How the arm stands then.
        taker: The arm that takes.
        holder: The arm that holds.
        room: How far apart the arms stay on average [m], where the other one takes what leaves least.
    """

    grips: Grips
    state: Reached
    taker: Station
    holder: Station
    room: float

    def alike(self, other: "_Choice") -> bool:
        """Whether another one stands in the way of a hand in nearly the same way."""
        if self.holder is not other.holder or not self.state.grasp.near(other.state.grasp):
            return False
        own, its = self.state.grasp.pose_tool_to_world, other.state.grasp.pose_tool_to_world
        return float(own[:3, 1] @ its[:3, 1]) > 0.0  # and not turned half


def _choices(
    hold: Hold,
    taker: Station,
    holder: Station,
    chosen: Order,
    situation: Situation,
    context: Context,
    log: FailureLog,
) -> list[_Choice]:
    """The ways of one arm to hold an object, best grasps first, each with the room it leaves the other."""
    grips = Grips(
        hold.object, situation, holder.arm, holder.pose_base_to_world, holder.q, log,
        avoid=context.avoid.get(hold.object, ()), obstacles=standing_by(_prefix(taker, context), taker),
        seed=context.seed,
    )  # fmt: skip
    if not grips.states:
        return []
    alone = Transfers(situation, replace(context, station=taker, obstacles={}))
    taken: list[FloatArray] = []
    for name in hold.meanwhile(chosen.order):
        states = np.array([hand.q for hand in alone.hands(name)]).reshape(-1, len(taker.arm.joints))
        taken.append(surface_points(taker.arm, taker.pose_base_to_world, states))
    q = np.array([state.q for state in grips.states])
    found: list[_Choice] = []
    for state, points in zip(
        grips.states, surface_points(holder.arm, holder.pose_base_to_world, q), strict=True
    ):
        tree = KDTree(points)
        room = min(_apart(tree, other) for other in taken)
        found.append(_Choice(grips, state, taker, holder, room))
    return found


def _apart(tree: KDTree, states: FloatArray) -> float:
    """How far [m] an arm in its states (m, P, 3) is from the other's points on average, `APART` at most."""
    if len(states) == 0:
        return 0.0
    gaps = tree.query(states.reshape(-1, 3), distance_upper_bound=APART)[0].reshape(states.shape[:2])
    return float(np.minimum(gaps.min(axis=1), APART).mean())


def _holding(holder: Station, state: Reached, hand: ToolState, context: Context) -> Solids:
    """The bodies of the arm that holds."""
    return arm_bodies(_prefix(holder, context), holder.arm, holder.pose_base_to_world, state.q, (hand,))


def _prefix(station: Station, context: Context) -> str:
    return SECOND if station is context.second else FIRST


def _steps(
    grip: Grip,
    hold: Hold,
    taker: Station,
    holder: Station,
    chosen: Order,
    situation: Situation,
    context: Context,
    remaining: Callable[[str], Collection[str]],
    action: Callable[[str], Action],
) -> NextStep | TransferFailure:
    """The steps with one grip, or what the first of them that fails fails of."""
    arm, base, second = holder.arm, holder.pose_base_to_world, taker is context.second
    holding = _holding(holder, grip.state, grip.hand, context)
    home = replace(taker, q=np.asarray(taker.arm.home))
    taking = replace(context, station=taker, obstacles=holding)
    steps: list[NextStep] = []
    for name in hold.meanwhile(chosen.order):
        found = Transfers(situation, taking).aside(name, remaining(name))
        if isinstance(found, TransferFailure):
            return found
        why = f"the other arm holds {hold.object}: {hold.because}"
        steps.append(NextStep(found, action(name), why, chosen, by_second=second))
        situation, taking = after(situation, found), replace(taking, station=home)
    away, name = standing_by(_prefix(taker, context), home), hold.object
    steps[0] = replace(steps[0], grip=grip.transfer)
    if hold.until != name:
        left = letting_go(grip, situation, arm, base, obstacles=away)
        if isinstance(left, TransferFailure):
            return left
        steps[-1] = replace(steps[-1], let_go=left)
    else:
        there = replace(context, station=Station(arm, base, grip.state.q), obstacles=away)
        last = Transfers(situation, there, held=grip.state).aside(name, remaining(name))
        if isinstance(last, TransferFailure):
            return last
        why = f"the arm that takes it holds it, and it would not stand without {hold.since}"
        steps.append(NextStep(last, action(name), why, chosen, by_second=not second))
    return replace(steps[0], then=tuple(steps[1:]))
