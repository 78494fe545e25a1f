"""Whether things end where a plan says that they go: clear of everything, held out, in a bin, on an area."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import AwayData, PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.placement.away import BODIES, IN_HAND, Away
from topple.planner.placement.tolerances import BIN_WALL, LIFT_CLEAR
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.bodies import parts_of, tool_poses
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import FALL, OFF, SHORT
from topple.robots.arm.arm import Arm
from topple.robots.collision.fcl_bodies import fcl_body
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import moved

HANDED = (
    "away where the plan does not say",
    "short of 15 cm from everything",
    "held out beside the point",
    "off the area that is vouched for",
    "falls otherwise than it says",
)


@dataclass(eq=False)
class HandedCheck:
    """Collects how things that are taken end beside where they are to go.

    Attributes:
        plan: The plan.
        arm: The arm.
    """

    plan: PlanData
    arm: Arm
    other: Worst = field(default_factory=lambda: Worst(HANDED[0], "1"))
    near: Worst = field(default_factory=lambda: Worst(HANDED[1], "m", SHORT))
    beside: Worst = field(default_factory=lambda: Worst(HANDED[2], "m", OFF))
    off: Worst = field(default_factory=lambda: Worst(HANDED[3], "m", OFF))
    fall: Worst = field(default_factory=lambda: Worst(HANDED[4], "m", FALL))

    def __post_init__(self) -> None:
        self._parts, self._away = parts_of(self.plan), self.plan.away
        how = "" if self._away is None else self._away.how
        for index, step in enumerate(self.plan.steps):
            told = step.placement.how
            fine = ("on", "within", "") if step.action == "place" else ("on", "within", how)
            if told not in fine:
                self.other.count(f"step {index + 1} ({step.object}): {told or 'table'}", index)

    def look(self, piece: SegmentReplay) -> None:
        """Look at where a step lets go of its object, and at how it ends."""
        name, place = piece.step.object, piece.step.placement
        how, last = place.how, piece.segment is piece.step.segments[-1]
        if self._away is None:
            return
        if how in IN_HAND and last:
            self.fall.note(abs(place.drop) + float(place.falls), piece.where, piece.index)
        if how in IN_HAND and last and name in piece.held:
            tool = tool_poses(self.arm, self.plan, piece.segment.tool, piece.states[-1:])[0]
            own = moved(self._parts[name], tool @ piece.held[name])
            if how == Away.LIFT:
                gap = min(
                    (self._gap(own, other, pose) for other, pose in piece.poses.items()), default=np.inf
                )
                self.near.note(LIFT_CLEAR - gap, piece.where, piece.index)
            else:
                point, corners = np.array(self._away.pose_to_world)[:3, 3], np.vstack(own)
                aside = np.maximum(corners.min(axis=0) - point, point - corners.max(axis=0))
                self.beside.note(float(aside.max()), piece.where, piece.index)
        elif how == Away.ZONE and last and name in piece.poses:
            own = moved(self._parts[name], inverse(np.array(self._away.pose_to_world)) @ piece.poses[name])
            beyond = np.abs(np.vstack(own)[:, :2]).max(axis=0) - np.array(self._away.size[:2]) / 2.0
            self.off.note(float(beyond.max()), piece.where, piece.index)
        elif how == Away.BIN and piece.segment.kind == SegmentKind.RELEASE and name in piece.poses:
            self._falls(piece, self._away)

    def _falls(self, piece: SegmentReplay, away: AwayData) -> None:
        """Look how high over the floor of its bin a thing is let go."""
        name, up = piece.step.object, np.array(self.plan.up)
        floor = float(np.array(away.pose_to_world)[:3, 3] @ up) + BIN_WALL
        lowest = float((np.vstack(moved(self._parts[name], piece.poses[name])) @ up).min())
        falls = float(piece.step.placement.falls)
        self.fall.note(abs(lowest - floor) + falls, piece.where, piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found."""
        return tuple(worst.residual() for worst in (self.other, self.near, self.beside, self.off, self.fall))

    def _gap(self, own: Sequence[FloatArray], other: str, pose: FloatArray) -> float:
        """Distance [m] from convex parts in the world to an object that stands, or lies elsewhere by now."""
        import fcl

        bodies = [fcl_body(part) for part in moved(self._parts[other], pose)]
        return min(
            float(fcl.distance(fcl_body(part), body, fcl.DistanceRequest()))
            for part in own
            for body in bodies
        )


def own_bodies(plan: PlanData) -> frozenset[str]:
    """Names of what stands in a plan beside the scene: the bin or the area for what is taken."""
    return (
        frozenset()
        if plan.away is None
        else frozenset({BODIES[Away(plan.away.how)]} if plan.away.how in BODIES else ())
    )
