"""A plan followed action by action: where everything is and what is in the hand is what the arm makes of it.

Nothing is believed of what a plan declares. An object moves because the hand closed on it or the cup sealed,
and went somewhere; it stays where the hand let go of it. What the plan says of the same is held against that.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import PlanData, SegmentData, Step
from topple.planner.formats.verification import Residual, Worst
from topple.planner.placement.away import IN_HAND, Away
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.bodies import off_by, tool_poses
from topple.planner.verify.grip import Grip
from topple.planner.verify.tolerances import OFF, OPENED
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName, ToolState
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class SegmentReplay:
    """One segment as it is played.

    Attributes:
        index: Of the step.
        step: The step.
        segment: The segment.
        states: (m, n) joint values, densely along the motion; one state for grasp and release.
        poses: Rigid transforms (4, 4) since the plan began of the objects that are not in the hand.
        held: What is in the hand: transforms (4, 4) from the world at the plan's begin to the tool.
        before: Transforms (4, 4) since the plan began of all objects, as the step began; what was handed on
            or went into a box by then is left out.
    """

    index: int
    step: Step
    segment: SegmentData
    states: FloatArray
    poses: dict[str, FloatArray]
    held: dict[str, FloatArray]
    before: dict[str, FloatArray]

    @property
    def where(self) -> str:
        """Step and segment, in words."""
        return f"step {self.index + 1} ({self.step.object}), {self.segment.kind}"

    @property
    def at_rest(self) -> int:
        """The state in which what is held lies where it lay or is to lie: the last of a way down."""
        return -1 if self.segment.kind == SegmentKind.PLACE else 0

    @property
    def hand(self) -> ToolState:
        """How the hand stands."""
        return ToolState(self.segment.hand.opening, self.segment.hand.cup_extension)

    @property
    def may_touch(self) -> frozenset[frozenset[str]]:
        """Pairs of names that are meant to touch."""
        return frozenset(frozenset(pair) for pair in self.segment.may_touch)


@dataclass
class Replay:
    """Follows a plan, and collects what its actions and what it declares disagree in.

    Attributes:
        plan: The plan.
        arm: The arm.
        step: Largest change of a joint between two states [rad].
        taken: Objects that were taken and let go again, with the indices of the steps, in order.
    """

    plan: PlanData
    arm: Arm
    step: float
    taken: list[tuple[int, str]] = field(default_factory=list[tuple[int, str]])
    grips: Worst = field(default_factory=lambda: Worst("grasps that hold nothing", "1"))
    idle: Worst = field(default_factory=lambda: Worst("steps that do not move their object", "1"))
    kept: Worst = field(default_factory=lambda: Worst("objects in the hand when a step ends", "1"))
    told: Worst = field(default_factory=lambda: Worst("what is said to be in the hand and is not", "1"))
    told_into: Worst = field(default_factory=lambda: Worst("put into what it is not over", "1"))
    hand: Worst = field(default_factory=lambda: Worst("hand that changes while it holds", "m", OPENED))
    place: Worst = field(default_factory=lambda: Worst("object against its place", "m", 2.0 * OFF))

    def __post_init__(self) -> None:
        self.poses = {thing.name: np.eye(4) for thing in self.plan.objects}
        self._held: dict[str, FloatArray] = {}
        self._gone: set[str] = set()
        self._tool, self._hand = "", ToolState()
        self._grip = Grip(self.plan, self.arm)

    def segments(self) -> Iterator[SegmentReplay]:
        """Play the plan; yields its segments in order."""
        q = np.array(self.plan.q_start)
        for index, part in enumerate(self.plan.steps):
            before = {name: pose for name, pose in self.poses.items() if name not in self._gone}
            moved = len(self.taken)
            for segment in part.segments:
                where = f"step {index + 1} ({part.object}), {segment.kind}"
                states = resampled(segment, q, self.step)
                q = states[-1]
                hand = ToolState(segment.hand.opening, segment.hand.cup_extension)
                if segment.kind == SegmentKind.GRASP:
                    self._take(index, part, segment, hand, q, where)
                elif segment.kind == SegmentKind.RELEASE:
                    self._let_go(index, part, hand, q, before, where)
                elif self._held:
                    self._keep(index, hand, where)
                self._say(index, segment, where)
                self._hand = hand
                away = self._gone.union(self._held)
                rest = {name: pose for name, pose in self.poses.items() if name not in away}
                yield SegmentReplay(index, part, segment, states, rest, dict(self._held), before)
            where = f"step {index + 1} ({part.object})"
            if part.placement.how in IN_HAND and part.object in self._held:
                self._hand_on(index, part, q, before, where)
            if part.placement.how == Away.BIN or part.placement.how in IN_HAND:
                self._gone.update(name for _, name in self.taken[moved:])
            if self._held:
                self.kept.note(len(self._held), f"{where}: {', '.join(self._held)}", index)
            if not any(name == part.object for _, name in self.taken[moved:]):
                self.idle.count(f"{where}: it is never taken and let go", index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found."""
        found = (self.grips, self.idle, self.kept, self.told, self.told_into, self.hand, self.place)
        return tuple(worst.residual() for worst in found)

    def _take(
        self, index: int, part: Step, segment: SegmentData, hand: ToolState, q: FloatArray, where: str
    ) -> None:
        """Close the hand: what is then in it moves with it."""
        tool = tool_poses(self.arm, self.plan, segment.tool, q[None])[0]
        words = "something is in it already" if self._held else None
        words = f"{part.object} is gone by then" if part.object in self._gone else words
        pads = tool @ self.arm.tool(segment.tool).pads(part.grasp.width)
        words = words or self._grip.fails(part, segment.tool, self._hand, hand, pads, self.poses)
        if words is not None:
            self.grips.count(f"{where}: {words}", index)
            return
        self._tool = segment.tool
        riding = [held.object for held in part.attachments if held.object != part.object]
        for name in (part.object, *riding):
            if name == part.object or self._grip.rides(name, part.object, self.poses):
                self._held[name] = inverse(tool) @ self.poses[name]
            else:
                self.grips.count(f"{where}: {name} does not lie in {part.object}", index)

    def _keep(self, index: int, hand: ToolState, where: str) -> None:
        """A hand that holds stays as it is."""
        self.hand.note(abs(hand.opening - self._hand.opening), where, index)
        self.hand.note(abs(hand.cup_extension - self._hand.cup_extension), where, index)

    def _let_go(
        self,
        index: int,
        part: Step,
        hand: ToolState,
        q: FloatArray,
        before: dict[str, FloatArray],
        where: str,
    ) -> None:
        """Open the hand: what was in it lies there, or falls as far as its step says."""
        if not self._held:
            return
        if self._tool == ToolName.FINGERS and hand.opening <= self._hand.opening + OPENED:
            self.told.count(f"{where}: the pads stay closed", index)
            return
        tool = tool_poses(self.arm, self.plan, self._tool, q[None])[0]
        declared = np.array(part.placement.pose_before_to_after)
        fall = part.placement.drop * np.array(self.plan.up)
        for name, to_tool in self._held.items():
            pose = tool @ to_tool
            if name in before:
                self.place.note(off_by(pose, declared @ before[name]), f"{where}: {name}", index)
            self.poses[name] = pose.copy()
            self.poses[name][:3, 3] -= fall
            self.taken.append((index, name))
        self._held = {}
        into = part.placement.into
        if into is not None and not self._grip.rides(part.object, into, self.poses):
            self.told_into.count(f"{where}: it is not over {into}", index)

    def _hand_on(
        self, index: int, part: Step, q: FloatArray, before: dict[str, FloatArray], where: str
    ) -> None:
        """What is in the hand leaves it by other means, from where the step says."""
        tool = tool_poses(self.arm, self.plan, self._tool, q[None])[0]
        declared = np.array(part.placement.pose_before_to_after)
        for name, to_tool in self._held.items():
            self.poses[name] = tool @ to_tool
            self.place.note(off_by(self.poses[name], declared @ before[name]), f"{where}: {name}", index)
            self.taken.append((index, name))
        self._held = {}

    def _say(self, index: int, segment: SegmentData, where: str) -> None:
        """Hold what a segment says of its hand against what is in it."""
        if (segment.holding is not None) != bool(self._held) or (
            segment.holding is not None and segment.holding not in self._held
        ):
            truth = ", ".join(self._held) or "nothing"
            words = f"{where}: {segment.holding or 'nothing'} is said, {truth} is in it"
            self.told.count(words, index)


def resampled(segment: SegmentData, q: FloatArray, step: float) -> FloatArray:
    """States (m, n) along a segment's motion, `step` [rad] apart in the joint that moves most.

    Args:
        segment: The segment; without a motion the arm stays at q.
        q: (n,) where the arm is before it.
        step: Spacing.
    """
    if segment.motion is None:
        return q[None]
    rows = np.array(segment.motion.positions)
    if len(rows) < 2:
        return rows
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(rows, axis=0)).max(axis=1))])
    count = max(int(np.ceil(way[-1] / step)), 1)
    at = np.linspace(0.0, way[-1], count + 1)
    return np.stack([np.interp(at, way, column) for column in rows.T], axis=1)
