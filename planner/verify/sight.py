"""Where hands come in, held against what cameras saw to be empty by then."""

from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.grasp.fingers import coming_unseen
from topple.planner.grasp.grasp import Grasp, GraspKind
from topple.planner.grasp.hand import hand_shape
from topple.planner.grasp.suction import cup_shape
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.bodies import tool_poses
from topple.planner.verify.replay import SegmentReplay
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.situation.situation import Situation

UNSAID = "hands that come in unseen and are not said to"


@dataclass(eq=False)
class SightCheck:
    """Judges the hand of each step, in the situation that the steps before it leave.

    Attributes:
        plan: The plan.
        arm: The arm.
        situation: What was seen; followed from step to step.
        said: Steps that say it of a hand that was seen all the way, in sentences.
    """

    plan: PlanData
    arm: Arm
    situation: Situation
    unsaid: Worst = field(default_factory=lambda: Worst(UNSAID, "1"))
    said: list[str] = field(default_factory=list[str])

    def __post_init__(self) -> None:
        self._poses = {thing.name: np.eye(4) for thing in self.plan.objects}
        self._hand = hand_shape(self.arm) if ToolName.FINGERS in self.arm.tools else None
        self._cup = cup_shape(self.arm) if ToolName.SUCTION in self.arm.tools else None

    def look(self, piece: SegmentReplay) -> None:
        """Judge the way in of a segment that is one, to where the arm then is."""
        if piece.segment.kind != SegmentKind.APPROACH:
            return
        self._follow(piece.before)
        step, tool = piece.step, piece.segment.tool
        pads = self.arm.tool(tool).pads(step.grasp.width)
        pose = tool_poses(self.arm, self.plan, tool, piece.states[-1:])[0] @ pads
        kind = GraspKind.SUCTION if tool == ToolName.SUCTION else GraspKind.PINCH
        grasp = Grasp(step.object, kind, pose, 0.0, piece.segment.hand.opening, 0.0)
        (unseen,) = coming_unseen([grasp], self.situation, self._hand, self._cup)
        if unseen and not step.unseen:
            self.unsaid.count(f"step {piece.index + 1} ({step.object})", piece.index)
        elif step.unseen and not unseen:
            self.said.append(
                f"step {piece.index + 1} ({step.object}) says that its hand comes in unseen: "
                "in this scene cameras saw all of its way to be empty"
            )

    def residuals(self) -> tuple[Residual, ...]:
        """Steps that keep quiet about a hand that comes in unseen."""
        return (self.unsaid.residual(),)

    def _follow(self, poses: dict[str, FloatArray]) -> None:
        """Move what lies elsewhere than it did."""
        for name in self.situation.scene.names:
            if name not in poses:
                self.situation = self.situation.without(name)
        for name, pose in poses.items():
            if not np.array_equal(pose, self._poses[name]):
                self.situation = self.situation.moved([name], pose @ inverse(self._poses[name]))
                self._poses[name] = pose
