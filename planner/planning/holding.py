"""What one arm takes while another holds what would not stand: all of it planned before either moves."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.goal import Action
from topple.planner.decide.hold import Hold
from topple.planner.failure import FailureLog, TransferFailure
from topple.planner.motion.other_arm import arm_bodies, surface_points
from topple.planner.planning.step import Context, NextStep
from topple.planner.planning.tolerances import APART, GRIPS
from topple.planner.planning.transfers import Transfers
from topple.planner.transfer.grip import Grips, letting_go
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.prediction import after
from topple.planner.transfer.transfer import Transfer
from topple.robots.arm.arm import Arm, Station
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.solids import Solids
from topple.topology.kernels.neighbours import PointTree
from topple.topology.situation.situation import Situation

FIRST, SECOND = "the first arm's", "the second arm's"


def check_second(arm: Arm) -> None:
    """Refuse a second arm that cannot hold a thing where it is.

    Raises:
        InvalidInput: It has no fingers.
    """
    if not arm.hand_limits.opening:
        raise InvalidInput(f"{arm.name} has no fingers: a second arm holds with a parallel jaw")


def standing_by(prefix: str, station: Station) -> Solids:
    """The bodies of an arm that stands still, however far its fingers are open."""
    arm = station.arm
    return arm_bodies(
        prefix, arm, station.pose_base_to_world, station.q, (arm.on_the_way(0.0), arm.open_hand)
    )


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


@dataclass(frozen=True, eq=False)
class HoldPlanner:
    """Plans the steps of a hold: from the hand that closes until it lets go, or takes the object away itself.

    One arm moves at a time, the other stands, so each motion is certified against the other arm as something
    that stands in the way. Between its steps the arm that takes goes home. The two grasps, and which arm does
    which, are chosen together: of all grips of both arms those come first beside which the other hand has
    room, and one from which the rest cannot be done is given up for the next.

    Attributes:
        hold: What is held, and while what is taken.
        order: The order it is of.
        situation: What is seen, or what should be there by now.
        context: What the steps are chosen in, with a second arm.
        remaining: What is still to be taken once an object is gone.
        action: What taking an object is for.
    """

    hold: Hold
    order: Order
    situation: Situation
    context: Context
    remaining: Callable[[str], Collection[str]]
    action: Callable[[str], Action]

    def steps(self) -> NextStep | TransferFailure:
        """The first step, with the others in `then`; or why there are none."""
        first, second = self.context.station, self.context.second
        assert second is not None, "a hold takes a second arm"
        log = FailureLog(frozenset(self.situation.scene.clouds) - {self.hold.object})
        failure: TransferFailure | None = None
        choices = [*self._choices(first, second, log), *self._choices(second, first, log)]
        tried: list[_Choice] = []
        for choice in sorted(choices, key=lambda choice: -choice.room):
            if len(tried) >= GRIPS:
                break
            if any(map(choice.alike, tried)) or (grip := choice.grips.prove(choice.state)) is None:
                continue
            tried.append(choice)
            steps = self._steps(grip, choice)
            if isinstance(steps, NextStep):
                return steps
            failure = failure or steps
        return failure or log.failure(self.hold.object)

    def _choices(self, taker: Station, holder: Station, log: FailureLog) -> list[_Choice]:
        """The ways of one arm to hold the object, best grasps first, with the room they leave the other."""
        beside = standing_by(self._prefix(taker), taker)
        handling = self._handling_beside(holder, beside, self.situation)
        grips = Grips(handling, holder.q, log, self.context.avoid.get(self.hold.object, ()))
        if not grips.states:
            return []
        alone = Transfers(self.situation, replace(self.context, station=taker, obstacles={}))
        taken: list[FloatArray] = []
        for name in self.hold.meanwhile(self.order.order):
            states = np.array([hand.q for hand in alone.hands(name)]).reshape(-1, len(taker.arm.joints))
            taken.append(surface_points(taker.arm, taker.pose_base_to_world, states))
        q = np.array([state.q for state in grips.states])
        points = surface_points(holder.arm, holder.pose_base_to_world, q)
        found: list[_Choice] = []
        for state, own in zip(grips.states, points, strict=True):
            tree = PointTree(own)
            room = min(_apart(tree, other) for other in taken)
            found.append(_Choice(grips, state, taker, holder, room))
        return found

    def _steps(self, grip: Transfer, choice: _Choice) -> NextStep | TransferFailure:
        """The steps with one grip, or what the first of them that fails fails of."""
        hold, situation, taker, holder = self.hold, self.situation, choice.taker, choice.holder
        second = taker is self.context.second
        home = replace(taker, q=np.asarray(taker.arm.home))
        taking = replace(self.context, station=taker, obstacles=self._holder_bodies(holder, grip))
        steps: list[NextStep] = []
        for name in hold.meanwhile(self.order.order):
            found = Transfers(situation, taking).aside(name, self.remaining(name))
            if isinstance(found, TransferFailure):
                return found
            why = f"the other arm holds {hold.object}: {hold.because}"
            steps.append(NextStep(found, self.action(name), why, self.order, by_second=second))
            situation, taking = after(situation, found), replace(taking, station=home)
        away, name = standing_by(self._prefix(taker), home), hold.object
        steps[0] = replace(steps[0], grip=grip)
        if hold.until != name:
            left = letting_go(choice.state, self._handling_beside(holder, away, situation))
            if isinstance(left, TransferFailure):
                return left
            steps[-1] = replace(steps[-1], let_go=left)
        else:
            there = replace(self.context, station=replace(holder, q=grip.q_end), obstacles=away)
            last = Transfers(situation, there, held=choice.state).aside(name, self.remaining(name))
            if isinstance(last, TransferFailure):
                return last
            why = f"the arm that takes it holds it, and it would not stand without {hold.since}"
            steps.append(NextStep(last, self.action(name), why, self.order, by_second=not second))
        return replace(steps[0], then=tuple(steps[1:]))

    def _handling_beside(self, holder: Station, beside: Solids, situation: Situation) -> Handling:
        """Set up the handling of the held object, with the bodies of the other arm beside it."""
        return Handling(self.hold.object, situation, holder, seed=self.context.seed, obstacles=beside)

    def _holder_bodies(self, holder: Station, grip: Transfer) -> Solids:
        """The bodies of the arm that holds."""
        q, hand = grip.q_end, grip.segments[-1].hand
        return arm_bodies(self._prefix(holder), holder.arm, holder.pose_base_to_world, q, (hand,))

    def _prefix(self, station: Station) -> str:
        """Prefix of the names of an arm's bodies."""
        return SECOND if station is self.context.second else FIRST


def _apart(tree: PointTree, states: FloatArray) -> float:
    """How far [m] an arm in its states (m, P, 3) is from the other's points on average, `APART` at most."""
    if len(states) == 0:
        return 0.0
    gaps = tree.query(states.reshape(-1, 3), distance_upper_bound=APART)[0].reshape(states.shape[:2])
    return float(np.minimum(gaps.min(axis=1), APART).mean())
