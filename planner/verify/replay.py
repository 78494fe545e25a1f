"""A plan played through: for every piece of it the arm's states, closely spaced, and where everything is."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from topple.planner.formats.plan_format import Plan, SegmentData, Step
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.topology.arrays import FloatArray


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
    """

    index: int
    step: Step
    segment: SegmentData
    states: FloatArray
    poses: dict[str, FloatArray]
    held: dict[str, FloatArray]

    @property
    def where(self) -> str:
        """Step and segment, in words."""
        return f"step {self.index + 1} ({self.step.object}), {self.segment.kind}"

    @property
    def hand(self) -> ToolState:
        """How the hand stands."""
        return ToolState(self.segment.hand.opening, self.segment.hand.cup_extension)

    @property
    def may_touch(self) -> frozenset[frozenset[str]]:
        """Pairs of names that are meant to touch."""
        return frozenset(frozenset(pair) for pair in self.segment.may_touch)


def replay(plan: Plan, step: float) -> Iterator[SegmentReplay]:
    """Play a plan.

    Args:
        plan: The plan.
        step: Largest change of a joint between two states [rad].

    Yields:
        Its segments in order. What is let go falls to where its placement says.
    """
    up = np.array(plan.up)
    poses = {thing.name: np.eye(4) for thing in plan.objects}
    q = np.array(plan.q_start)
    for index, part in enumerate(plan.steps):
        hold = {held.object: np.array(held.pose_start_to_tool) for held in part.attachments}
        after = np.array(part.placement.pose_before_to_after)
        after[:3, 3] -= part.placement.drop * up
        taken = False
        for segment in part.segments:
            if segment.kind == "release" and taken:
                for name in hold:
                    poses[name] = after @ poses[name]
            taken = segment.holding is not None
            rest = {name: pose for name, pose in poses.items() if not (taken and name in hold)}
            states = resampled(segment, q, step)
            q = states[-1]
            yield SegmentReplay(index, part, segment, states, rest, hold if taken else {})


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


def tool_poses(arm: Arm, plan: Plan, tool: str, states: FloatArray) -> FloatArray:
    """Poses (m, 4, 4) of a tool in the world."""
    return np.matmul(np.array(plan.pose_base_to_world), arm.tool_pose(states, tool))


def parts_of(plan: Plan) -> dict[str, list[FloatArray]]:
    """Convex parts (V, 3) of every object, where it was when the plan began [m]."""
    return {thing.name: [np.array(part) for part in thing.parts] for thing in plan.objects}


def whole_of(plan: Plan) -> dict[str, list[FloatArray]]:
    """The same with the hidden sides [m]."""
    return {thing.name: [np.array(part) for part in thing.whole or thing.parts] for thing in plan.objects}
