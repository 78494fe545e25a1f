"""Whether things that are pushed come to lie where a plan has them: each push is played in PyBullet."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import JointTrajectory, PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.grasp.grasp import GraspKind
from topple.planner.placement.pushed import pushed
from topple.planner.tolerances import DISTURBED, TURNED
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.bodies import completed_of, parts_of
from topple.planner.verify.replay import SegmentReplay
from topple.robots.arm.arm import Arm
from topple.topology.bodies.solids import moved

DRIVEN = (SegmentKind.APPROACH, SegmentKind.SLIDE, SegmentKind.RETREAT)


@dataclass(eq=False)
class PushCheck:
    """Collects how far things end that are pushed from where they should, in the segments it is shown.

    Attributes:
        plan: The plan.
        arm: The arm.
        masses: In [kg], of what was weighed.
        friction: Coefficients of surfaces that were tried.
    """

    plan: PlanData
    arm: Arm
    masses: Mapping[str, float]
    friction: Mapping[str, float]
    shift: Worst = field(default_factory=lambda: Worst("shift of what is pushed", "m", DISTURBED))
    turn: Worst = field(default_factory=lambda: Worst("turn of what is pushed", "rad", TURNED))
    others: Worst = field(default_factory=lambda: Worst("disturbed by what is pushed", "1", 1.0))

    def __post_init__(self) -> None:
        self._parts, self._whole = parts_of(self.plan), completed_of(self.plan)
        self._driven: list[JointTrajectory] = []

    def look(self, piece: SegmentReplay) -> None:
        """Take down what is driven, and play it where it ends."""
        if piece.step.grasp.kind != GraspKind.PUSH or piece.segment.kind not in DRIVEN:
            return
        if piece.segment.kind == SegmentKind.APPROACH:
            self._driven = []
        if (motion := piece.segment.motion) is not None:
            rows = (np.array(each) for each in (motion.times, motion.positions, motion.velocities))
            self._driven.append(JointTrajectory(*rows))
        if piece.segment.kind != SegmentKind.RETREAT or not self._driven:
            return
        name = piece.step.object
        bodies = {other: moved(self._parts[other], pose) for other, pose in piece.before.items()}
        bodies[name] = moved(self._whole[name], piece.before[name])
        found = pushed(
            name, bodies, [thing.name for thing in self.plan.objects if thing.fixed], self.arm,
            np.array(self.plan.pose_base_to_world), self._driven, piece.segment.hand.opening,
            np.array(piece.step.placement.pose_before_to_after), np.array(self.plan.up),
            self.masses, self.friction,
        )  # fmt: skip
        where = f"step {piece.index + 1} ({name})"
        self.shift.note(found.shift, where, piece.index)
        self.turn.note(found.turn, where, piece.index)
        self.others.note(found.others, f"{where}: {found.disturbed}", piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found."""
        return self.shift.residual(), self.turn.residual(), self.others.residual()
