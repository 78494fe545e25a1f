"""How much of what a hand holds by force the weight in it takes, as a plan's bodies have it."""

from collections.abc import Mapping

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.grasp.grasp import GraspKind
from topple.planner.grasp.hand import hand_shape
from topple.planner.grasp.load import cup_load, jaw_load, weight_of
from topple.planner.grasp.suction import cup_shape
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.verify.bodies import parts_of
from topple.planner.verify.replay import SegmentReplay
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import moved
from topple.topology.geometry.samples import volume_and_centre


class ForceCheck:
    """Collects the loads of the grasps it is shown.

    Args:
        plan: The plan.
        arm: The arm.
        masses: In [kg], of what was weighed; the others are guessed from their volume.
    """

    def __init__(self, plan: PlanData, arm: Arm, masses: Mapping[str, float]) -> None:
        self.arm, self._up, self._masses, self._parts = arm, np.array(plan.up), masses, parts_of(plan)
        self.loads: dict[int, float] = {}
        """By index of a step, the share of what pads or cup resist; above 1 what is held slips or turns."""

    def look(self, piece: SegmentReplay) -> None:
        """Weigh what is in the hand once it has closed."""
        if piece.segment.kind != "grasp" or piece.step.object not in piece.held:
            return
        if piece.step.grasp.kind == GraspKind.PUSH:
            return  # it stays on the table
        parts = {name: moved(self._parts[name], to_tool) for name, to_tool in piece.held.items()}
        lumps = {name: volume_and_centre(np.vstack(each), each) for name, each in parts.items()}
        weights = [weight_of(volume, self._masses.get(name)) for name, (volume, _) in lumps.items()]
        weight = sum(weights)
        if weight <= 0.0:
            return
        centre = np.average([middle for _, middle in lumps.values()], axis=0, weights=weights)
        down = np.array(piece.step.grasp.pose_tool_to_world)[:3, :3].T @ -self._up
        if piece.segment.tool == ToolName.SUCTION:
            lever, tilt = float(np.hypot(*centre[:2])), float(np.arccos(np.clip(down[2], -1.0, 1.0)))
            self.loads[piece.index] = cup_load(lever, weight, cup_shape(self.arm), tilt)
        else:
            own = np.vstack(parts[piece.step.object])
            self.loads[piece.index] = self._of_pads(piece, weight, centre, down, own)

    def _of_pads(
        self, piece: SegmentReplay, weight: float, centre: FloatArray, down: FloatArray, own: FloatArray
    ) -> float:
        hand, width = hand_shape(self.arm), np.array([piece.step.grasp.width])
        depth = np.array([max(hand.tip - float(own[:, 2].min()), 0.0)])
        friction = GRASP_TOLERANCES.friction
        return float(jaw_load(centre[None], down[None], weight, width, depth, hand, friction)[0])
