"""What the hand does to objects: grasps, what is held, places, what is kept upright, what may touch."""

from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.bodies import off_by, parts_of, tool_poses
from topple.planner.verify.grip import distance
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import NEAR, OFF, REACHED, TILT
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName
from topple.robots.collision.fcl_bodies import fcl_body
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import transformed


@dataclass(eq=False)
class HandCheck:
    """Collects what is wrong with how objects are handled in the segments it is shown.

    Attributes:
        plan: The plan.
        arm: The arm.
    """

    plan: PlanData
    arm: Arm
    grasp: Worst = field(default_factory=lambda: Worst("tool at the grasp", "m", OFF))
    reach: Worst = field(default_factory=lambda: Worst("object at the tool", "m", REACHED))
    held: Worst = field(default_factory=lambda: Worst("attachment against grasp", "m", OFF))
    place: Worst = field(default_factory=lambda: Worst("tool at the place", "m", OFF))
    tilt: Worst = field(default_factory=lambda: Worst("tilt of what is kept upright", "rad", TILT))
    excuse: Worst = field(default_factory=lambda: Worst("pairs that may touch without a reason", "1"))

    def __post_init__(self) -> None:
        self._parts = parts_of(self.plan)
        self._up = np.array(self.plan.up)
        self._hand = {link for tool in self.arm.tools.values() for link in tool.links}
        self._fixed = {thing.name for thing in self.plan.objects if thing.fixed}

    def look(self, piece: SegmentReplay) -> None:
        """Check one segment."""
        kind = piece.segment.kind
        grasp = np.array(piece.step.grasp.pose_tool_to_world)
        self._excuses(piece)
        pads = self.arm.tool(piece.segment.tool).pads(piece.step.grasp.width)
        ends = tool_poses(self.arm, self.plan, piece.segment.tool, piece.states[-1:])[0] @ pads
        if kind == "approach":
            self.grasp.note(off_by(ends, grasp), piece.where, piece.index)
            self.reach.note(self._to_object(piece, ends), piece.where, piece.index)
        if kind == "grasp":
            told = {
                held.object: pads @ np.array(held.pose_start_to_tool)
                for held in piece.step.attachments
                if held.tool == piece.segment.tool
            }
            for name, to_tool in piece.held.items():
                off = off_by(to_tool, told[name]) if name in told else 1.0  # not said at all
                self.held.note(off, f"{piece.where}: {name}", piece.index)
        if kind == "place":
            wanted = np.array(piece.step.placement.pose_before_to_after) @ grasp
            self.place.note(off_by(ends, wanted), piece.where, piece.index)
        if piece.step.upright and piece.step.object in piece.held:
            poses = tool_poses(self.arm, self.plan, piece.segment.tool, piece.states)
            now = piece.before[piece.step.object][:3, :3]
            turned = poses[:, :3, :3] @ piece.held[piece.step.object][:3, :3] @ now.T @ self._up
            tilted = float(np.arccos(np.clip(turned @ self._up, -1.0, 1.0)).max())
            self.tilt.note(tilted, piece.where, piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found."""
        found = (self.grasp, self.reach, self.held, self.place, self.tilt, self.excuse)
        return tuple(worst.residual() for worst in found)

    def _to_object(self, piece: SegmentReplay, tool: FloatArray) -> float:
        """Distance from the object to the room between the pads, or to the lip [m]."""
        pose = piece.poses.get(piece.step.object, np.eye(4))
        to_tool = np.linalg.inv(tool) @ pose
        jaw = self.arm.jaw if piece.segment.tool == ToolName.FINGERS else None
        half = np.zeros(3)
        if jaw is not None:
            half = np.array([jaw.pad_size[0], piece.segment.hand.opening, jaw.pad_size[1]]) / 2.0
        parts = [transformed(part, to_tool) for part in self._parts[piece.step.object]]
        return distance(half, parts)

    def _excuses(self, piece: SegmentReplay) -> None:
        """Only the hand and what it handles, what that stands on, and neighbours at the fingers may touch."""
        name = piece.step.object
        carried = {held.object for held in piece.step.attachments}
        for pair in piece.may_touch:
            links, others = pair & set(self.arm.links), pair - set(self.arm.links)
            fine = bool(links) and links <= self._hand and len(others) == 1
            if fine and piece.segment.kind == "move":
                fine = False
            elif fine and not others <= carried:
                fine = piece.segment.kind in ("approach", "grasp", "lift") and not others & self._fixed
            if not links and name in pair:
                (other,) = pair - {name}
                fine = self._near(piece, other)
            if not fine:
                self.excuse.count(f"{piece.where}: {' and '.join(sorted(pair))}", piece.index)

    def _near(self, piece: SegmentReplay, other: str) -> bool:
        """Whether the object in the hand is next to another one where it is taken or put."""
        import fcl

        if piece.segment.kind == "place" and piece.step.placement.into == other:
            return True
        name, standing = piece.step.object, piece.poses
        if piece.segment.kind not in ("grasp", "lift") or other not in standing or name not in piece.before:
            return False
        for a in self._parts[name]:
            for b in self._parts[other]:
                first, second = _placed(a, piece.before[name]), _placed(b, standing[other])
                if fcl.distance(first, second, fcl.DistanceRequest()) < NEAR:
                    return True
        return False


def _placed(part: FloatArray, pose: FloatArray) -> object:
    return fcl_body(transformed(part, pose))
